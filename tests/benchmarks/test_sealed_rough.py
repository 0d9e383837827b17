"""The physics of what is rough on purpose, by roads of its own: Newton on points that are differentiated, closed forms,
a convolution, strokes that are counted."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.sealed.body import find_rate
from benchmarks.sealed.cases import draw_case, objection
from benchmarks.sealed.driver import advance
from benchmarks.sealed.roughness import EVERY_ROUGH, PROOF_CASES, ROUGH_CASES, ROUGHNESS, parts
from benchmarks.sealed.sensor_track import TRACK, track_noise
from benchmarks.sealed.sensors import lagged_at, noiseless, record, velocities, wrenches_at
from benchmarks.sealed.world import GRAVITY, LEAN, LEAN_RATE, SIZE, THETA, R, U, W, World, X, Y

BARE = World(24.0, 0.3, 0.04, 2.0, 0.5, 0.27, 0.72, 0.2, 0.045)
RIDER = {"lean_mass": 11.0, "lean_per_force": 8e-4, "lean_frequency": 1.1, "lean_damping": 0.6}
LEANING = BARE._replace(**RIDER)


def at_wrench(fx, fy=0.0, tau=0.0):
    return np.array([fx, fy, tau, 0.0, 0.0])


def rate_of(state, world, wrench):
    rate = np.empty(SIZE)
    find_rate(0.0, state, wrench, world, rate)
    return rate


def recorded(scene, seed=0):
    """Columns by name, and the states."""
    states, _, present, told = scene.run()
    seen = noiseless(scene.sensors, scene.drive, present, told)
    header, table = record(scene.sensors, scene.drive, states, seen, np.random.default_rng(seed))
    return dict(zip(header, table.T, strict=True)), states


# --- a rider that leans ---------------------------------------------------------------------------------------


@given(
    st.tuples(st.floats(-0.8, 0.8), st.floats(-0.6, 0.6)),
    st.tuples(st.floats(-80, 80), st.floats(-20, 20), st.floats(-8, 8)),
    st.tuples(st.floats(-0.1, 0.1), st.floats(-0.5, 0.5)),
)
@settings(max_examples=30)
def test_cart_and_rider_obey_newton_at_each_of_their_places(speed, wrench, lean):
    """Both masses' paths in {s}, differenced twice: their forces make up what the arms give, along the cart and about
    the axle. Differences over 1 ms err by a millionth of the fourth derivatives."""
    state, step = np.zeros(SIZE), 1e-3
    state[[U, R, LEAN, LEAN_RATE]] = *speed, *lean
    push = at_wrench(*wrench)
    path = [state]
    for _ in range(2):
        path.append(advance(0.0, path[-1], step, push, push, 0.0, LEANING)[0])
    places = []
    for s in path:
        cosine, sine = math.cos(s[THETA]), math.sin(s[THETA])
        x = np.array([LEANING.com_x, LEANING.com_x + s[LEAN]])
        y = LEANING.com_y
        places.append(np.column_stack([s[X] + cosine * x - sine * y, s[Y] + sine * x + cosine * y]))
    masses = np.array([LEANING.mass - RIDER["lean_mass"], RIDER["lean_mass"]])
    forces = masses[:, None] * (places[0] - 2 * places[1] + places[2]) / step**2
    middle = path[1]
    ahead = np.array([math.cos(middle[THETA]), math.sin(middle[THETA])])
    levers = places[1] - middle[[X, Y]]
    turning = (path[0][THETA] - 2 * middle[THETA] + path[2][THETA]) / step**2
    moment = (levers[:, 0] * forces[:, 1] - levers[:, 1] * forces[:, 0]).sum() + LEANING.inertia * turning
    assert forces.sum(axis=0) @ ahead == pytest.approx(wrench[0], abs=0.01)
    assert moment == pytest.approx(wrench[2], abs=0.01)


@pytest.mark.parametrize("frequency", [0.1, 0.7, 1.5, 4.0])
def test_force_and_acceleration_disagree_above_the_rider_s_frequency(frequency):
    """M u' = F (1 + m_r w² H), H the rider's lean under a sine of force: by phasors."""
    world, omega = LEANING._replace(com_y=0.0), 2 * math.pi * frequency
    own = 2 * math.pi * RIDER["lean_frequency"]
    lean = RIDER["lean_per_force"] * own**2 / (own**2 - omega**2 + 2j * RIDER["lean_damping"] * own * omega)
    wanted = 1 + RIDER["lean_mass"] * omega**2 * lean
    state, step, n = np.zeros(SIZE), 1e-3, round(1e3 / frequency)
    found, settle = 0j, round(3.0 / step)
    for i in range(settle + n):
        middle = (i + 0.5) * step
        push = at_wrench(30.0 * math.sin(omega * middle))
        if i >= settle:
            now = at_wrench(30.0 * math.sin(omega * i * step))
            found += 2j / n * rate_of(state, world, now)[U] * np.exp(-1j * omega * i * step)
        state, _ = advance(i * step, state, step, push, push, 0.0, world)
    assert found * world.mass / 30.0 == pytest.approx(wanted, abs=0.01)
    if frequency == 0.1:
        assert abs(wanted - 1) < 0.02
    if frequency == 4.0:
        assert abs(wanted) < 0.7


# --- rails ----------------------------------------------------------------------------------------------------


@given(st.floats(-0.8, 0.8), st.floats(-60, 60), st.floats(-40, 40), st.floats(-20, 20), st.floats(-0.05, 0.05))
def test_on_a_rail_only_what_is_along_it_counts(u, force, side, moment, grade):
    world = BARE._replace(rail=1.0, linear=4.0, rolling=0.02, grade_x=grade)
    state = np.zeros(SIZE)
    state[U] = u
    rate = rate_of(state, world, at_wrench(force, side, moment))
    weight = world.mass * GRAVITY
    along = force - 4.0 * u - 0.02 * weight * math.tanh(u / world.width) - weight * math.sin(math.atan(grade))
    assert world.mass * rate[U] == pytest.approx(along, abs=1e-9)
    assert rate[W] == rate[R] == rate[THETA] == 0.0


@pytest.mark.parametrize("seed", range(4))
def test_a_cart_on_a_rail_goes_to_and_fro_over_one_stroke(seed):
    """Not a bit to the side; where it turns, it is at one end or the other, but for what the slope pulls it away: a
    grade of 0.03 over the controller's integral of 3 1/s², 0.1 m, and 0.03 m for the last 0.15 m/s."""
    scene = draw_case("floor_slope@rail", seed, "rich")
    states = scene.run()[0]
    told = scene.roughness[0].parameters
    along = states[:, X] * math.cos(told["heading"]) + states[:, Y] * math.sin(told["heading"])
    across = states[:, Y] * math.cos(told["heading"]) - states[:, X] * math.sin(told["heading"])
    assert np.abs(across).max() < 1e-9
    assert np.ptp(states[:, THETA]) == 0.0
    moves = np.abs(states[:, U]) > 0.15
    turns = np.flatnonzero(np.diff(np.sign(states[moves, U])))
    ends = along[moves][turns]
    assert len(ends) >= 6
    assert np.minimum(abs(ends), abs(ends - told["stroke"])).max() < 0.13
    grade = np.array([scene.world.grade_x, scene.world.grade_y])
    direction = np.array([math.cos(told["heading"]), math.sin(told["heading"])])
    assert abs(grade @ direction) == pytest.approx(np.hypot(*grade))
    assert scene.truths[0].parameters["grade_x"] == grade[0]


# --- coasting -------------------------------------------------------------------------------------------------


def coasting(seed=0, **changes):
    scene = draw_case("nothing@rail@coasting", seed, "rich")
    return replace(scene, world=scene.world._replace(**{"linear": 0.0, **changes}))


def test_a_coasting_cart_slows_by_its_drag_over_its_mass():
    """Viscous: exponentially. Dry: along a parabola, until it stops. On a slope: as a ball in flight."""
    viscous = coasting(linear=6.0)
    time, speed = viscous.drive.time, viscous.begins[1]
    states = viscous.run()[0]
    np.testing.assert_allclose(states[:, U], speed * np.exp(-6.0 / viscous.world.mass * time), atol=1e-9)
    dry = coasting(rolling=0.02)
    along = np.hypot(*dry.run()[0][:, [X, Y]].T)
    assert along[-1] == pytest.approx(speed**2 / (2 * 0.02 * GRAVITY), rel=0.01)
    slope = coasting(grade_x=0.02 * math.cos(viscous.begins[0]))
    slope = replace(slope, world=slope.world._replace(grade_y=0.02 * math.sin(viscous.begins[0])))
    pull = sum(
        GRAVITY * math.sin(math.atan(grade)) * part
        for grade, part in (
            (slope.world.grade_x, math.cos(slope.begins[0])),
            (slope.world.grade_y, math.sin(slope.begins[0])),
        )
    )
    np.testing.assert_allclose(slope.run()[0][:, U], speed - pull * time, atol=1e-9)


def test_a_coasting_log_tells_nothing_but_ratios_to_the_mass():
    """A cart of twice the mass, inertia and drag rolls alike, and there is no column of an arm."""
    scene = draw_case("rolling_resistance+floor_slope@coasting", 1, "rich")
    names = ("mass", "inertia", "linear", "angular")
    world = scene.world._replace(**{name: 2 * getattr(scene.world, name) for name in names})
    np.testing.assert_allclose(replace(scene, world=world).run()[0], scene.run()[0], atol=1e-12)
    columns, states = recorded(scene)
    assert set(columns) <= {"t", "x", "y", "theta", "vx", "vy", "omega"}
    assert abs(states[0, U]) > 0.5


# --- sensors --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("is_held", [True, False])
def test_a_slow_force_sensor_is_a_convolution_with_an_exponential(is_held):
    """By steps of 0.1 ms, whose trapezes err by less than 0.02 N where the wrench jumps by 20 N."""
    scene = draw_case("nothing", 1, "straight")
    drive = scene.drive._replace(held=is_held)
    *_, present, told = replace(scene, drive=drive).run()
    fine, lag = np.arange(0.0, 8.0, 1e-4), 0.05
    wrench = wrenches_at(fine, drive, present, told)[:, 0, 0]
    keep, slow = math.exp(-1e-4 / lag), np.empty(len(fine))
    slow[0] = wrench[0]
    for i in range(1, len(fine)):
        slow[i] = keep * slow[i - 1] + (1 - keep) * (wrench[i - 1] + wrench[i]) / 2
    found = lagged_at(fine, drive, present, told, lag)[:, 0, 0]
    assert np.abs(found - slow).max() < 0.03
    assert np.abs(found - slow).mean() < 0.01
    assert np.abs(found - wrench).max() > 1.0


@pytest.mark.parametrize(("kind", "seed"), [("late_velocities", 0), ("late_velocities", 1), ("large_velocities", 2)])
def test_velocities_are_late_or_too_large_against_poses(kind, seed):
    """By a line from what poses change to velocities and their rates: v(t - d) = v - d v', to second order."""
    scene = draw_case(f"nothing@{kind}", seed, "rich")
    states, time = scene.run()[0], scene.drive.time
    told = velocities(scene.sensors, time, states)[2:-2, :2]
    poses = states[:, [X, Y]]
    rates = np.gradient(poses, time, axis=0)
    bends = np.gradient(rates, time, axis=0)
    design = np.column_stack([rates[2:-2].ravel(), bends[2:-2].ravel()])
    gain, lead = np.linalg.lstsq(design, told.ravel(), rcond=None)[0]
    size = scene.roughness[0].parameters
    assert gain == pytest.approx(size.get("gain", 1.0), abs=0.003)
    assert -lead == pytest.approx(size.get("delay", 0.0), abs=0.002)


@pytest.mark.parametrize("case", ["nothing@quantised_poses", "nothing@rail@quantised_poses"])
def test_encoders_round_and_add_no_other_noise(case):
    """Rounding errs evenly over a step, a twelfth of its square, where the cart moves over many."""
    scene = draw_case(case, 1, "rich")
    columns, states = recorded(scene)
    step = scene.roughness[-1].parameters["step"]
    heading = scene.begins[0]
    moves = np.abs(states[:, U]) > 0.1
    for name, place, share in (("x", X, math.cos(heading)), ("y", Y, math.sin(heading))):
        column = columns[name]
        np.testing.assert_allclose(column / step, np.round(column / step), atol=1e-6)
        error = (column - states[:, place])[moves]
        assert np.abs(error).max() <= step / 2 + 1e-12
        if abs(share) > 0.2 or "rail" not in case:
            assert error.std() == pytest.approx(step / math.sqrt(12), rel=0.1)
    assert "vx" not in columns


def test_strokes_have_a_rhythm_and_give_what_is_asked_on_the_mean():
    scene = draw_case("force_scale@bursts", 3, "rich")
    told = scene.roughness[0].parameters
    left, right = (scene.drive.shares / scene.drive.shares.sum(axis=1, keepdims=True).clip(1e-9)).T
    both = scene.drive.shares.sum(axis=1)
    assert both.mean() == pytest.approx(1.0, rel=0.1)
    assert (both < 1e-9).mean() == pytest.approx(1 - told["pushed"], abs=0.05)
    begins = np.flatnonzero((both[1:] > 1e-9) & (both[:-1] <= 1e-9))
    periods = np.diff(scene.drive.time[begins])
    assert periods.mean() == pytest.approx(1 / told["rhythm"], rel=3 * told["jitter"] / math.sqrt(len(periods)) + 0.02)
    assert periods.std() > 0.02
    assert np.ptp(left[both > 0.1]) > 0.2
    assert np.ptp(right[both > 0.1]) > 0.2


@pytest.mark.skipif(
    not TRACK.is_file(), reason="the shared folder with the sensor's track is not beside the repository"
)
def test_a_track_is_what_a_real_sensor_said():
    """As spread as the file says, without its offset, with neighbours that follow each other."""
    values = np.loadtxt(TRACK, delimiter=",", skiprows=1)[:, 2:]
    time = np.arange(0.0, 54.6, 0.01)
    noise = track_noise(time, 2, np.random.default_rng(0))
    assert noise.shape == (len(time), 2, 6)
    np.testing.assert_allclose(noise.std(axis=0), [values.std(axis=0)] * 2, rtol=0.03)
    assert np.abs(noise.mean(axis=0)).max() < 0.1
    assert np.abs(noise[:, 0] - noise[:, 1]).max() > 1.0
    scene = draw_case("nothing@sensor_track", 0, "straight")
    columns, _ = recorded(scene)
    *_, present, told = scene.run()
    seen = wrenches_at(scene.drive.time, scene.drive, present, told)[:, 0, 0]
    arm = scene.arms[0]
    size = scene.roughness[0].parameters["scale"]
    assert (columns[f"{arm}.fx"] - seen).std() == pytest.approx(size * values[:, 0].std(), rel=0.1)


# --- what goes together ---------------------------------------------------------------------------------------


def test_a_quarter_of_the_kinds_is_frozen_and_all_make_sense():
    assert not [objection(case) for case in EVERY_ROUGH if objection(case)]
    assert not set(ROUGH_CASES) & set(PROOF_CASES)
    assert len(EVERY_ROUGH) == len(set(EVERY_ROUGH))
    assert 0.15 < len(PROOF_CASES) / len(EVERY_ROUGH) < 0.35
    assert {kind for case in ROUGH_CASES for kind in parts(case)[1]} == set(ROUGHNESS)


@pytest.mark.parametrize(
    ("case", "why"),
    [
        ("force_bias@coasting", "force_bias makes no sense beside coasting"),
        ("lateral_slip@rail", "lateral_slip makes no sense beside rail"),
        ("nothing@late_velocities@quantised_poses", "late_velocities makes no sense beside quantised_poses"),
        ("rolling@rail", "'rolling' is none of"),
        ("nothing@rails", "'rails' is none of"),
    ],
)
def test_what_makes_no_sense_is_told(case, why):
    assert why in objection(case)
