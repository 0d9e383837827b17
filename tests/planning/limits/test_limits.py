"""Every limit sits the same exam: it bites just outside, is idle just inside, holds the zero wrench, names
itself."""

from __future__ import annotations

import inspect

import numpy as np
import pytest

from cartgrasp.arms import Arm, Friction
from cartgrasp.errors import UsageError
from cartgrasp.friction import SoftFinger
from cartgrasp.joint_torques import JointTorques
from planning import allocate, limits
from planning.limits import (
    FrictionCone,
    FrictionPyramid,
    JointTorque,
    Payload,
    Pull,
    PushOnly,
    SoftFingerLimit,
    WrenchBox,
    limits_of,
)
from planning.problem.problem_schema import ArmEntry

from ..drawn import arm, cart, first_contacts

ARM = arm(force_limit=(60, 50, 40), moment_limit=(8, 7, 6), friction=Friction(0.6, 5))
CONE_ARM = arm(friction=Friction(0.6, "exact"))
OPEN = arm(friction=None, soft_finger=SoftFinger(0.6, 0.01, sides="exact"))
PINCH = arm(friction=None, soft_finger=SoftFinger(0.6, 0.01, 100.0, "z", "exact"))
COARSE = arm(friction=None, soft_finger=SoftFinger(0.6, 0.01, 100.0, "z", 4))
LEVERS = np.zeros((6, 2))
LEVERS[1], LEVERS[5] = (0.7, 0.3), (1.0, 1.0)  # two links along x
LINKS = arm(friction=None, joints=JointTorques(LEVERS, [5.0, 0.0], [20.0, 10.0]))
BOUNDARIES = [
    (WrenchBox(), ARM, np.array([0, 0, 0, 0, 0, -6.0]), "tz lower"),
    (WrenchBox(), ARM, np.array([0, 50.0, 0, 0, 0, 0]), "fy upper"),
    (FrictionPyramid(), ARM, np.array([0.0, 0, 0, 1, 0, 0]), "push only"),
    (
        FrictionPyramid(),
        ARM,
        np.array([10, *(6 * np.cos(np.pi / 5) * np.array([np.cos(np.pi / 5), np.sin(np.pi / 5)])), 0, 0, 0]),
        "friction edge 0",
    ),
    (PushOnly(), arm(friction=None, push_only=True), np.array([0.0, 0, 0, 0, 0, 0]), "push only"),
    (Payload(), arm(friction=None, payload=3.0), np.array([9.0, 0, -3 * 9.81, 0, 0, 0]), "payload lower"),
    (Payload(), arm(friction=None, payload=3.0), np.array([0, 0, 3 * 9.81, 0, 0, 1.0]), "payload upper"),
    (JointTorque(), LINKS, np.array([0, 15 / 0.7, 0, 0, 0, 0]), "joint 0 torque upper"),
    (JointTorque(), LINKS, np.array([0, -40.0, 0, 0, 0, 3.0]), "joint 0 torque lower"),
    (JointTorque(), LINKS, np.array([0, -10.0, 9.0, 0, 0, 13.0]), "joint 1 torque upper"),
    (Pull(18.0), arm(friction=None, limits=[Pull(18.0)]), np.array([-18.0, 9, 0, 0, 0, 0]), "pull upper"),
    (FrictionCone(), CONE_ARM, np.array([10, 3.6, -4.8, 0, 0, 0]), "friction cone"),
    (SoftFingerLimit(), OPEN, np.array([10, 2.0, -4.0, 0.04, 0, 0]), "soft finger"),
    (SoftFingerLimit(), OPEN, np.array([0.0, 0, 0, 0, 9, 9]), "push only"),
    (SoftFingerLimit(), PINCH, np.array([40.0, 80, 500, 0, 0, 0.8]), "soft finger"),
    (SoftFingerLimit(), COARSE, np.array([40.0, 50, -30, 9, 9, 0.3]), "soft finger side 4"),
    (SoftFingerLimit(), COARSE, np.array([40.0, 50, -30, 9, 9, -0.3]), "soft finger side 0"),
]


def violated(rows, wrench):
    """Names of the limits that a wrench breaks."""
    broken = [name for name, low, f in zip(rows.lower_names, rows.lower, wrench, strict=True) if f < low]
    broken += [name for name, high, f in zip(rows.upper_names, rows.upper, wrench, strict=True) if f > high]
    broken += [name for name, over in zip(rows.names, rows.rows @ wrench > rows.limits, strict=True) if over]
    broken += [name for name, under in zip(rows.low_names, rows.rows @ wrench < rows.low_limits, strict=True) if under]
    for cone in rows.cones:
        s = cone.offset + cone.rows @ wrench
        broken += [cone.name] if np.linalg.norm(s[1:]) > s[0] else []
    return broken


def test_every_limit_sits_it():
    known = {thing for thing in vars(limits).values() if isinstance(thing, type) and issubclass(thing, limits.Limit)}
    assert known - {limits.Limit} == {type(limit) for limit, *_ in BOUNDARIES}, "give each a row of BOUNDARIES"


def test_every_parameter_of_an_arm_has_its_key():
    """`limits` are a user's own classes; a problem file has `box` limits under that name, and a few more words."""
    parameters = inspect.signature(Arm).parameters.keys() - {"force_limit", "moment_limit", "wrench_rate"}
    assert parameters == ArmEntry.model_fields.keys() - {"rate", "urdf", "held"}, "give it a key in problem_schema.py"


@pytest.mark.parametrize(("limit", "owner", "boundary", "name"), BOUNDARIES)
def test_exam(limit, owner, boundary, name):
    """The boundary lies on this face alone. It is left by all components but fx, which friction grows with."""
    rows, stated = limit.rows(owner), limits_of(owner)
    told = (*stated.names, *stated.low_names, *stated.lower_names, *stated.upper_names)
    assert name in (*told, *(cone.name for cone in stated.cones)), f"limits_of leaves {type(limit).__name__} out"
    if name in ("push only", "pull upper"):  # of fx alone
        assert name in violated(rows, boundary - np.array([1e-9, 0, 0, 0, 0, 0]))
        assert violated(rows, boundary + np.array([1e-9, 0, 0, 0, 0, 0])) == []
    else:
        outward = np.where(np.arange(6) == 0, 0.0, boundary)
        assert violated(rows, boundary + 1e-9 * outward) == [name], "on one face alone, which fx doesn't decide"
        assert violated(rows, boundary - 1e-9 * outward) == []
    assert violated(rows, np.zeros(6)) == []


@pytest.mark.parametrize("sides", [3, 4, 7, 32])
def test_the_pyramid_is_inscribed_with_its_edges_on_the_cone(sides):
    owner = arm(friction=Friction(0.6, sides))
    rows = FrictionPyramid().rows(owner)
    for k in range(sides):
        angle = 2 * np.pi * k / sides
        edge = np.array([10, 6 * np.cos(angle), 6 * np.sin(angle), 0, 0, 0])
        excess = rows.rows @ edge
        assert excess.max() <= 1e-12
        touched = {rows.names[j] for j in np.flatnonzero(excess > -1e-12)}
        assert touched == {f"friction edge {k}", f"friction edge {(k - 1) % sides}"}
    rng = np.random.default_rng(0)
    for wrench in rng.uniform(-10, 10, (300, 6)):
        if violated(rows, wrench) == []:
            assert np.linalg.norm(wrench[1:3]) <= 0.6 * wrench[0] + 1e-12


def test_without_friction_side_force_is_free_and_without_grip_there_is_none():
    assert limits_of(arm(friction=None)).lower[0] == -60
    greasy = limits_of(arm(friction=Friction(0.0, 4)))
    assert violated(greasy, np.array([10, 0, 0, 0, 0, 0.0])) == []
    assert violated(greasy, np.array([10, 1e-6, 0, 0, 0, 0])) != []
    assert violated(greasy, np.array([-1e-6, 0, 0, 0, 0, 0])) == ["push only"]


def test_of_two_bounds_the_tighter_names_itself():
    rows = limits_of(arm())
    assert rows.lower[0] == 0
    assert rows.lower_names[0] == "push only"
    assert rows.upper_names[0] == "fx upper"


def test_asking_a_limit_of_the_wrong_arm():
    with pytest.raises(UsageError, match="left"):
        FrictionPyramid().rows(CONE_ARM)
    with pytest.raises(UsageError, match="left"):
        FrictionCone().rows(arm(friction=None))
    with pytest.raises(UsageError, match="left"):
        JointTorque().rows(arm())
    with pytest.raises(UsageError, match="left"):
        SoftFingerLimit().rows(arm())


@pytest.mark.parametrize("wrench", [(30, 0, 2), (30, 0, 15), (55, 0, -18), (15, 0, 6)])
def test_the_cone_lies_between_pyramids(wrench):
    """An inscribed pyramid costs at least the cone's effort, and tends to it as the sides grow (mu is then
    nearly right)."""
    efforts = []
    for sides in (4, 16, 64, 256, "exact"):
        # The force may not lie on an edge, so tilt it: weights make fz cheap and yaw turns y away.
        a = arm("left", [(-0.5, 0.1, 1.0)], friction=Friction(0.4, sides), yaw=0.3, moment_limit=(9, 9, 20))
        efforts.append(allocate(cart(), [a], first_contacts([a]), wrench).effort)
    exact = efforts[-1]
    for effort in efforts[:-1]:
        assert effort >= exact - 1e-8 * exact
    assert efforts[3] == pytest.approx(exact, rel=1e-3)
