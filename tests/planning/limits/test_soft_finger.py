"""Soft fingers: the polytope within the ellipsoid, and both against pads of many points that slip by Coulomb's law."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial import ConvexHull

import cartgrasp as cg
from planning import WrenchPlanner, allocate
from planning.limits import SoftFingerLimit
from planning.limits.soft_finger import polytope
from planning.tick.compiled_allocation import SOLVER

from ..drawn import arm, cart, first_contacts
from .test_limits import violated

MU, GRIP = 0.6, 100.0
HALF = 0.011  # m, of a pad
CORNERS = HALF * np.array([[1, 1], [1, -1], [-1, 1], [-1, -1]])
EVEN = HALF * np.stack(np.meshgrid(*2 * [(np.arange(40) - 19.5) / 20]), axis=-1).reshape(-1, 2)
DISC = EVEN[np.hypot(*EVEN.T) <= HALF]


def slipping(points):
    """(fx, fy, m) (k, 3) of a gripper whose two pads slide about every centre of rotation: each point, which carries
    its share of 2 GRIP, gives MU times it against its own way."""
    radii, angles = np.geomspace(1e-5, 10.0, 200), np.linspace(0, 2 * np.pi, 37)
    centres = (radii[:, None, None] * np.stack([np.cos(angles), np.sin(angles)], axis=-1)).reshape(-1, 1, 2)
    arms = points - centres
    ways = np.stack([-arms[..., 1], arms[..., 0]], axis=-1)
    ways /= np.maximum(np.linalg.norm(ways, axis=-1, keepdims=True), 1e-12)
    forces = MU * 2 * GRIP / len(points) * ways
    moments = points[:, 0] * forces[..., 1] - points[:, 1] * forces[..., 0]
    return np.column_stack([forces.sum(axis=1), moments.sum(axis=1)])


def pinching(radius, sides):
    return arm(friction=None, soft_finger=cg.SoftFinger(MU, radius, GRIP, "z", sides))


@pytest.mark.some(1)
@pytest.mark.long
@pytest.mark.parametrize(
    ("points", "radius", "inside"),
    [(CORNERS, np.sqrt(2) * HALF, 0.896), (DISC, 2 / 3 * HALF, 0.93), (EVEN, 0.3826 * 2 * HALF, 0.93)],
)
def test_pads_that_slip_by_coulombs_law_are_near_the_ellipsoid(points, radius, inside):
    """On it where they only slide or only turn, and within elsewhere, by as much as `SoftFinger` says."""
    wrenches = slipping(points)
    lengths = np.linalg.norm(wrenches / [1, 1, radius], axis=1) / (2 * MU * GRIP)
    assert inside <= lengths.min() <= inside + 0.01
    assert lengths.max() == pytest.approx(1.0, abs=0.005)
    assert np.abs(wrenches[:, 2]).max() == pytest.approx(2 * MU * GRIP * radius, rel=0.005)


def test_a_gripper_of_22_mm_pads_holds_what_was_measured():
    """A simulated gripper (100 N, friction 0.6, pads 22 mm wide) slips between 115 and 125 N, and between 1.5 and 2 N·m
    about the vertical; boxes touch a bar by their corners."""
    hold = arm(friction=None, force_limit=(500,) * 3, soft_finger=cg.SoftFinger(MU, np.sqrt(2) * HALF, GRIP, "z"))
    slides, turns = np.array([1.0, 0, 0, 0, 0, 0]), np.array([0.0, 0, 0, 0, 0, 1])
    rows = SoftFingerLimit().rows(hold)
    assert violated(rows, 115 * slides) == violated(rows, 1.5 * turns) == []
    assert violated(rows, 125 * slides)
    assert violated(rows, 2.0 * turns)
    assert violated(rows, 90 * slides + 1.5 * turns)  # each alone it would hold
    assert violated(rows, np.array([0, 0, 400.0, 9, 9, 0])) == []  # along the fingers, and about what they close on


@pytest.mark.parametrize("sides", [3, 4, 6, 8, 12, 32])
def test_the_polytope_is_inscribed(sides):
    """Its corners are on the ball, its sides touch three or more of them, and no side is farther than a corner."""
    normals, distances, _ = polytope(sides)
    rings = max(1, round(sides / 4))
    latitude = np.pi / 2 * np.arange(-rings, rings + 1) / rings
    angle = 2 * np.pi * np.arange(sides) / sides
    corners = np.array([[np.cos(b) * np.cos(a), np.cos(b) * np.sin(a), np.sin(b)] for b in latitude for a in angle])
    excess = corners @ normals.T - distances
    assert excess.max() <= 1e-12
    assert ((excess > -1e-12).sum(axis=0) >= 3).all()
    assert np.linalg.norm(normals, axis=1) == pytest.approx(np.ones(len(normals)))
    hull = np.unique(ConvexHull(np.unique(corners.round(12), axis=0)).equations.round(8), axis=0)
    ours = np.unique(np.column_stack([normals, -distances]).round(8), axis=0)
    assert ours + 0.0 == pytest.approx(hull + 0.0, abs=2e-8)
    assert distances.min() >= {3: 0.44, 4: 0.57, 6: 0.81, 8: 0.86, 12: 0.93, 32: 0.99}[sides]


@pytest.mark.parametrize("finger", [{"grip": 28.0, "normal": "z"}, {"grip": 0.0}])
def test_more_sides_tend_to_the_ellipsoid(finger):
    """From above, by a plan that asks for a force and a moment at once."""
    efforts = []
    for sides in (4, 8, 16, 32, "exact"):
        held = cg.SoftFinger(0.5, 0.04, sides=sides, **finger)
        one = arm("left", [(-0.5, 0.15, 1.0)], friction=None, soft_finger=held, yaw=0.3, moment_limit=(9, 9, 20))
        other = arm("right", [(-0.5, -0.1, 1.0)], friction=None, soft_finger=held, moment_limit=(9, 9, 20))
        found = allocate(cart(), [one, other], first_contacts([one, other]), (40, 0, 9))
        assert found.status == "optimal"
        efforts.append(found.effort)
        assert any("soft finger" in name for name in found.active)
    assert all(effort >= efforts[-1] * (1 - 1e-9) for effort in efforts[:-1])
    assert efforts[3] == pytest.approx(efforts[-1], rel=5e-3)


def test_the_kernels_know_the_polytope():
    """A compiled plan is that of the general road, and the ellipsoid itself is left to that road."""
    hands, exact = (
        [
            arm(name, [(-0.25, y, 1.0)], friction=None, soft_finger=cg.SoftFinger(MU, 0.0156, 60.0, "z", sides))
            for name, y in (("left", 0.2), ("right", -0.2))
        ]
        for sides in (8, "exact")
    )
    roads = WrenchPlanner(cart(), hands), WrenchPlanner(cart(), hands)
    roads[0].warm_up()
    bound = 0
    for fx, tau in np.random.default_rng(4).uniform((-80, -30), (80, 30), (60, 2)):
        one, other = (planner.plan((fx, 0, tau)) for planner in roads)
        assert one.status == other.status
        if one.status == "optimal":
            assert one.solver == SOLVER
            assert one.effort == pytest.approx(other.effort, rel=1e-9)
            bound += any("soft finger side" in name for name in one.active)
    assert bound > 5
    assert roads[0].plan((30, 0, 1), arms=exact).solver != SOLVER
    assert roads[0].plan((30, 0, 1), arms=hands).solver == SOLVER


@pytest.mark.parametrize(
    ("numbers", "words"),
    [
        ({"mu": -1.0}, "soft finger: mu"),
        ({"twist_radius": 0.0}, "soft finger: twist_radius"),
        ({"grip": np.nan}, "soft finger: grip"),
        ({"normal": "y'"}, "soft finger: normal"),
        ({"sides": 2}, "soft finger: sides"),
        ({"sides": 33}, "soft finger: sides"),
        ({"sides": True}, "soft finger: sides"),
    ],
)
def test_what_is_refused(numbers, words):
    with pytest.raises(cg.UsageError, match=words):
        cg.SoftFinger(**({"mu": 0.6, "twist_radius": 0.01} | numbers))
    with pytest.raises(cg.UsageError, match="arm left: soft_finger"):
        arm(soft_finger=0.6)
