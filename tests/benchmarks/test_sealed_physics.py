"""The sealed generator's physics against closed forms, and its vocabulary against the library's where both mean one."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import cartgrasp.effects as known
from benchmarks.sealed.body import find_rate
from benchmarks.sealed.cases import draw_case
from benchmarks.sealed.driver import advance
from benchmarks.sealed.rough import rough
from benchmarks.sealed.sensors import Sensors, noiseless, record
from benchmarks.sealed.strength import planar, regressors, strength
from benchmarks.sealed.world import BOB, BRISTLE, CASTER, GRAVITY, SIZE, THETA, R, U, W, World, X
from cartgrasp import CartModel, Inertia
from cartgrasp.constraints import RollingConstraints
from cartgrasp.wheels import Wheel

BARE = World(24.0, 0.3, 0.04, 2.0, 0.5, 0.27, 0.72, 0.2, 0.045)
STILL = np.zeros(5)
speeds = st.tuples(st.floats(-0.8, 0.8), st.floats(-0.6, 0.6))
wrenches = st.tuples(st.floats(-40, 40), st.floats(-20, 20), st.floats(-8, 8))


def moving(u=0.0, r=0.0, toe=0.0, heading=0.0):
    state = np.zeros(SIZE)
    state[THETA], state[U], state[W], state[R] = heading, u, u * math.tan(toe), r
    return state


def rate_of(state, world, wrench=(0.0, 0.0, 0.0), time=0.0):
    rate = np.empty(SIZE)
    find_rate(time, state, np.array([*wrench, 0.0, 0.0]), world, rate)
    return rate


def roll(state, world, duration, wrench=(0.0, 0.0, 0.0), step=1e-3):
    push = np.array([*wrench, 0.0, 0.0])
    for i in range(round(duration / step)):
        state, _ = advance(i * step, state, step, push, push, 0.0, world)
    return state


def kinetic_energy(state, world):
    u, w, r = state[U], state[W], state[R]
    vx, vy = u - world.com_y * r, w + world.com_x * r
    return 0.5 * world.mass * (vx**2 + vy**2) + 0.5 * world.inertia * r**2


@given(speeds, wrenches, st.floats(-0.1, 0.1))
def test_power_of_wrench_and_drag_is_all_that_changes_the_energy(speed, wrench, toe):
    """To first order, so M and C are right together, whatever the axle's angle."""
    world = BARE._replace(linear=5.0, angular=2.0, toe=toe)
    state = moving(*speed, toe)
    rate, h = rate_of(state, world, wrench), 1e-4
    change = (kinetic_energy(state + h * rate, world) - kinetic_energy(state - h * rate, world)) / (2 * h)
    u, w, r = state[U], state[W], state[R]
    power = wrench[0] * u + wrench[1] * w + wrench[2] * r - 5.0 * (u * u + w * w) - 2.0 * r * r
    assert change == pytest.approx(power, abs=1e-8)


def test_a_free_cart_keeps_its_energy_and_its_constraint():
    world = BARE._replace(toe=0.05)
    start = moving(0.6, 0.9, 0.05)
    end = roll(start, world, 5.0)
    assert kinetic_energy(end, world) == pytest.approx(kinetic_energy(start, world), rel=1e-9)
    assert abs(end[U] - start[U]) > 0.05
    assert end[W] == pytest.approx(end[U] * math.tan(0.05), abs=1e-14)


@given(st.floats(0.1, 0.8), st.floats(-60, 60), st.floats(0.0, 0.05), st.floats(0.0, 0.05))
def test_forces_balance_on_a_straight_line(u, force, rolling, spare):
    """Straight casters, CoM in the middle: dry friction of all wheels is that of the whole weight."""
    world = BARE._replace(com_y=0.0, linear=4.0, rolling=rolling, stiction=8.0, stiction_speed=0.2, quadratic=10.0)
    world = world._replace(forward=3.0, backward=50.0, patch_rolling=spare, patch_x_min=-9.0, patch_x_max=9.0)
    world = world._replace(patch_y_min=-9.0, patch_y_max=9.0)
    weight = world.mass * GRAVITY
    drag = 7.0 * u + 10.0 * u * u
    dry = (rolling + spare) * weight + 8.0 * math.exp(-u / 0.2)
    rate = rate_of(moving(u), world, (force, 0.0, 0.0))
    assert world.mass * rate[U] == pytest.approx(force - drag - dry * math.tanh(u / world.width), abs=1e-9)
    assert rate[R] == pytest.approx(0.0, abs=1e-12)


@given(st.floats(-3, 3), st.floats(-0.1, 0.1), st.floats(-0.1, 0.1))
def test_a_cart_on_a_slope_falls_by_the_sine_of_its_angle(heading, grade_x, grade_y):
    world = BARE._replace(com_y=0.0, grade_x=grade_x, grade_y=grade_y)
    pull = math.sin(math.atan(grade_x)) * math.cos(heading) + math.sin(math.atan(grade_y)) * math.sin(heading)
    assert rate_of(moving(heading=heading), world)[U] == pytest.approx(-GRAVITY * pull, abs=1e-12)


def test_a_free_caster_swings_round_within_its_trail():
    """tan(psi/2) falls by exp(-way / trail) (physics of a trailing wheel, Kane and Scher)."""
    state = moving(0.5)
    state[CASTER] = 2.9
    end = roll(state, BARE._replace(com_y=0.0), 0.4)
    way = end[X]
    assert way == pytest.approx(0.2, rel=1e-6)
    assert math.tan(end[CASTER] / 2) == pytest.approx(math.tan(1.45) * math.exp(-way / BARE.trail), rel=1e-5)


@given(st.floats(-3.1, 3.1), st.floats(-3.1, 3.1), speeds)
def test_casters_only_take_energy(left, right, speed):
    state, world = moving(*speed), BARE._replace(swivel=0.4, scrub=0.1, rolling=0.02)
    state[CASTER : CASTER + 2] = left, right
    rate, h = rate_of(state, world), 1e-5
    change = kinetic_energy(state + h * rate, world) - kinetic_energy(state - h * rate, world)
    assert change / (2 * h) <= 1e-9


def test_bristles_hold_until_they_slide():
    world = BARE._replace(com_y=0.0, rolling=0.03, bristle=1e-3)
    level = 0.03 * world.mass * GRAVITY
    held = roll(moving(), world, 5.0, (0.5 * level, 0.0, 0.0))
    assert held[X] < 2e-3
    assert abs(held[U]) < 1e-7
    np.testing.assert_allclose(held[BRISTLE : BRISTLE + 4], 0.5e-3, rtol=1e-3)
    let_go = roll(moving(), world, 2.0, (1.5 * level, 0.0, 0.0))
    later = roll(let_go, world, 1.0, (1.5 * level, 0.0, 0.0))
    assert later[U] - let_go[U] == pytest.approx(0.5 * level / world.mass, rel=1e-3)


@given(st.floats(0.4, 0.8), st.floats(-40, 40))
@settings(max_examples=10)
def test_tyres_creep_in_proportion_to_their_side_load(u, side):
    """At constant speed, a force at the axle: w = -u F / C, whatever the relaxation length."""
    world = BARE._replace(com_x=0.0001, com_y=0.0, cornering=400.0, relaxation=0.05)
    state = moving(u)
    for _ in range(2000):
        state, _ = advance(0.0, state, 2e-3, *[np.array([0.0, side, 0.0, 0.0, 0.0])] * 2, 0.0, world)
        state[U], state[R] = u, 0.0
    most = 0.9 * world.mass * GRAVITY
    deflected = most / 400.0 * math.atanh(side / most)
    assert state[W] == pytest.approx(u * deflected, rel=1e-3, abs=1e-9)


def test_the_bob_swings_at_its_frequency_and_keeps_energy():
    world = BARE._replace(com_y=0.0, bob_mass=8.0, bob_length=0.25)
    state = moving()
    state[BOB] = 0.2

    def energy(s):
        x_rate = world.bob_length * s[BOB + 1] * math.cos(s[BOB])
        z_rate = world.bob_length * s[BOB + 1] * math.sin(s[BOB])
        bob = 0.5 * 8.0 * ((s[U] + x_rate) ** 2 + z_rate**2) + 8.0 * GRAVITY * 0.25 * (1 - math.cos(s[BOB]))
        return 0.5 * 16.0 * s[U] ** 2 + bob

    end = roll(state, world, 3.0)
    assert energy(end) == pytest.approx(energy(state), rel=1e-8)
    free = math.sqrt(GRAVITY / 0.25 * 24.0 / 16.0)
    angles = []
    for _ in range(2000):
        angles.append(state[BOB])
        state, _ = advance(0.0, state, 1e-3, STILL, STILL, 0.0, world)
    crossing = np.flatnonzero(np.diff(np.sign(angles)))[:2]
    assert np.diff(crossing)[0] * 1e-3 == pytest.approx(math.pi / free, rel=0.02)


# --- the same words, the same meaning -----------------------------------------------------------------------

WHEELS = tuple(
    Wheel(kind, x, y, trail)
    for kind, x, y, trail in (
        ("fixed", 0.0, 0.27, 0.0),
        ("fixed", 0.0, -0.27, 0.0),
        ("caster", 0.72, 0.2, 0.045),
        ("caster", 0.72, -0.2, 0.045),
    )
)
ALIKE = {
    "viscous_drag": ({"linear": 5.0, "angular": 2.0}, {"linear": 5.0, "angular": 2.0}),
    "rolling_resistance": ({"coefficient": 0.03}, {"rolling": 0.03}),
    "directional_drag": ({"forward": 2.0, "backward": 9.0}, {"forward": 2.0, "backward": 9.0}),
    "floor_slope": ({"grade_x": 0.003, "grade_y": -0.002}, {"grade_x": 0.003, "grade_y": -0.002}),
    "floor_patch": (
        {"coefficient": 0.04, "x_min": -1.0, "x_max": 2.0, "y_min": 0.0, "y_max": 3.0},
        {
            "patch_rolling": 0.04,
            **{f"patch_{k}": v for k, v in {"x_min": -1.0, "x_max": 2.0, "y_min": 0.0, "y_max": 3.0}.items()},
        },
    ),
    "wheel_drag_imbalance": ({"force": 6.0, "moment": -6.0 * 0.27}, {"brake_right": 6.0}),
    "payload_change": (
        {"time": 1.0, "mass": 7.0, "x": 0.5, "y": -0.1},
        {"load_time": 1.0, "load_mass": 7.0, "load_x": 0.5, "load_y": -0.1},
    ),
    "external_push": (
        {"start": 1.0, "duration": 2.0, "force": 20.0, "moment": 4.0},
        {"push_start": 1.0, "push_duration": 2.0, "push_force": 20.0, "push_moment": 4.0},
    ),
}


@pytest.mark.parametrize("name", ALIKE)
@pytest.mark.parametrize("u", [0.5, -0.5])
def test_an_effect_means_what_the_vocabulary_says(name, u):
    """At speed, where widths don't matter, casters trail straight and both share loads alike."""
    parameters, changes = ALIKE[name]
    effect = known.KNOWN_EFFECTS[name](**parameters)
    world = BARE._replace(com_y=0.0, **changes)
    cart = CartModel(Inertia(24.0, (0.3, 0.0), 2.0), RollingConstraints(0.0), (effect,), WHEELS)
    state = moving(u, heading=0.8)
    state[CASTER : CASTER + 2] = 0.0 if u > 0 else math.pi
    theirs = cart.state_rate(cart.state((0.0, 0.0, 0.8), (u, 0.0)), np.array([20.0, 3.0, 1.0]), time=2.0)
    ours = rate_of(state, world, (20.0, 3.0, 1.0), 2.0)
    without = rate_of(state, BARE._replace(com_y=0.0), (20.0, 3.0, 1.0), 2.0)
    np.testing.assert_allclose(ours[[U, R]], theirs[cart.velocity_slice], atol=2e-4)
    assert np.abs(ours - without)[[U, R]].max() > 0.01


@pytest.mark.parametrize("name", ["force_bias", "force_scale", "force_misalignment"])
def test_a_faulty_sensor_means_what_the_vocabulary_says(name):
    scene = draw_case(name, 0, "straight")
    (truth,) = scene.truths
    effect = known.KNOWN_EFFECTS[name](**truth.parameters)
    present = np.random.default_rng(0).normal(size=(len(scene.drive.time), len(scene.arms), 6))
    seen = noiseless(scene.sensors, scene.drive, present, present)
    arm = scene.arms.index(truth.arm)
    np.testing.assert_allclose(seen[:, arm], effect.recorded(present[:, arm], effect.values), atol=1e-12)
    others = [i for i in range(len(scene.arms)) if i != arm]
    np.testing.assert_array_equal(seen[:, others], present[:, others])


def test_a_late_wrench_is_that_of_a_delay_ago():
    scene = draw_case("time_delay", 0, "straight")
    *_, present, told = scene.run()
    late = noiseless(Sensors(delay=0.03), scene.drive, present, told)
    at = np.interp(scene.drive.time - 0.03, scene.drive.time, present[:, 0, 0])
    assert np.abs(late[10:, 0, 0] - at[10:]).max() < np.abs(np.diff(present[:, 0, 0])).max() + 1e-9
    assert np.abs(late[:, 0, 0] - present[:, 0, 0]).max() > 1.0


def shortened(scene, n):
    names = ("time", "speeds", "contacts", "shares", "extras", "errors")
    return replace(scene, drive=scene.drive._replace(**{name: getattr(scene.drive, name)[:n] for name in names}))


@pytest.mark.parametrize("seed", range(2))
def test_a_cart_without_effects_needs_no_others(seed):
    """All of what the arms give is inertia and viscous drag, by regressors of another file."""
    scene = draw_case("nothing", seed, "rich")
    states, rates, present, told = scene.run()
    found = strength(scene, states, rates, noiseless(scene.sensors, scene.drive, present, told))
    assert found["z"] < 1e-6
    assert np.abs(states[:, W]).max() == 0.0
    assert np.ptp(states[:, U]) > 0.8
    assert np.ptp(states[:, R]) > 0.6


def test_an_effect_shows_as_it_does_to_who_knows_the_whole_covariance_of_the_noise():
    """Generalised least squares with a dense matrix, by regressors of another file."""
    scene, n = shortened(draw_case("rolling_resistance", 0, "rich"), 500), 500
    scene = replace(scene, sensors=replace(scene.sensors, colour=0.08))
    states, rates, present, told = scene.run()
    seen = noiseless(scene.sensors, scene.drive, present, told)
    rows = regressors(states, rates).reshape(2 * n, 6)
    lever = (scene.drive.contacts[..., :2] ** 2).sum(axis=2)
    force, moment = (scene.sensors.force_noise**2, scene.sensors.moment_noise**2)
    variance = np.column_stack(
        [np.full(n, force * lever.shape[1]), force * lever.sum(axis=1) + moment * lever.shape[1]]
    )
    apart = np.abs(np.subtract.outer(scene.drive.time, scene.drive.time)) / 0.08
    covariance = np.zeros((n, 2, n, 2))
    for i in (0, 1):
        covariance[:, i, :, i] = np.exp(-apart) * np.sqrt(np.outer(variance[:, i], variance[:, i]))
    weight = np.linalg.inv(covariance.reshape(2 * n, 2 * n))
    wrench = planar(scene.drive.contacts, seen).ravel()
    left = wrench - rows @ np.linalg.solve(rows.T @ weight @ rows, rows.T @ weight @ wrench)
    assert strength(scene, states, rates, seen)["z"] == pytest.approx(np.sqrt(left @ weight @ left), rel=0.02)


@pytest.mark.parametrize("what", ["pose", "speed"])
def test_rough_sensors_remember_as_long_as_they_say(what):
    """By what is left of noise one lag later, over a log at rest."""
    scene = draw_case("nothing", 0, "rich")
    time = np.arange(0.0, 200.0, 0.01)
    n, k = len(time), 1
    drive = scene.drive._replace(time=time, shares=np.ones((n, k)), contacts=np.zeros((n, k, 3)))
    colours = {"pose_colour": 0.05} if what == "pose" else {"speed_colour": 0.05}
    sensors = Sensors(pose_noise=0.002, speed_noise=0.01, **colours)
    header, table = record(sensors, drive, np.zeros((n, SIZE)), np.zeros((n, k, 6)), np.random.default_rng(0))
    columns = [header.index(name) for name in (("x", "y", "theta") if what == "pose" else ("vx", "vy", "omega"))]
    for column in table[:, columns].T:
        assert column.std() == pytest.approx(0.002 if what == "pose" else 0.01, rel=0.1)
        assert np.corrcoef(column[5:], column[:-5])[0, 1] == pytest.approx(np.exp(-1.0), abs=0.08)


def test_rough_sensors_lose_rows_and_poses():
    scene = rough(draw_case("nothing", 0, "rich"), np.random.default_rng(1))
    scene = replace(scene, sensors=replace(scene.sensors, lost=0.02, off=4, pose_noise=5e-4, pose_colour=0.0))
    states, _, present, told = scene.run()
    seen = noiseless(scene.sensors, scene.drive, present, told)
    _, table = record(scene.sensors, scene.drive, states, seen, np.random.default_rng(0))
    assert len(table) == len(states) - round(0.02 * len(states))
    at = np.searchsorted(scene.drive.time, table[:, 0] - 1e-9)
    far = np.hypot(*(table[:, 1:3] - states[at, X : X + 2]).T)
    assert 1 <= (far > 0.03).sum() <= 4
    assert (np.diff(table[:, 0]) > 0).all()


def test_mujoco_moves_a_cart_alike():
    """Two roads to one motion: bearings and contacts of wheels, and equations in the plane."""
    scene = shortened(draw_case("rolling_resistance", 0, "rich"), 600)
    ours = scene.run()
    theirs = replace(scene, in_mujoco=True).run()
    np.testing.assert_allclose(theirs[0][:, [U, R]], ours[0][:, [U, R]], atol=0.02)
    np.testing.assert_allclose(theirs[2][:, 0, 0], ours[2][:, 0, 0], atol=2.0)
    assert np.ptp(ours[0][:, U]) > 0.3


def test_mujoco_refuses_what_it_does_not_know():
    scene = replace(draw_case("quadratic_drag", 0, "straight"), in_mujoco=True)
    with pytest.raises(ValueError, match="the machine has no quadratic"):
        scene.run()


def test_tyres_without_a_load_hold_nothing():
    """A push high above the axle lifts it: all of the weight is on the casters."""
    world, state, rate = BARE._replace(cornering=2000.0, relaxation=0.1), moving(0.5, 0.2), np.empty(SIZE)
    state[W] = 0.1
    on_its_nose = np.array([0.0, 0.0, 0.0, 0.0, 1.1 * BARE.mass * GRAVITY * BARE.caster_x])
    find_rate(0.0, state, on_its_nose, world, rate)
    assert np.isfinite(rate).all()
