"""Bounds of single components of an arm's wrench, N and N·m per axis of {a}, and of what its single joints bear."""

from __future__ import annotations

import numpy as np

from cartgrasp.arms import Arm
from cartgrasp.errors import UsageError
from cartgrasp.wheels import GRAVITY

from .limit import Limit, LimitRows

PUSH_ONLY = "push only"
PLAIN = LimitRows()
PUSH_ONLY_ROWS = LimitRows(
    lower=np.array([0.0, *PLAIN.lower[1:]]),
    upper=PLAIN.upper,
    lower_names=(PUSH_ONLY, *PLAIN.lower_names[1:]),
)


class WrenchBox(Limit):
    """A symmetric box: |F| <= limit."""

    def rows(self, arm: Arm) -> LimitRows:
        return LimitRows(lower=-arm.wrench_limit, upper=arm.wrench_limit)


class PushOnly(Limit):
    """An open hand pushes and can't pull: fx >= 0. Friction implies it unless mu is 0."""

    def rows(self, arm: Arm) -> LimitRows:
        return PUSH_ONLY_ROWS


class Payload(Limit):
    """An arm rated for a payload gives at most its weight up or down: |fz| <= payload · 9.81 m/s²."""

    def rows(self, arm: Arm) -> LimitRows:
        lower, upper = PLAIN.lower.copy(), PLAIN.upper.copy()
        upper[2] = GRAVITY * arm.payload
        lower[2] = -upper[2]
        lower_names, upper_names = (("", "", f"payload {side}", "", "", "") for side in ("lower", "upper"))
        return LimitRows(lower, upper, lower_names, upper_names)


class JointTorque(Limit):
    """What the joints bear: |Jᵀ F + tau_0| <= tau_max for each joint. The zero wrench holds it, since `JointTorques`
    refuses a posture whose own weight breaks it."""

    def rows(self, arm: Arm) -> LimitRows:
        if arm.joints is None:
            raise UsageError(f"arm {arm.name}: a limit of joint torques needs joints")
        joints = arm.joints
        return LimitRows(
            rows=joints.jacobian.T,
            limits=joints.torque_limit - joints.gravity_torque,
            names=tuple(f"{label} torque upper" for label in joints.labels),
            low_limits=-joints.torque_limit - joints.gravity_torque,
            low_names=tuple(f"{label} torque lower" for label in joints.labels),
        )
