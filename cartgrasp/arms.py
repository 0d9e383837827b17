"""What an arm can give at a contact, and what it costs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from types import NoneType
from typing import Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike

from .checks import MAX_NUMBER, angle, brief, check_kind, digits, listed, numbers
from .contacts import WRENCH_NAMES, ContactSet, Segment, points_of
from .errors import UsageError
from .frames import Array
from .friction import Friction, SoftFinger
from .joint_torques import JointTorques, PostureSource
from .reach import Reach
from .shallow_copy import shallow_copy

FORCES, MOMENTS, WRENCH = (f"({', '.join(WRENCH_NAMES[part])})" for part in (slice(3), slice(3, 6), slice(6)))


@runtime_checkable
class UserLimit(Protocol):
    """A limit that the library doesn't know: a `planning.Limit`."""

    def rows(self, arm: Arm) -> Any: ...


@dataclass(frozen=True, init=False)
class Arm:
    """An arm: where it may hold the cart, and what it can give there. Limits are symmetric, `inf` is none.

    Args:
        name: A word without a dot or a colon.
        contacts: Points (x, y, z) in {b}, m, of which the planner takes one.
        segment: Two such points: it may hold anywhere between.
        yaw: Of {a} against {b}, rad.
        force_limit: |fx|, |fy|, |fz| in {a}, N.
        moment_limit: |tx|, |ty|, |tz| in {a}, N·m.
        friction: Of a hand that is not firm; it only pushes then.
        soft_finger: Of pads whose friction bears a moment about their normal, too; an open hand's or a gripper's.
        weights: Of (fx, fy, fz, tx, ty, tz) in the effort, the sum of weight times component squared.
        push_only: fx >= 0.
        payload: kg, whose weight it gives at most up or down.
        wrench_rate: Of change, (6,), N/s and N·m/s.
        joints: What its joints bear at its posture, or what says so wherever it holds, such as `UrdfPostures`.
        reach: Where it can hold at all.
        limits: More limits of yours, each with a method `rows` as `planning.Limit` has it.

    Raises:
        UsageError: A value is of the wrong kind, out of bounds, or of another length.

    Example:
        >>> import cartgrasp as cg
        >>> left = cg.Arm("left", [(-0.25, 0.2, 1.0)], force_limit=(60, 60, 40))
        >>> left.wrench_limit.tolist()
        [60.0, 60.0, 40.0, inf, inf, inf]
    """

    name: str
    contacts: ContactSet
    yaw: float
    force_limit: tuple[float, float, float]
    moment_limit: tuple[float, float, float]
    friction: Friction | None
    weights: tuple[float, float, float, float, float, float]
    push_only: bool
    payload: float
    wrench_rate: tuple[float, float, float, float, float, float]
    joints: JointTorques | None
    reach: Reach | None
    soft_finger: SoftFinger | None
    postures: PostureSource | None
    limits: tuple[UserLimit, ...]

    # Many parameters: the keys of an arm in the contract, all but the first two with defaults.
    def __init__(
        self,
        name: str,
        contacts: Sequence[ArrayLike] | ContactSet = (),
        *,
        segment: Sequence[ArrayLike] | None = None,
        yaw: float = 0.0,
        force_limit: Sequence[float] = (np.inf,) * 3,
        moment_limit: Sequence[float] = (np.inf,) * 3,
        friction: Friction | None = None,
        weights: Sequence[float] = (1.0, 1.0, 1.0, 10.0, 10.0, 10.0),
        push_only: bool = False,
        payload: float = np.inf,
        wrench_rate: Sequence[float] = (np.inf,) * 6,
        joints: JointTorques | PostureSource | None = None,
        reach: Reach | None = None,
        soft_finger: SoftFinger | None = None,
        limits: Sequence[UserLimit] = (),
    ) -> None:
        if not isinstance(name, str) or not name or "." in name or ":" in name:
            raise UsageError(f"arm: name {name!r} must be a word without a dot or a colon")
        if not isinstance(contacts, ContactSet):
            contacts = _contact_set(name, contacts, segment)
        elif segment is not None:
            raise UsageError(f"arm {name}: segment: put it into the ContactSet that is given, not beside it")
        where = f"arm {name}"
        check_kind(f"{where}: friction", friction, (Friction, NoneType), "write friction=Friction(mu=0.6)")
        check_kind(f"{where}: push_only", push_only, (bool, np.bool_), "write True or False")
        cure = "write JointTorques(jacobian, torques, limits)"
        check_kind(f"{where}: joints", joints, (JointTorques, PostureSource, NoneType), cure)
        check_kind(f"{where}: reach", reach, (Reach, NoneType), "write Reach.box(low, high)")
        cure = "write soft_finger=SoftFinger(mu=0.6, twist_radius=0.015)"
        check_kind(f"{where}: soft_finger", soft_finger, (SoftFinger, NoneType), cure)
        values = {
            "name": name,
            "contacts": contacts,
            "yaw": angle(f"{where}: yaw", yaw),
            "force_limit": _limits(f"{where}: force_limit", force_limit, FORCES),
            "moment_limit": _limits(f"{where}: moment_limit", moment_limit, MOMENTS),
            "friction": friction,
            "weights": numbers(f"{where}: weights", weights, WRENCH, 0.0, MAX_NUMBER),
            "push_only": bool(push_only),
            "payload": _limits(f"{where}: payload", (payload,), "(kg)")[0],
            "wrench_rate": _limits(f"{where}: wrench_rate", wrench_rate, WRENCH),
            "joints": joints if isinstance(joints, JointTorques) else None,
            "reach": reach,
            "soft_finger": soft_finger,
            "postures": joints if isinstance(joints, PostureSource) else None,
            "limits": listed(f"{where}: limits", limits, UserLimit, "write limits=[MyLimit()], a planning.Limit each"),
        }
        for key, value in values.items():
            object.__setattr__(self, key, value)
        if not min(self.wrench_rate) > 0:
            raise UsageError(f"{where}: wrench_rate: {list(self.wrench_rate)} has a rate that is not > 0")
        if self.postures is not None:
            object.__setattr__(self, "joints", self.at(contacts.first).joints)

    def __repr__(self) -> str:
        counts = (len(self.contacts.points), "points"), (len(self.contacts.segments), "segments")
        held = (f"{what}: {count}" for count, what in counts if count)
        limits = f"force_limit={digits(self.force_limit)}, moment_limit={digits(self.moment_limit)}"
        friction = "" if self.friction is None else f"friction={digits(self.friction.mu)}"
        return brief("Arm", repr(self.name), ", ".join(held), f"yaw={digits(self.yaw)}", limits, friction)

    def at(self, contact: ArrayLike) -> Arm:
        """The arm with what its joints bear with the hand at a contact (3,) in {b}: itself where that is as before, or
        where it has no `postures`. A `UsageError` says why no posture holds there."""
        if self.postures is None:
            return self
        x, y, z = contact if isinstance(contact, tuple) else np.asarray(contact, dtype=float).tolist()
        try:
            joints = self.postures.joints_at((x, y, z), self.yaw)
        except UsageError as error:
            raise UsageError(f"arm {self.name}: {error}") from error
        return self if joints is self.joints else self._with("joints", joints)

    def holding_at(self, contacts: ContactSet) -> Arm:
        """The arm with other candidates."""
        return self._with("contacts", contacts)

    def without_rate(self) -> Arm:
        """The arm where there is time enough for any change: judgements over seconds are of it."""
        return self._with("wrench_rate", (np.inf,) * 6)

    def _with(self, field: str, value: object) -> Arm:
        """The arm with another value, which fits it."""
        other = shallow_copy(self)
        object.__setattr__(other, field, value)
        return other

    @property
    def wrench_limit(self) -> Array:
        """Largest |wrench| per axis of {a}, shape (6,)."""
        return np.array([*self.force_limit, *self.moment_limit])


def _contact_set(name: str, points: Sequence[ArrayLike], segment: Sequence[ArrayLike] | None) -> ContactSet:
    if segment is None:
        return ContactSet(points_of(f"arm {name}: contacts", points))
    ends = points_of(f"arm {name}: segment", segment)
    if len(ends) != 2:
        raise UsageError(f"arm {name}: segment: 2 ends are needed, {len(ends)} given")
    return ContactSet(points_of(f"arm {name}: contacts", points), (Segment(*ends),))


def _limits(what: str, values: Sequence[float], form: str) -> tuple[float, ...]:
    """The limits (n,) on magnitudes, in either direction; `inf` stands for no limit."""
    found = numbers(what, values, form, 0.0)
    if any(MAX_NUMBER < value < np.inf for value in found):
        raise UsageError(f"{what}: {list(found)} has a number beyond {MAX_NUMBER:g}; for no limit, give inf")
    return found
