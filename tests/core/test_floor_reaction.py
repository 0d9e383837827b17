"""What the floor gives, against the balance of momentum in space with the model's own accelerations."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import cartgrasp as cg
from cartgrasp.contacts import grasp_map_spatial
from cartgrasp.effects import (
    FloorSlope,
    LoadSlosh,
    PayloadChange,
    RollingResistance,
    UnknownSlope,
    ViscousDrag,
    WheelMisalignment,
)
from cartgrasp.errors import UsageError
from cartgrasp.floor_reaction import FloorReaction, check_loads
from cartgrasp.motion import Motion

TRICYCLE = (cg.Wheel("fixed", 0.1, 0.3), cg.Wheel("fixed", 0.1, -0.25), cg.Wheel("caster", 0.8, 0.05, 0.04))
HEIGHT = 0.45


def cart(axle=0.1, wheels=TRICYCLE, effects=(), **changes):
    inertia = cg.Inertia(24.0, (0.35, 0.06), 2.0)
    constraints = cg.RollingConstraints(axle)
    return cg.CartModel(inertia, constraints, effects, wheels, com_height=HEIGHT, **changes)


@pytest.mark.parametrize("seed", range(20))
@pytest.mark.parametrize("axle", [0.1, 0.0])
def test_momentum_in_space(seed, axle):
    """On three wheels the loads follow from the balance alone: forces, and moments about the centre of mass."""
    rng = np.random.default_rng(seed)
    model = cart(axle, effects=(ViscousDrag(3.0, 1.2),))
    u, r = rng.uniform(-1.5, 1.5, 2)
    motion = Motion(rng.uniform(-2, 2, 3), np.array([u, r]))
    point, yaw, wrench_a = rng.uniform((-0.4, -0.3, 0.8), (0.1, 0.3, 1.1)), rng.uniform(-1, 1), rng.normal(0, 15, 6)
    hands = grasp_map_spatial(point, yaw) @ wrench_a
    floor = FloorReaction.of(model, motion)
    loads, lateral = floor.loads(hands), float(floor.lateral(hands))

    state = model.state(motion.pose_sb, motion.velocity)
    du, dr = model.state_rate(state, hands[[0, 1, 5]])[3:5]
    spin, turn = np.array([0, 0, r]), np.array([0, 0, dr])
    velocity, rate = np.array([u, -axle * r, 0.0]), np.array([du, -axle * dr, 0.0])  # no side slip at the axle
    com = np.array([0.35, 0.06, HEIGHT])
    acceleration = rate + np.cross(spin, velocity) + np.cross(turn, com) + np.cross(spin, np.cross(spin, com))
    drag = model.effect_wrench(state)
    forces = [(np.array([drag[0], drag[1], 0.0]), np.zeros(3)), (np.array([0.0, lateral, 0.0]), np.array([axle, 0, 0]))]
    forces += [(np.array([0, 0, load]), np.array([w.x, w.y, 0])) for load, w in zip(loads, TRICYCLE, strict=True)]
    forces += [(np.array([0, 0, -24.0 * 9.81]), com), (hands[:3], np.zeros(3))]
    total = sum(force for force, _ in forces)
    moment = sum(np.cross(at - com, force) for force, at in forces) + hands[3:] + [0, 0, drag[2]]
    assert total == pytest.approx(24.0 * acceleration, abs=1e-9)
    assert moment == pytest.approx([0, 0, 2.0 * dr], abs=1e-9)


def test_the_closed_form_of_physics_5():
    """With the axle through {b}'s origin: lambda = m (u r + dx r' - dy r²) - fy."""
    model, (u, r) = cart(0.0), (0.8, 0.5)
    motion, wrench = Motion(np.zeros(3), np.array([u, r])), np.array([20.0, 6.0, 0, 0, 0, 2.0])
    dr = model.state_rate(model.state(motion.pose_sb, motion.velocity), wrench[[0, 1, 5]])[4]
    expected = 24.0 * (u * r + 0.35 * dr - 0.06 * r**2) - 6.0
    assert FloorReaction.of(model, motion).lateral(wrench) == pytest.approx(expected, rel=1e-12)


def test_at_rest_and_pushed():
    """Idle, the weight as WheelSet spreads it. A push at the handle loads the front by its lever over the track."""
    model = cart()
    floor = FloorReaction.of(model)
    idle = floor.loads(np.zeros(6))
    assert idle == pytest.approx(model.wheel_set.loads(model.inertia.phi), rel=1e-12)
    assert floor.lateral(np.zeros(6)) == pytest.approx(0.0, abs=1e-12)
    pushed = floor.loads(grasp_map_spatial((-0.25, 0.06, 1.0)) @ np.array([48.0, 0, 0, 0, 0, 0]))
    carried_forward = 48.0 * (1.0 - HEIGHT) / (0.8 - 0.1)  # 24 kg take 2 m/s²: force at 1 m, inertia at the CoM
    assert pushed[2] - idle[2] == pytest.approx(carried_forward, rel=1e-9)
    assert pushed.sum() == pytest.approx(24 * 9.81)


@pytest.mark.parametrize("as_unknown", [False, True])
@pytest.mark.parametrize("heading", [0.0, 0.7, -2.5])
def test_weight_on_a_slope_leans_on_the_lower_wheels(heading, as_unknown):
    """In space: gravity is tilted and pulls at the CoM. Hands on the floor hold the cart; or it rolls down freely, and
    leans no more than on a level floor."""
    grade = np.array([0.06, -0.04])
    level = cart(None)
    sloped = level.with_effect(FloorSlope(*grade))
    if as_unknown:
        d = level.inertia.com
        moments = d[0] * grade[1] - d[1] * grade[0], -d[0] * grade[0] - d[1] * grade[1]
        sloped = level.with_effect(UnknownSlope(*grade, *moments))
    motion = Motion(np.array([0.0, 0.0, heading]), np.zeros(3))
    back = np.array([[np.cos(heading), np.sin(heading)], [-np.sin(heading), np.cos(heading)]])
    pull, com = np.append(-24.0 * 9.81 * back @ grade, -24.0 * 9.81), np.array([0.35, 0.06, HEIGHT])
    held = np.concatenate([-pull[:2], [0, 0, 0], [-np.cross(com, pull)[2]]])
    floor = FloorReaction.of(sloped, motion)
    loads = floor.loads(held)
    moment = sum(np.cross([w.x, w.y, 0.0], [0, 0, load]) for w, load in zip(TRICYCLE, loads, strict=True))
    assert moment + np.cross(com, pull) + held[3:] == pytest.approx(np.zeros(3), abs=1e-9)
    assert loads.sum() == pytest.approx(24.0 * 9.81)
    assert floor.loads(np.zeros(6)) == pytest.approx(FloorReaction.of(level, motion).loads(np.zeros(6)), rel=1e-9)


CARTS = {
    "axle ahead": (cg.RollingConstraints(0.1), ()),
    "axle": (cg.RollingConstraints(0.0), ()),
    "casters": (cg.RollingConstraints(None), ()),
    "rail": (cg.RollingConstraints(0.1, no_rotation=True), ()),
    "wheels at an angle": (cg.RollingConstraints(0.1), (WheelMisalignment(0.3),)),
}


@pytest.mark.parametrize("name", CARTS)
def test_partials_by_the_parameters(name):
    """Against differences of the kernel's, extrapolated to no step; effects that depend on phi, and change it."""
    constraints, turned = CARTS[name]
    rng = np.random.default_rng(constraints.n_free)
    effects = (
        ViscousDrag(3.0, 1.2),
        RollingResistance(0.02),
        PayloadChange(0.5, 4.0, 0.2, 0.1),
        LoadSlosh(5.0),
        FloorSlope(0.05, -0.03),
        UnknownSlope(0.02, 0.01, 0.003, -0.002),
        *turned,
    )
    model = replace(cart(effects=effects), constraints=constraints)
    motion = Motion(rng.uniform(-2, 2, 3), rng.uniform(0.3, 1.5, constraints.n_free))
    (floor, partials), p = FloorReaction.with_partials(model, motion, 1.0), len(model.parameters)
    np.testing.assert_array_equal(floor.rows, FloorReaction.of(model, motion, 1.0).rows)
    changing = np.arange(p) < p - len(turned)  # another angle is another model
    for direction in (*np.eye(p)[changing], rng.normal(size=p) * changing):
        slope = FloorReaction(np.tensordot(direction, partials, 1))
        for field in ("load_map", "load_offset", "lateral_map", "lateral_offset"):
            wide, near = (difference(model, motion, step * direction, field) / step for step in (2e-3, 1e-3))
            assert getattr(slope, field) == pytest.approx((4 * near - wide) / 3, rel=1e-6, abs=1e-6), field


def difference(model, motion, change, name):
    there = (model.with_parameters(model.parameters + sign * change) for sign in (0.5, -0.5))
    up, down = (getattr(FloorReaction.of(one, motion, 1.0), name) for one in there)
    return up - down


def test_partials_at_the_bound_of_an_effect_are_whole():
    """A drag may not be negative: what it adds counts, not half of it."""
    motion = Motion(np.zeros(3), np.array([0.8, 0.5]))
    still, dragged = (cart(effects=(ViscousDrag(drag, 0.0),)) for drag in (0.0, 1e-3))
    slope = FloorReaction(FloorReaction.with_partials(still, motion)[1][-2])
    grown = FloorReaction.of(dragged, motion).load_offset - FloorReaction.of(still, motion).load_offset
    assert np.abs(grown).max() > 1e-5
    assert slope.load_offset == pytest.approx(grown / 1e-3, rel=1e-6)


def test_what_loads_need():
    for changes in ({"wheels": ()}, {"com_height": None}):
        model = cg.CartModel(cg.Inertia(24.0, (0.3, 0.0), 2.0), **({"wheels": TRICYCLE, "com_height": 0.4} | changes))
        with pytest.raises(UsageError, match="wheels and com_height are needed"):
            check_loads(model)
        for floor in (FloorReaction.of(model), FloorReaction(FloorReaction.with_partials(model)[1])):
            assert floor.load_map.size == floor.load_offset.size == 0  # the lateral force is told all the same
            assert np.abs(floor.lateral_map).max() > 0


def test_casters_leave_a_push_to_the_mass():
    """No lateral force; the loads turn with what the hands and the drag together would accelerate."""
    model = cart(None, effects=(ViscousDrag(3.0, 1.2),))
    motion = Motion(np.zeros(3), np.array([0.6, -0.4, 0.5]))
    floor, wrench = FloorReaction.of(model, motion), np.array([20.0, 6.0, 3.0, 1.0, -2.0, 2.0])
    assert floor.lateral(wrench) == pytest.approx(0.0, abs=1e-12)
    loads, drag = floor.loads(wrench), model.effect_wrench(model.state(motion.pose_sb, motion.velocity))
    places, (fx, fy) = np.array([(w.x, w.y) for w in TRICYCLE]), wrench[:2] + drag[:2]
    weight = 24.0 * 9.81
    assert loads.sum() == pytest.approx(weight - 3.0)
    assert loads @ places == pytest.approx([weight * 0.35 - 2.0 - HEIGHT * fx, weight * 0.06 - 1.0 - HEIGHT * fy])
