"""`arms` of `PROBLEM.yaml` and `study.yaml`."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from cartgrasp.arms import Arm
from cartgrasp.checks import numbers
from cartgrasp.contacts import ContactSet, Segment
from cartgrasp.errors import UsageError
from cartgrasp.friction import EXACT, Friction, SoftFinger
from cartgrasp.joint_torques import JointTorques, PostureSource
from cartgrasp.reach import Reach

from .problem_schema import ARM_LIMITS, ArmEntry, FrictionEntry, JointsEntry, UrdfEntry
from .refusing import Refuse, refusing

NO_LIMIT = (float("inf"),) * 3


def arms_of(entries: Sequence[ArmEntry], where: list[str | int], folder: Path, refuse: Refuse) -> list[Arm]:
    """The arms of a list that stands at a place of a document, which is in a folder."""
    arms: list[Arm] = []
    for i, entry in enumerate(entries):
        if entry.name in [other.name for other in arms]:
            raise refuse([*where, i, "name"], f"{entry.name} stands twice; names must differ")
        arms.append(_arm(entry, [*where, i], folder, refuse))
    return arms


def _arm(entry: ArmEntry, where: list[str | int], folder: Path, refuse: Refuse) -> Arm:
    if not entry.contacts and entry.segment is None:
        raise refuse([*where, "contacts"], "an arm needs `contacts`, a `segment`, or both; add one")
    with refusing(refuse, *where, "contacts" if entry.contacts else "segment"):
        held = _contacts(entry)
    friction = _friction(entry.friction, [*where, "friction"], refuse)
    with refusing(refuse, *where, "soft_finger"):
        soft_finger = None if entry.soft_finger is None else SoftFinger(**dict(entry.soft_finger))
    joints = _bearing(entry, where, folder, refuse)
    with refusing(refuse, *where, "reach"):
        reach = None if entry.reach is None else Reach.box(entry.reach.low, entry.reach.high)
        if reach is not None and reach.clip(held) is None:
            raise UsageError("no candidate contact is within it")
    rate = [] if entry.rate is None else [*(entry.rate.force or NO_LIMIT), *(entry.rate.moment or NO_LIMIT)]
    stated = {key: dict(values) for key in ARM_LIMITS if (values := getattr(entry.limits, key)) is not None}
    limits = []
    for key, values in stated.items():
        with refusing(refuse, *where, "limits", key):
            limits.append(ARM_LIMITS[key](**values))
    with refusing(refuse, *where, "name"):
        arm = Arm(
            entry.name,
            held,
            yaw=entry.yaw,
            force_limit=entry.limits.force or NO_LIMIT,
            moment_limit=entry.limits.moment or NO_LIMIT,
            friction=friction,
            weights=entry.weights,
            push_only=entry.push_only,
            payload=float("inf") if entry.payload is None else entry.payload,
            wrench_rate=rate or NO_LIMIT * 2,
            joints=joints,
            reach=reach,
            soft_finger=soft_finger,
            limits=limits,
        )
    return arm


def _contacts(entry: ArmEntry) -> ContactSet:
    points = tuple((x, y, z) for x, y, z in entry.contacts)
    if entry.segment is None:
        return ContactSet(points)
    (x, y, z), (x2, y2, z2) = entry.segment
    return ContactSet(points, (Segment((x, y, z), (x2, y2, z2)),))


def _friction(entry: FrictionEntry | None, where: list[str | int], refuse: Refuse) -> Friction | None:
    if entry is None:
        return None
    sides = entry.sides
    if sides != EXACT and not (isinstance(sides, int) and not isinstance(sides, bool) and 3 <= sides <= 256):
        raise refuse([*where, "sides"], f"{sides!r} is neither a whole number of 3 to 256 nor `exact`")
    with refusing(refuse, *where, "mu"):
        friction = Friction(entry.mu, sides)
    return friction


def _bearing(
    entry: ArmEntry, where: list[str | int], folder: Path, refuse: Refuse
) -> JointTorques | PostureSource | None:
    if entry.urdf is None:
        return _joints(entry.joints, [*where, "joints"], refuse)
    with refusing(refuse, *where, "urdf"):
        if entry.joints is not None:
            raise UsageError("stands beside `joints`; write one of them")
        postures = _postures(entry.urdf, folder)
    return postures


def _joints(entry: JointsEntry | None, where: list[str | int], refuse: Refuse) -> JointTorques | None:
    if entry is None:
        return None
    n = len(entry.torque_limit)
    for row, values in enumerate(entry.jacobian):
        if len(values) != n:
            why = f"{len(values)} numbers, but there are {n} torque limits: one for each joint is needed"
            raise refuse([*where, "jacobian", row], why)
    with refusing(refuse, *where):
        jacobian, gravity, limit = map(np.array, (entry.jacobian, entry.gravity_torque, entry.torque_limit))
        torques = JointTorques(jacobian, gravity, limit)
    return torques


def _postures(entry: UrdfEntry, folder: Path) -> PostureSource:
    from cartgrasp.spatial_pose import SpatialPose
    from cartgrasp.urdf_arm import LEVEL_GRAVITY, LinkMass, read_urdf_arm  # Pinocchio
    from cartgrasp.urdf_postures import ROLL_PITCH_YAW_FORM, UrdfPostures

    masses = [LinkMass(one.link, one.mass, (one.centre[0], one.centre[1], one.centre[2])) for one in entry.added_masses]
    arm = read_urdf_arm(folder / entry.file, entry.tool, torque_limit=entry.torque_limit, added_masses=masses)
    gravity = LEVEL_GRAVITY if entry.feels_gravity else (0.0, 0.0, 0.0)
    turned = numbers("base_turned", entry.base_turned, ROLL_PITCH_YAW_FORM, -math.tau, math.tau)
    arm = arm.placed(SpatialPose.of(entry.base, *turned), gravity)
    return UrdfPostures(arm, entry.hand_turned, entry.start)
