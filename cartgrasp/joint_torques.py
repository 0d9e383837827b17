"""What an arm's joints bear at one posture: torques `tau = Jᵀ F + tau_0`, affine in the wrench F that the arm gives."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np

from .checks import MAX_NUMBER, shown
from .errors import UsageError
from .frames import Array

Point = tuple[float, float, float]


@dataclass(frozen=True, eq=False)
class JointTorques:
    """An arm of n joints at a posture. `jacobian` (6, n) maps joint velocity to the twist [linear; angular] of the
    contact frame {a}, in {a}; `gravity_torque` (n,) carries the arm itself; |torque| <= `torque_limit` (n,), N·m (N
    for a sliding joint), `inf` for none. Torques that carry the arm are within the limits: it can stand idle. Joints
    are called by `names`, else by their numbers from 0."""

    jacobian: Array
    gravity_torque: Array
    torque_limit: Array
    names: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        for field in ("jacobian", "gravity_torque", "torque_limit"):
            try:
                values = np.array(getattr(self, field), dtype=float)
            except (TypeError, ValueError) as error:
                raise UsageError(f"joint torques: {field}: {shown(getattr(self, field))} are no numbers") from error
            values.setflags(write=False)
            object.__setattr__(self, field, values)
        if self.jacobian.ndim != 2 or len(self.jacobian) != 6 or not self.jacobian.size:
            raise UsageError(f"joint torques: jacobian: shape {self.jacobian.shape} is not (6, number of joints)")
        n = self.jacobian.shape[1]
        for field in ("gravity_torque", "torque_limit"):
            shape = getattr(self, field).shape
            if shape != (n,):
                raise UsageError(f"joint torques: {field}: shape {shape} is not ({n},), one number for each joint")
        if not self.names:
            object.__setattr__(self, "names", tuple(map(str, range(n))))
        if len(self.names) != n:
            raise UsageError(f"joint torques: names: {n} are needed, {len(self.names)} given")
        if not max(np.abs(self.jacobian).max(), np.abs(self.gravity_torque).max()) <= MAX_NUMBER:
            what = f"not finite, or beyond {MAX_NUMBER:g}"
            raise UsageError(f"joint torques: the jacobian or the gravity torque has a value that is {what}")
        if not (self.torque_limit >= 0).all():
            raise UsageError(f"joint torques: torque_limit: {self.torque_limit.tolist()} has a value that is not >= 0")
        for joint in np.flatnonzero(np.abs(self.gravity_torque) > self.torque_limit):
            needed, limit = abs(self.gravity_torque[joint]), self.torque_limit[joint]
            what = f"joint torques: {self.labels[joint]} needs {needed:g} N·m to carry the arm itself"
            raise UsageError(f"{what}, more than its limit of {limit:g} N·m; choose another posture")

    @property
    def n_joints(self) -> int:
        return len(self.gravity_torque)

    @property
    def labels(self) -> tuple[str, ...]:
        """`joint 3`, or as a joint is called."""
        return tuple(name if name.startswith("joint") else f"joint {name}" for name in self.names)

    def torques(self, wrench_a: Array) -> Array:
        """Joint torques (..., n), N·m, under a wrench (..., 6) on the cart in {a}."""
        return np.asarray(wrench_a) @ self.jacobian + self.gravity_torque


@runtime_checkable
class PostureSource(Protocol):
    """Says what an arm's joints bear with the hand at a contact."""

    def joints_at(self, contact: Point, yaw: float) -> JointTorques:
        """At the contact in {b}, m, with {a} turned by `yaw`; the same object as long as the posture is the same. Where
        there is no posture it raises a `UsageError` that says why."""
        ...
