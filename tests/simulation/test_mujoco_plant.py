"""Two independent engines, one cart: MuJoCo's contacts, hinges and friction losses against `CartModel.rate`.

Where they differ by structure, and by how much, is said beside each tolerance:

- the wheels' spin resists a forward push like 0.1 % more mass;
- the model smooths Coulomb friction below 2 mm/s of rolling and `smoothing_rate` of swivelling, MuJoCo none;
- an axle drifts outwards in a curve by 1 ms times u r (`mujoco_cart.py`), 1-2 mm in these runs.
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import ClassVar, final

import mujoco
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from cartgrasp.constraints import RollingConstraints
from cartgrasp.contacts import ContactWrenches, grasp_map_planar
from cartgrasp.effects import (
    CasterRealignment,
    ForceBias,
    ForceEffect,
    LearnedForce,
    PayloadChange,
    RollingResistance,
    ViscousDrag,
)
from cartgrasp.effects.effect import Contribution
from cartgrasp.errors import PlantError, UsageError
from cartgrasp.inertia import Inertia
from cartgrasp.model import CartModel
from cartgrasp.simulation.mujoco_cart import MujocoCart, mechanisms_of, patches, physical_wheels
from cartgrasp.simulation.mujoco_plant import MujocoPlant
from cartgrasp.wheels import GRAVITY, Wheel, WheelSet

TRAIL = 0.045
CONTROL = 0.01
BED_CASTERS = tuple(Wheel("caster", x, y, TRAIL) for x in (-0.9, 0.9) for y in (-0.4, 0.4))
ALL_CASTERS, RAIL = RollingConstraints(None), RollingConstraints(0.0, True)


def wheels(trail=TRAIL, axle_x=0.0):
    fixed = tuple(Wheel("fixed", axle_x, y) for y in (0.27, -0.27))
    return (*fixed, *(Wheel("caster", axle_x + 0.72, y, trail) for y in (0.2, -0.2)))


def shopping_cart(*effects, com=(0.3, 0.0), trail=TRAIL, **changes):
    settings = {"wheels": wheels(trail), "com_height": 0.45, **changes}
    return CartModel(Inertia(24.0, com, 2.0), effects=effects, **settings)


def hospital_bed(*effects):
    return CartModel(Inertia(150.0, (0.1, 0.05), 60.0), ALL_CASTERS, effects, BED_CASTERS, com_height=0.7)


def wrench(fx=0.0, fy=0.0, tau=0.0, at=(0.0, 0.0, 0.0), yaw=0.0):
    return ContactWrenches({"arm": np.array([fx, fy, 0, 0, 0, tau])}, {"arm": np.array(at, dtype=float)}, {"arm": yaw})


def push(plant, wrench_of_time, duration):
    """Poses and free velocities (n, 3 + n_free) at each control step; wrenches are held at their middle."""
    rows = []
    for i in range(round(duration / CONTROL)):
        plant.step(wrench(*wrench_of_time((i + 0.5) * CONTROL)), CONTROL)
        rows.append(np.concatenate([plant.motion.pose_sb, plant.motion.velocity]))
    return np.array(rows)


def integrated(cart, wrench_of_time, duration, velocity=None, heading=None):
    """The states of the model at the same instants, by a stiff solver of high order."""
    state = cart.state(velocity=velocity)
    if heading is not None:
        state[cart.memory_slice] = heading
    times = CONTROL * np.arange(1, round(duration / CONTROL) + 1)
    solution = solve_ivp(
        lambda t, y: cart.rate(y, np.array(wrench_of_time(t), dtype=float), time=t).value,
        (0.0, times[-1]), state, method="LSODA", t_eval=times, rtol=1e-7, atol=1e-9, max_step=0.05,
        jac=lambda t, y: cart.rate(y, np.array(wrench_of_time(t), dtype=float), time=t).by_state,
    )  # fmt: skip
    assert solution.success
    return solution.y.T


def rolling_cart(seed):
    rng = np.random.default_rng(10 + seed)
    com = (rng.uniform(0.15, 0.4), rng.uniform(-0.08, 0.08))
    return shopping_cart(ViscousDrag(8.0, 4.0), RollingResistance(0.02), com=com)


def curve(fx, tau):
    return lambda time: (fx, 0.0, tau * np.sin(1.5 * time))


def turning(time):
    return 14.0, 0.0, 6.0


def apart(one, other):
    """Largest distance between two paths, m."""
    return np.hypot(*(one[:, :2] - other[:, :2]).T).max()


# --- the compiled cart --------------------------------------------------------------------------------------


def planar_inertia(model, data):
    """(m, com, yaw inertia about the CoM) from bodies' masses, frames and principal inertias."""
    mass, place = model.body_mass[1:], data.xipos[1:]
    rotation = data.ximat[1:].reshape(-1, 3, 3)
    com = mass @ place / mass.sum()
    own = np.einsum("nij,nj->ni", rotation**2, model.body_inertia[1:])[:, 2]
    return mass.sum(), com, (own + mass * ((place - com)[:, :2] ** 2).sum(axis=1)).sum()


@pytest.mark.parametrize("heading", [0.0, 1.0, 3.0])
@pytest.mark.parametrize(
    "cart",
    [
        shopping_cart(),
        shopping_cart(com=(0.17, -0.08), wheels=()),
        CartModel(Inertia(6.0, (0.3, 0.02), 0.01), wheels=wheels(), com_height=0.1),
        CartModel(Inertia(40.0, (0.5, 0.0), 8.0), RollingConstraints(0.2), wheels=wheels(axle_x=0.2)),
        hospital_bed(),
    ],
    ids=["shopping cart", "no wheels listed", "little inertia", "axle off the origin", "bed"],
)
def test_the_compiled_cart_has_the_inertia_of_the_file(cart, heading):
    model = MujocoCart.of(cart).compile(0.0)
    data = mujoco.MjData(model)
    swivels = [i for i in range(model.njnt) if model.joint(i).name.startswith("swivel")]
    data.qpos[model.jnt_qposadr[swivels]] = heading
    mujoco.mj_forward(model, data)
    mass, com, about_com = planar_inertia(model, data)
    height = 0.5 if cart.com_height is None else cart.com_height
    np.testing.assert_allclose(mass, cart.inertia.mass, rtol=1e-12)
    np.testing.assert_allclose(com, [*cart.inertia.com, height], atol=1e-12)
    np.testing.assert_allclose(about_com, cart.inertia.about_com, rtol=1e-12)
    np.testing.assert_allclose(data.subtree_com[1], com, atol=1e-12)


def test_the_composite_inertia_of_a_free_cart_is_its_planar_one():
    """MuJoCo's own joint-space inertia of the base: m, m dx, m dy and J."""
    cart = shopping_cart(com=(0.2, 0.1))
    model = MujocoCart.of(cart).compile(0.0)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    matrix = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, matrix)
    m, mx, my, J = cart.inertia.phi
    found = matrix[np.ix_([0, 1, 5], [0, 1, 5])]
    np.testing.assert_allclose(found, [[m, 0, -my], [0, m, mx], [-my, mx, J]], rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("com", [(0.3, 0.0), (0.2, 0.08), (0.5, -0.05)])
def test_loads_at_rest_are_the_static_ones_at_the_patches(com):
    cart = shopping_cart(com=com)
    plant = MujocoPlant(cart)
    touching = patches(cart.wheels, np.zeros(2))
    static = WheelSet(tuple(Wheel("fixed", x, y) for x, y in touching)).loads(cart.inertia.phi)
    np.testing.assert_allclose(plant.wheel_loads(), static, rtol=1e-4)
    short = shopping_cart(com=com, trail=1e-4)  # the listed loads are those at the pivots
    listed = short.wheel_set.loads(short.inertia.phi)
    np.testing.assert_allclose(MujocoPlant(short).wheel_loads(), listed, rtol=1e-3)


# --- straight -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("height", [0.0, 1.0])
@pytest.mark.parametrize("coefficient", [0.0, 0.01, 0.03])
def test_a_straight_push_against_its_closed_form(coefficient, height):
    """m u' = fx - c m g - d u; also for a push at 1 m, as the resistance is that of static loads."""
    cart = shopping_cart(RollingResistance(coefficient), ViscousDrag(8.0, 1.0))
    plant, force, mass = MujocoPlant(cart), 20.0, cart.inertia.mass
    net = force - coefficient * mass * GRAVITY
    for _ in range(20):
        plant.step(wrench(force, at=(-0.25, 0.0, height)), 0.1)
        u = net / 8.0 * (1 - np.exp(-8.0 * plant.time / mass))
        np.testing.assert_allclose(plant.motion.velocity, [u, 0.0], rtol=0.003, atol=1e-6)
    np.testing.assert_allclose(plant.motion.pose_sb[1:], 0.0, atol=1e-6)


def test_rolling_resistance_brakes_to_standstill_and_holds():
    """A push of 0.9 c m g creeps at some 0.02 mm/s: frictionloss is a little soft."""
    cart = shopping_cart(RollingResistance(0.03))
    plant = MujocoPlant(cart, velocity=(0.6, 0.0))
    plant.step(ContactWrenches(), 1.0)
    np.testing.assert_allclose(plant.motion.velocity[0], 0.6 - 0.03 * GRAVITY, rtol=0.005)
    plant.step(ContactWrenches(), 2.0)
    still = plant.motion.pose_sb
    plant.step(wrench(0.9 * 0.03 * cart.inertia.mass * GRAVITY), 1.0)
    np.testing.assert_allclose(plant.motion.pose_sb, still, atol=5e-5)


@pytest.mark.parametrize("pose", [(0.0, 0.0, 0.0), (3.0, -2.0, 2.5)])
def test_a_cart_left_alone_stays_where_it_was_put(pose):
    """Without friction it rolls a little, since the floor gives 1 µm and less under the lighter side."""
    plant = MujocoPlant(shopping_cart(com=(0.3, 0.05)), pose)
    assert plant.time == 0.0
    np.testing.assert_array_equal(plant.motion.pose_sb, pose)
    np.testing.assert_array_equal(plant.motion.velocity, 0.0)
    first = plant.wheel_loads()
    for _ in range(100):
        plant.step(ContactWrenches(), 0.01)
        np.testing.assert_allclose(plant.motion.velocity, 0.0, atol=2e-5)
        np.testing.assert_allclose(plant.wheel_loads(), first, rtol=1e-3)
    np.testing.assert_allclose(plant.motion.pose_sb, pose, atol=1e-5)
    assert plant.time == pytest.approx(1.0, abs=1e-12)


def test_a_cart_put_in_motion_rolls_at_once():
    """Hinges of wheels and forks turn with the cart from the first step on: no wheel has to be spun up."""
    plant = MujocoPlant(shopping_cart(com=(0.3, 0.05)), velocity=(0.8, 1.0), heading=(0.5, -1.0))
    begin = plant._data.qvel.copy()
    assert np.abs(begin[6:]).min() > 1.0
    plant.step(ContactWrenches(), 0.001)
    np.testing.assert_allclose(plant._data.qvel, begin, atol=0.15)
    np.testing.assert_allclose(plant.motion.velocity, (0.8, 1.0), atol=0.005)


def test_fixed_wheels_creep_less_than_a_micrometre_a_second():
    """40 N across at the axle; 60 N would be their friction at a coefficient of 0.5, they have 1.5."""
    plant = MujocoPlant(shopping_cart())
    plant.step(wrench(fy=40.0), 0.5)
    begin = plant.motion.pose_sb
    plant.step(wrench(fy=40.0), 2.0)
    np.testing.assert_allclose((plant.motion.pose_sb - begin) / 2.0, 0.0, atol=1e-6)
    assert plant.lateral_force == pytest.approx(-40.0, rel=1e-4)


# --- curves -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(4))
def test_a_curve_without_coulomb_friction(seed):
    """Position within 5 mm after 5 s and 4-5 m, of which wheel spin makes 3."""
    rng = np.random.default_rng(seed)
    com = (rng.uniform(0.15, 0.4), rng.uniform(-0.1, 0.1))
    cart = shopping_cart(ViscousDrag(8.0, 4.0), com=com)
    ours = integrated(cart, curve(14.0, 3.0), 5.0)
    theirs = push(MujocoPlant(cart), curve(14.0, 3.0), 5.0)
    assert apart(ours, theirs) < 0.005
    np.testing.assert_allclose(theirs[:, 3:], ours[:, 3:5], atol=0.002)


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("begin", [0.0, 0.6])
def test_a_curve_with_rolling_resistance(seed, begin):
    """Casters drag along their own headings, also those of a cart that starts at rest: 5 mm again."""
    cart, forces = rolling_cart(seed), curve(18.0, 3.0)
    ours = integrated(cart, forces, 5.0, velocity=(begin, 0.0))
    theirs = push(MujocoPlant(cart, velocity=(begin, 0.0)), forces, 5.0)
    assert apart(ours, theirs) < 0.005
    np.testing.assert_allclose(theirs[:, 3:], ours[:, 3:5], atol=0.003)


def test_a_curve_with_the_axle_off_the_origin():
    cart = CartModel(
        Inertia(40.0, (0.5, 0.05), 8.0), RollingConstraints(0.2), (ViscousDrag(8.0, 6.0),), wheels(axle_x=0.2)
    )
    ours = integrated(cart, curve(14.0, 5.0), 5.0)
    theirs = push(MujocoPlant(cart), curve(14.0, 5.0), 5.0)
    assert apart(ours, theirs) < 0.005
    np.testing.assert_allclose(theirs[:, 3:], ours[:, 3:5], atol=0.003)


def test_lateral_force_of_the_axle_and_its_velocity():
    """lambda = m (u r + dx r' - dy r²) - fy (physics.md) in a steady turn with a side push at the axle."""
    com = (0.3, 0.05)
    cart = shopping_cart(ViscousDrag(8.0, 4.0), com=com)
    plant = MujocoPlant(cart)
    plant.step(wrench(10.0, -6.0, 2.0), 8.0)
    rate = cart.rate(cart.state(velocity=plant.motion.velocity), np.array([10.0, -6.0, 2.0])).value
    u, r = plant.motion.velocity
    expected = 24.0 * (u * r + com[0] * rate[4] - com[1] * r**2) + 6.0
    assert abs(expected) > 5.0
    assert plant.lateral_force == pytest.approx(expected, rel=0.01)
    assert abs(plant.velocity_b[1]) < 1.1e-3 * u * r
    np.testing.assert_array_equal(plant.velocity_b[[0, 2]], plant.motion.velocity)


def test_the_yaw_goes_on_past_a_full_turn():
    cart = shopping_cart(ViscousDrag(8.0, 4.0))
    ours = integrated(cart, lambda _: (6.0, 0.0, 14.0), 6.0)
    theirs = push(MujocoPlant(cart), lambda _: (6.0, 0.0, 14.0), 6.0)
    assert ours[-1, 2] > 2 * np.pi
    np.testing.assert_allclose(theirs[:, 2], ours[:, 2], atol=0.03)


# --- casters ------------------------------------------------------------------------------------------------


def energy(cart, velocity):
    u, r = velocity
    mass, (dx, dy), inertia = cart.inertia.mass, cart.inertia.com, cart.inertia.about_com
    return 0.5 * mass * ((u - dy * r) ** 2 + (dx * r) ** 2) + 0.5 * inertia * r**2


def reversal(torque, off=0.05):
    """Way, headings and energy lost while a cart is pulled back whose casters trail a forward push."""
    cart = shopping_cart(CasterRealignment(torque) if torque else ViscousDrag())
    plant = MujocoPlant(cart, velocity=(-0.3, 0.0), heading=(off, -off))
    rows = []
    work = energy(cart, (-0.3, 0.0))
    for _ in range(400):
        before = plant.motion.pose_sb[0]
        plant.step(wrench(-15.0), 0.002)
        work += -15.0 * (plant.motion.pose_sb[0] - before)
        rows.append(
            [
                -plant.motion.pose_sb[0],
                *np.array(plant.caster_headings),
                work - energy(cart, plant.motion.velocity),
            ]
        )
    return np.array(rows)


def test_casters_swing_round_after_a_reversal_along_the_trail_model():
    """tan(psi / 2) falls by 1/e a trail (physics.md): from pi - 0.05 to 0.05 it takes 7.4 trails."""
    rows = reversal(0.0)
    turned = np.abs(rows[:, 1:3])
    way = np.interp(np.pi - 0.05, turned[:, 0], rows[:, 0])
    assert way / TRAIL == pytest.approx(2 * np.log(1 / np.tan(0.025)), rel=0.02)
    psi = 2 * np.arctan(np.exp(np.log(np.tan((np.pi - 0.05) / 2)) - rows[:, 0] / TRAIL))
    np.testing.assert_allclose(np.pi - turned, np.stack([psi, psi], -1), atol=0.02)
    np.testing.assert_allclose(rows[:, 3], 0.0, atol=0.02)


def test_swivel_friction_takes_its_torque_times_the_angle():
    """Two casters take T pi each, whatever the way; the pull's work and the kinetic energy tell."""
    torque = 0.3
    rows = reversal(torque)
    angle = np.abs(rows[-1, 1:3] - (0.05, -0.05)).sum()
    assert angle == pytest.approx(2 * (np.pi - 0.05), rel=0.03)
    assert rows[-1, 3] == pytest.approx(torque * angle, rel=0.02)
    assert rows[-1, 3] == pytest.approx(torque * 2 * np.pi, rel=0.1)


@pytest.mark.parametrize(("smoothing", "low", "high"), [(0.2, 0.2, 0.4), (0.01, 0.0, 0.05)])
def test_swivel_friction_is_coulombs_once_its_smoothing_is_small(smoothing, low, high):
    """Casters of 0.05 N·m: smoothed over 0.2 rad/s the carts part by 0.3 m in 5 s. The gap closes with the
    smoothing, so the effect's formula is right and its smoothing is what is coarse."""
    cart = shopping_cart(CasterRealignment(0.05, smoothing_rate=smoothing), ViscousDrag(8.0, 4.0), com=(0.35, 0.03))
    ours = integrated(cart, curve(14.0, 3.0), 5.0, velocity=(0.6, 0.0))
    theirs = push(MujocoPlant(cart, velocity=(0.6, 0.0)), curve(14.0, 3.0), 5.0)
    assert low <= apart(ours, theirs) < high


@pytest.mark.parametrize("scrub", [0.03, 0.06])
def test_tyres_scrub_as_torsional_friction_does(scrub):
    """In a turn without end swivels rest, and tyres scrub on: by a metre or two in 5 s. Smoothing is small, as above;
    MuJoCo's loads are at the patches, and by a fifteenth larger."""
    drag, com, casters = ViscousDrag(8.0, 4.0), (0.35, 0.03), CasterRealignment(scrub_torque=scrub, smoothing_rate=0.01)
    cart, bare = shopping_cart(casters, drag, com=com), shopping_cart(drag, com=com)
    ours, without = (integrated(each, turning, 5.0, velocity=(0.6, 0.0)) for each in (cart, bare))
    theirs = push(MujocoPlant(cart, velocity=(0.6, 0.0)), turning, 5.0)
    assert 0.02 < apart(ours, theirs) < 0.12 * apart(ours, without)


def test_the_trail_of_the_effect_wins_over_the_listed_one():
    listed = MujocoCart.of(shopping_cart(CasterRealignment(0.3)))
    given = MujocoCart.of(shopping_cart(CasterRealignment(0.3, trail=0.03)))
    unknown = MujocoCart.of(shopping_cart(CasterRealignment(0.3), trail=0.0))
    assert [cart.wheels[2].trail for cart in (listed, given, unknown)] == [TRAIL, 0.03, 0.045]
    assert given.compile(0.0).joint("swivel2").frictionloss[0] == 0.3


def test_caster_headings_begin_as_told_and_are_none_without_casters():
    plant = MujocoPlant(shopping_cart(), heading=(0.5, -2.0))
    np.testing.assert_allclose(np.array(plant.caster_headings), np.array([0.5, -2.0]))
    assert MujocoPlant(shopping_cart(constraints=RAIL)).caster_headings is None


# --- other carts --------------------------------------------------------------------------------------------


def test_a_bed_on_casters_alone_moves_as_its_model():
    """Starts along its casters' heading; 0 rows, so nu = (u, w, r)."""
    cart = hospital_bed(ViscousDrag(30.0, 20.0))

    def sway(time):
        return 60.0, 20.0 * np.sin(time), 8.0 * np.cos(time)

    ours = integrated(cart, sway, 5.0, velocity=(0.5, 0.0, 0.0))
    theirs = push(MujocoPlant(cart, velocity=(0.5, 0.0, 0.0)), sway, 5.0)
    assert apart(ours, theirs) < 0.005
    np.testing.assert_allclose(theirs[:, 3:], ours[:, 3:6], atol=0.003)


def test_a_cart_that_lists_no_casters_gets_one_where_its_effect_says_and_listed_ones_move():
    bare = shopping_cart(CasterRealignment(0.3, x=0.65), wheels=())
    assert np.array(MujocoPlant(bare).caster_headings).shape == (1,)
    listed = shopping_cart(CasterRealignment(0.3, x=-0.07))
    places = [wheel.x for wheel in physical_wheels(listed, mechanisms_of(listed)) if wheel.kind == "caster"]
    np.testing.assert_allclose(places, [wheel.x - 0.07 for wheel in listed.wheels if wheel.kind == "caster"])
    casters = [wheel for wheel in physical_wheels(bare, mechanisms_of(bare)) if wheel.kind == "caster"]
    assert [(wheel.x, wheel.y) for wheel in casters] == [(0.65, 0.0)]
    bed = CartModel(Inertia(150.0, (0.1, 0.05), 60.0), ALL_CASTERS, (CasterRealignment(0.3, x=0.1),))
    assert np.array(MujocoPlant(bed).caster_headings).shape == (4,)


def test_a_bed_without_listed_casters_gets_four():
    cart = CartModel(Inertia(150.0, (0.1, 0.05), 60.0), ALL_CASTERS)
    plant = MujocoPlant(cart)
    assert np.array(plant.caster_headings).shape == (4,)
    assert plant.wheel_loads().sum() == pytest.approx(150.0 * GRAVITY, rel=1e-4)


@pytest.mark.parametrize("pose", [(0.0, 0.0, 0.0), (1.0, 2.0, 0.7)])
def test_a_cart_on_a_rail_is_one_mass_with_friction(pose):
    cart = shopping_cart(RollingResistance(0.02), ViscousDrag(8.0, 4.0), constraints=RAIL, wheels=())
    plant = MujocoPlant(cart, pose, velocity=(0.2,))
    plant.step(wrench(20.0, 7.0, 3.0, at=(0.0, 0.3, 1.0)), 2.0)
    slowed = np.exp(-8.0 * 2.0 / 24.0)
    last = (20.0 - 0.02 * 24.0 * GRAVITY) / 8.0
    speed, way = last + (0.2 - last) * slowed, last * 2.0 + (0.2 - last) * (1 - slowed) * 24.0 / 8.0
    np.testing.assert_allclose(plant.motion.velocity, [speed], rtol=1e-3)
    c, s = np.cos(pose[2]), np.sin(pose[2])
    np.testing.assert_allclose(plant.motion.pose_sb - pose, [c * way, s * way, 0.0], atol=2e-3)
    np.testing.assert_allclose(plant.velocity_b, [plant.motion.velocity[0], 0.0, 0.0])
    assert plant.lateral_force == -7.0
    np.testing.assert_allclose(plant.wheel_loads(), [24.0 * GRAVITY])


@pytest.mark.parametrize("com_x", [0.3, -0.2])
def test_a_cart_without_listed_wheels_gets_usual_ones_that_carry_it(com_x):
    cart = shopping_cart(RollingResistance(0.02), ViscousDrag(8.0, 4.0), com=(com_x, 0.0), wheels=())
    plant = MujocoPlant(cart)
    plant.step(wrench(20.0), 2.0)
    u = (20.0 - 0.02 * 24.0 * GRAVITY) / 8.0 * (1 - np.exp(-8.0 * 2.0 / 24.0))
    assert plant.wheel_loads().min() > 20.0
    assert plant.motion.velocity[0] == pytest.approx(u, rel=0.02)


# --- payloads, contacts, determinism ------------------------------------------------------------------------


@pytest.mark.parametrize("coefficient", [0.0, 0.02])
@pytest.mark.parametrize("instant", [1.0, 1.0004])
def test_a_payload_joins_at_the_carts_velocity(instant, coefficient):
    load = PayloadChange(instant, 8.0, 0.4, 0.1)
    cart = shopping_cart(load, ViscousDrag(8.0, 4.0), RollingResistance(coefficient))
    plant = MujocoPlant(cart, velocity=(0.5, 0.0))
    before = push(plant, curve(18.0, 3.0), 1.0)
    plant.step(wrench(18.0), 0.001)
    np.testing.assert_allclose(plant.motion.velocity, before[-1, 3:], atol=0.01)
    assert plant.wheel_loads().sum() == pytest.approx(32.0 * GRAVITY, rel=0.02)
    ours = integrated(cart, curve(18.0, 3.0), 4.0, velocity=(0.5, 0.0))
    theirs = push(MujocoPlant(cart, velocity=(0.5, 0.0)), curve(18.0, 3.0), 4.0)
    assert apart(ours, theirs) < (0.02 if coefficient else 0.005)
    model = plant._cart.compile(2.0)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    after = Inertia.from_phi(cart.phi_at(2.0))
    np.testing.assert_allclose(planar_inertia(model, data)[0], after.mass, rtol=1e-12)
    np.testing.assert_allclose(planar_inertia(model, data)[1][:2], after.com, atol=1e-12)
    np.testing.assert_allclose(planar_inertia(model, data)[2], after.about_com, rtol=1e-12)


def test_a_turned_contact_and_several_arms_give_their_planar_wrench():
    cart = shopping_cart(ViscousDrag(8.0, 4.0))
    points = {"left": (-0.25, 0.2, 0.9), "right": (-0.25, -0.2, 0.9)}
    forces = {
        "left": np.array([9.0, 2.0, 3.0, 0.1, 0.2, 0.4]),
        "right": np.array([6.0, -4.0, -2.0, 0, 0.3, -0.2]),
    }
    yaws = {"left": 0.6}
    held = ContactWrenches(forces, {k: np.array(v) for k, v in points.items()}, yaws)
    total = sum(grasp_map_planar(points[arm], yaws.get(arm, 0.0)) @ forces[arm] for arm in points)
    one, other = MujocoPlant(cart), MujocoPlant(cart)
    one.step(held, 2.0)
    other.step(wrench(*total), 2.0)
    np.testing.assert_allclose(one.motion.pose_sb, other.motion.pose_sb, atol=2e-4)
    np.testing.assert_allclose(one.motion.velocity, other.motion.velocity, atol=2e-4)
    assert abs(other.motion.pose_sb[2]) > 0.1


def test_a_push_high_up_shifts_the_loads():
    """At constant acceleration the pitch moment about the floor is fx z - m u' h."""
    cart = shopping_cart()
    plant = MujocoPlant(cart)
    rest = plant.wheel_loads()
    plant.step(wrench(12.0, at=(-0.25, 0.0, 1.0)), 0.5)
    shift = (12.0 * 1.0 - 12.0 * 0.45) / (0.72 - TRAIL)
    np.testing.assert_allclose(plant.wheel_loads() - rest, np.array([-1, -1, 1, 1]) * shift / 2, rtol=0.02)


def test_the_same_inputs_give_the_same_bytes():
    def bytes_of_a_run():
        cart = shopping_cart(RollingResistance(0.02), CasterRealignment(0.2), PayloadChange(0.7, 5.0, 0.3, 0.1))
        plant = MujocoPlant(cart, (0.3, 0.1, 1.0), heading=0.1)
        return push(plant, curve(20.0, 5.0), 1.5).tobytes()

    assert bytes_of_a_run() == bytes_of_a_run()


def test_control_periods_need_not_be_whole_physics_steps():
    cart = shopping_cart(ViscousDrag(8.0, 4.0))
    fine, coarse = MujocoPlant(cart), MujocoPlant(cart)
    for _ in range(300):
        fine.step(wrench(14.0, 0.0, 2.0), 1 / 300)
    coarse.step(wrench(14.0, 0.0, 2.0), 1.0)
    assert fine.time == pytest.approx(1.0)
    np.testing.assert_allclose(fine.motion.pose_sb, coarse.motion.pose_sb, atol=1e-3)


# --- what it refuses ----------------------------------------------------------------------------------------


@final
@dataclass(frozen=True)
class Glue(ForceEffect):
    name: ClassVar[str] = "glue"
    parameters: ClassVar[tuple] = ()
    signature: ClassVar[str] = "sticks"

    def wrench_b(self, situation, memory, parameters):
        return Contribution(np.zeros(3))


def test_sensors_are_none_of_its_business():
    cart = shopping_cart(ForceBias(fx=5.0))
    plant = MujocoPlant(cart)
    plant.step(ContactWrenches(), 0.5)
    np.testing.assert_allclose(plant.motion.velocity, 0.0, atol=1e-6)


@pytest.mark.parametrize(
    ("cart", "why"),
    [
        (shopping_cart(Glue()), "glue"),
        (shopping_cart(CasterRealignment(0.3), constraints=RAIL), "caster_realignment"),
        (
            shopping_cart(CasterRealignment(0.3, 0.1, label="a"), CasterRealignment(0.3, label="b")),
            "two trails",
        ),
        (shopping_cart(constraints=ALL_CASTERS), "fixed wheel forbids"),
        (shopping_cart(wheels=BED_CASTERS), "needs a fixed wheel"),
        (shopping_cart(constraints=RollingConstraints(0.1)), "off the axle"),
        (shopping_cart(com=(-0.1, 0.0)), "tips over"),
        (shopping_cart(wheels=wheels()[:2]), "at least 3 wheels"),
    ],
)
def test_carts_it_cannot_represent(cart, why):
    with pytest.raises(PlantError, match=why):
        MujocoPlant(cart)


def test_a_cart_that_is_pushed_over_is_reported():
    plant = MujocoPlant(shopping_cart())
    with pytest.raises(PlantError, match=r"tips over at 0\.\d"):
        plant.step(wrench(400.0, at=(-0.25, 0.0, 1.5)), 2.0)


def test_a_wheel_that_stays_off_the_floor_is_reported():
    """A lift between the casters, 5 N more than what balances the weight about the axle."""
    plant = MujocoPlant(shopping_cart(com_height=0.1))
    lift = 24.0 * GRAVITY * 0.3 / 0.72 + 5.0
    held = ContactWrenches({"arm": np.array([0.0, 0, lift, 0, 0, 0])}, {"arm": np.array([0.72, 0.0, 0.3])})
    with pytest.raises(PlantError, match=r"caster wheel at \(0.72, 0.2\) m has been off the floor"):
        plant.step(held, 2.0)


@pytest.mark.parametrize("bad", [np.nan, np.inf, 1e30])
def test_motion_that_is_not_finite_is_reported_and_leaves_no_file(bad, tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(tmp_path)
    plant = MujocoPlant(shopping_cart())
    with pytest.raises(PlantError, match="finite"):
        plant.step(wrench(bad), 0.5)
    assert not os.listdir(tmp_path)
    assert capfd.readouterr() == ("", "")


def test_what_is_refused_moves_nothing():
    plant = MujocoPlant(shopping_cart())
    plant.step(ContactWrenches({"arm": [5.0, 0, 0, 0, 0, 0]}, {"arm": [-0.25, 0, 1]}), 0.1)
    time, pose = plant.time, plant.motion.pose_sb
    for bad in (np.nan, np.inf, -1.0):
        with pytest.raises(UsageError, match="duration"):
            plant.step(wrench(5.0), bad)
    assert plant.time == time
    np.testing.assert_array_equal(plant.motion.pose_sb, pose)


def test_beginnings_that_are_none():
    for wrong, why in (
        ({"velocity": [1.0]}, "velocity"),
        ({"heading": [0.1] * 3}, "heading"),
        ({"heading": np.nan}, "heading"),
    ):
        with pytest.raises(UsageError, match=why):
            MujocoPlant(shopping_cart(), **wrong)


def test_accelerations_hear_of_laws_from_outside():
    law = LearnedForce("forward_force", "travelled_distance", knots=(0.0, 0.1), amplitudes=(0.0, 24.0))
    plant = MujocoPlant(shopping_cart(law))
    for _ in range(40):
        told, before = plant.acceleration(wrench(12.0)), plant.motion.velocity
        plant.step(wrench(12.0), CONTROL)
        np.testing.assert_allclose((plant.motion.velocity - before) / CONTROL, told, atol=0.05)
    assert told[0] > 0.75


def test_a_timestep_must_be_positive():
    with pytest.raises(UsageError, match="timestep"):
        MujocoPlant(shopping_cart(), timestep=0.0)
