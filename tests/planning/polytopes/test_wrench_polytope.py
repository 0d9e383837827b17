"""Wrench polytopes: membership against the limits themselves, supports against all vertices, shadows against supports
in drawn directions, and a two-joint arm in closed form."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import ConvexHull, HalfspaceIntersection

from cartgrasp.arms import Arm, Friction
from cartgrasp.errors import UsageError
from cartgrasp.joint_torques import JointTorques
from planning.polytopes.polytope_projection import project
from planning.polytopes.wrench_polytope import WrenchPolytope

POINT = (0.0, 0.0, 1.0)
PLAIN = Arm("hand", [POINT], force_limit=(200, 150, 100), moment_limit=(9, 8, 7))
PUSHING = Arm("hand", [POINT], force_limit=(200, 150, 100), moment_limit=(9, 8, 7), friction=Friction(0.5, 5))
TOUCHING = Arm("hand", [POINT], force_limit=(200, 150, 100), moment_limit=(0, 0, 0), friction=Friction(0.5))
FINGERTIP = Arm("hand", [POINT], force_limit=(200, 150, 100), moment_limit=(0, 0, 0), friction=Friction(0.0))
ARMS = {"plain": PLAIN, "pushing": PUSHING, "touching": TOUCHING, "fingertip": FINGERTIP}
every_polytope = settings(max_examples=25, deadline=None)


@st.composite
def postures(draw: st.DrawFn) -> JointTorques:
    """Of an arm with metre-long links, that carries itself with at most 60 % of its torque."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    n = draw(st.integers(1, 8))
    limit = rng.uniform(10, 300, n)
    return JointTorques(rng.uniform(-1, 1, (6, n)), rng.uniform(-0.6, 0.6, n) * limit, limit)


def directions(count: int, dimension: int) -> np.ndarray:
    drawn = np.random.default_rng(3).normal(size=(count, dimension))
    return drawn / np.linalg.norm(drawn, axis=1, keepdims=True)


def polytope_of(arm: Arm, joints: JointTorques) -> WrenchPolytope:
    return WrenchPolytope.of(with_joints(arm, joints))


def with_joints(arm: Arm, joints: JointTorques) -> Arm:
    limits = {"force_limit": arm.force_limit, "moment_limit": arm.moment_limit}
    return Arm(arm.name, arm.contacts, **limits, friction=arm.friction, joints=joints)


def obeys(wrench: np.ndarray, joints: JointTorques) -> bool:
    """What `PUSHING` and its joints allow, in the words of a mechanic: a push on a point within the pyramid."""
    edges = [np.array([1, 0.5 * np.cos(a), 0.5 * np.sin(a)]) for a in 2 * np.pi * np.arange(5) / 5]
    corners = np.array(edges)[:, 1:] * wrench[0]
    in_pyramid = wrench[0] > 0 and ConvexHull(np.vstack([corners, wrench[1:3]])).volume <= ConvexHull(corners).volume
    in_box = (np.abs(wrench) <= [200, 150, 100, 9, 8, 7]).all()
    return bool(in_pyramid and in_box and (np.abs(joints.torques(wrench)) <= joints.torque_limit).all())


def holds(polytope: WrenchPolytope, wrench: np.ndarray, tolerance: float = 1e-9) -> bool:
    return bool((polytope.rows @ wrench <= polytope.limits + tolerance).all())


@every_polytope
@given(postures(), st.integers(0, 2**32 - 1))
def test_it_holds_what_the_limits_allow(joints: JointTorques, seed: int):
    polytope = polytope_of(PUSHING, joints)
    rng = np.random.default_rng(seed)
    for size in (0.01, 0.1, 0.4, 1.2):
        wrench = size * rng.uniform([0, -75, -75, -9, -8, -7], [200, 75, 75, 9, 8, 7])
        if np.abs(polytope.rows @ wrench - polytope.limits).min() > 1e-6:
            assert holds(polytope, wrench) == obeys(wrench, joints)


@every_polytope
@given(postures())
def test_support_is_the_farthest_of_all_vertices(joints: JointTorques):
    """Qhull's vertices in six dimensions."""
    polytope = polytope_of(PLAIN, joints)
    vertices = HalfspaceIntersection(np.column_stack([polytope.rows, -polytope.limits]), np.zeros(6)).intersections
    for direction in directions(5, 6):
        farthest = polytope.support(direction)
        assert farthest.distance == pytest.approx((vertices @ direction).max(), rel=1e-7)
        assert farthest.distance == pytest.approx(direction @ farthest.wrench)
        assert holds(polytope, farthest.wrench, 1e-6)


@pytest.mark.long
@every_polytope
@given(postures(), st.sampled_from(sorted(ARMS)), st.sampled_from([("fx", "fz"), ("fx", "fy", "fz"), ("fy", "tz")]))
def test_shadow_has_the_polytopes_support(joints: JointTorques, name: str, components: tuple[str, ...]):
    polytope = polytope_of(ARMS[name], joints)
    vertices = project(polytope, components)
    columns = [("fx", "fy", "fz", "tx", "ty", "tz").index(c) for c in components]
    for direction in directions(8, len(components)):
        towards = np.zeros(6)
        towards[columns] = direction
        expected = polytope.support(towards).distance
        assert (vertices @ direction).max() == pytest.approx(expected, abs=1e-5 * max(1.0, np.abs(vertices).max()))


@pytest.mark.parametrize(
    ("name", "components", "corners"),
    [
        ("plain", ("fx", "fy"), set(product((-200, 200), (-150, 150)))),
        ("plain", ("fx", "fy", "tz"), set(product((-200, 200), (-150, 150), (-7, 7)))),
        ("touching", ("fx", "fz"), {(0, 0), (200, 100), (200, -100)}),
        ("touching", ("fx", "tz"), {(0, 0), (200, 0)}),
        ("touching", ("tx", "tz"), {(0, 0)}),
        ("touching", ("tx", "fx", "tz"), {(0, 0, 0), (0, 200, 0)}),
        ("fingertip", ("fx", "fy", "fz"), {(0, 0, 0), (200, 0, 0)}),
        ("fingertip", ("fx",), {(0,), (200,)}),
    ],
)
def test_shadows_that_are_known(name: str, components: tuple[str, ...], corners: set[tuple[float, ...]]):
    """Flat ones too: lines and points."""
    vertices = project(WrenchPolytope.of(ARMS[name]), components)
    assert sorted(tuple(float(v) for v in vertex.round(6) + 0.0) for vertex in vertices) == sorted(corners)


@every_polytope
@given(postures(), st.permutations(["fx", "fy", "fz"]))
def test_vertices_of_two_components_go_round(joints: JointTorques, components: list[str]):
    """Counter-clockwise: every corner turns left."""
    vertices = project(polytope_of(PUSHING, joints), components[:2])
    sides = np.roll(vertices, -1, axis=0) - vertices
    following = np.roll(sides, -1, axis=0)
    assert (sides[:, 0] * following[:, 1] - sides[:, 1] * following[:, 0] > 0).all()


@pytest.mark.long
@every_polytope
@given(postures(), st.floats(-8, 0), st.floats(-3, 3))
def test_thin_small_and_large_shadows_too(joints: JointTorques, thinness: float, size: float):
    scale, mu = 10.0**size, 10.0**thinness
    scaled = JointTorques(joints.jacobian, scale * joints.gravity_torque, scale * joints.torque_limit)
    arm = Arm("hand", [POINT], force_limit=(scale * 200,) * 3, moment_limit=(scale, 0, 1), friction=Friction(mu, 7))
    polytope = polytope_of(arm, scaled)
    vertices = project(polytope, ("fx", "fy", "fz"))
    for direction in directions(5, 3):
        expected = polytope.support((*direction, 0, 0, 0)).distance
        assert (vertices @ direction).max() == pytest.approx(expected, abs=1e-5 * max(1.0, np.abs(vertices).max()))


def test_two_joints_in_closed_form():
    """Links of 0.5 m, one pointing up, one ahead; forces in the plane alone: |0.5 fx - 0.5 fz| and |0.5 fz| within."""
    jacobian = np.zeros((6, 2))
    jacobian[0], jacobian[2] = (-0.5, 0.0), (0.5, 0.5)
    in_plane = Arm("hand", [POINT], force_limit=(1e3, 0, 1e3), moment_limit=(0, 0, 0))
    vertices = project(polytope_of(in_plane, JointTorques(jacobian, [2.0, 1.0], [50.0, 20.0])), ("fx", "fz"))
    low, high = -42.0, 38.0
    expected = {(low - 96, low), (low + 104, low), (high - 96, high), (high + 104, high)}
    assert {tuple(float(v) for v in vertex) for vertex in vertices.round(6)} == expected


def test_names_tell_what_limits():
    polytope = polytope_of(TOUCHING, JointTorques(np.ones((6, 2)), [0, 0], [5.0, np.inf]))
    assert len(polytope.names) == len(polytope.limits) == len(polytope.rows)
    farthest = polytope.support((1.0, 0, 0, 0, 0, 0)).wrench
    active = {
        n for n, slack in zip(polytope.names, polytope.limits - polytope.rows @ farthest, strict=True) if slack < 1e-9
    }
    assert "joint 0 torque upper" in active
    assert not any("joint 1" in name for name in polytope.names)


@every_polytope
@given(postures())
def test_limits_that_bind_are_enough_to_stop_it(joints: JointTorques):
    polytope = polytope_of(PUSHING, joints)
    for direction in directions(4, 6):
        farthest = polytope.support(direction)
        binding = [polytope.names.index(name) for name in farthest.limits]
        alone = WrenchPolytope(polytope.rows[binding], polytope.limits[binding], farthest.limits)
        assert alone.support(direction).distance == pytest.approx(farthest.distance, rel=1e-6, abs=1e-6)


def test_it_tells_how_far_each_component_goes_and_why():
    joints = JointTorques(np.outer([1, 0, 0, 0, 0, 0], [1.0, 0.5]), [5, 0], [25.0, 40.0], ("elbow", "wrist"))
    told = repr(polytope_of(PLAIN, joints))
    assert "fx -30 (joint elbow torque lower) to 20 (joint elbow torque upper)" in told
    assert "tz -7 (tz lower) to 7 (tz upper)" in told
    bare = WrenchPolytope.of(Arm("hand", [POINT], force_limit=(9, 8, np.inf)))
    assert "fz -inf to inf" in repr(bare)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda p: p.support((1, 0, 0, 0, 0, 0)), "nothing limits 1 fx; add limits"),
        (lambda p: p.support((1, 0, 0, 0, -2, 0)), r"nothing limits 1 fx \+ -2 ty; add limits"),
        (lambda p: p.support(np.zeros(6)), "a direction is six finite numbers, not all 0"),
        (lambda p: p.support((1, 0, np.nan, 0, 0, 0)), "a direction is six finite numbers"),
        (lambda p: p.support((1, 0)), "a direction is six finite numbers"),
        (lambda p: project(p, ("fx", "fq")), "components: fx, fq: give one to three of fx"),
        (lambda p: project(p, ("fx", "fx")), "components: fx, fx"),
        (lambda p: project(p, ()), "components: : give one to three"),
        (lambda p: project(p, ("fx", "fy", "fz", "tz")), "components: fx, fy, fz, tz"),
        (
            lambda p: WrenchPolytope.of(Arm("left", [POINT], friction=Friction(0.5, "exact"))),
            "arm left: a polytope",
        ),
    ],
)
def test_what_cannot_be_answered_is_refused(call, words):
    polytope = WrenchPolytope.of(Arm("hand", [POINT]))
    with pytest.raises(UsageError, match=words):
        call(polytope)
