"""Laws read off data, against their closed forms in numpy, the energy that they give, and another engine's carts."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from cartgrasp.cart_file import cart_from_text, cart_text
from cartgrasp.constraints import RollingConstraints
from cartgrasp.contacts import ContactWrenches
from cartgrasp.effects import LearnedForce
from cartgrasp.effects.learned_force import (
    INITIAL_REVERSAL_DISTANCE,
    REVERSAL_LENGTH,
    ROUNDING_FRACTION,
    VARIABLE_NAMES,
)
from cartgrasp.errors import FileError, UsageError
from cartgrasp.inertia import Inertia
from cartgrasp.model import CartModel
from cartgrasp.simulation.mujoco_plant import MujocoPlant
from cartgrasp.simulation.plant import ModelPlant
from tests.core.drawn import CONSTRAINTS, SHOPPING_CART, numbers, poses, vectors, velocities

MASS, ABOUT, COM = 24.0, 2.0, (0.3, 0.05)
FREE, RAIL = RollingConstraints(None), CONSTRAINTS["rail"]
NODES, WEIGHTS = np.polynomial.legendre.leggauss(400)
KNOTS, VALUES = (-1.0, 0.2, 1.0), (3.0, -2.0, 6.0)


def cart_with(*laws, constraints=FREE, com=COM):
    return CartModel(Inertia(MASS, com, ABOUT), constraints, laws)


def wrench_of(law, pose=(0.0, 0.0, 0.0), velocity=(0.0, 0.0, 0.0), time=0.0, way=None):
    cart = cart_with(law)
    state = cart.state(pose, velocity)
    if way is not None:
        state[cart.memory_slice] = way
    return cart.effect_wrench(state, time=time)


def rounded(x, knots, values):
    """`np.interp` averaged with 3 (1 - t²) / 4; kinks cost the quadrature 1e-5 of a slope's change."""
    width = ROUNDING_FRACTION * np.diff(knots).min() if len(knots) > 1 else 1.0
    return np.interp(x + width * NODES, knots, values) @ (WEIGHTS * 0.75 * (1 - NODES**2))


# --- what it is a function of --------------------------------------------------------------------------------


@given(time=numbers(-20, 20))
def test_a_sine_in_time(time):
    law = LearnedForce("forward_force", "time", period=1.7, harmonics=(1, 4), amplitudes=(3.0, -2.0, 0.5, 1.0))
    phase = 2 * np.pi * time / 1.7
    force = 3 * np.cos(phase) - 2 * np.sin(phase) + 0.5 * np.cos(4 * phase) + np.sin(4 * phase)
    np.testing.assert_allclose(wrench_of(law, time=time), [force, 0, 0], atol=1e-11)


@given(way=numbers(-5, 5), lever=numbers(-0.5, 0.5))
def test_a_flat_spot_pushes_where_its_wheel_is(way, lever):
    law = LearnedForce("forward_force", "travelled_distance", lever=lever, period=0.525, amplitudes=(4.0, 1.0))
    force = 4 * np.cos(2 * np.pi * way / 0.525) + np.sin(2 * np.pi * way / 0.525)
    np.testing.assert_allclose(wrench_of(law, way=way), [force, 0, -lever * force], atol=1e-12)


@given(heading=numbers(-10, 10))
def test_a_law_of_the_heading_repeats_every_turn(heading):
    law = LearnedForce("yaw_moment", "heading", harmonics=(2,), amplitudes=(1.0, 2.0))
    moment = np.cos(2 * heading) + 2 * np.sin(2 * heading)
    np.testing.assert_allclose(wrench_of(law, (0, 0, heading)), [0, 0, moment], atol=1e-12)
    turned = wrench_of(law, (0, 0, heading + 2 * np.pi))
    np.testing.assert_allclose(turned, [0, 0, moment], atol=1e-12)


@given(pose=poses(), velocity=velocities(), time=numbers(-2, 2), way=numbers(-2, 2))
def test_every_variable_is_interpolated(pose, velocity, time, way):
    """A way before a reversal is short of it by h² / 2 |q|, and at 0 by h / 2, h being `REVERSAL_LENGTH`."""
    u, _, r = velocity
    seen = {"time": time, "travelled_distance": way, "heading": None, "speed": u - 0.2 * r, "yaw_rate": r}
    seen |= {
        "place": pose[0] * np.cos(0.7) + pose[1] * np.sin(0.7),
        "since_reversal": way**2 / np.hypot(way, REVERSAL_LENGTH),
    }
    assert tuple(seen) == VARIABLE_NAMES
    for of, value in seen.items():
        if of == "heading":
            continue
        form = {"direction": 0.7} if of == "place" else {}
        law = LearnedForce("forward_force", of, lever=0.2, knots=KNOTS, amplitudes=VALUES, **form)
        force = rounded(value, KNOTS, VALUES)
        remembered = way if law.memory_names(None) else None
        found = wrench_of(law, pose, velocity, time, remembered)
        np.testing.assert_allclose(found, [force, 0, -0.2 * force], atol=1e-3, err_msg=of)


@given(x=numbers(-3, 4), values=vectors(4, -10, 10))
def test_the_interpolation_stays_between_its_values_and_keeps_straight_lines(x, values):
    knots = (-1.0, 0.0, 1.5, 2.0)
    law = LearnedForce("forward_force", "time", knots=knots, amplitudes=tuple(values))
    assert values.min() - 1e-9 <= wrench_of(law, time=x)[0] <= values.max() + 1e-9
    line = replace(law, amplitudes=tuple(2 * np.array(knots) - 1))
    if -1.0 + 0.5 * ROUNDING_FRACTION < x < 2.0 - 0.5 * ROUNDING_FRACTION:
        assert wrench_of(line, time=x)[0] == pytest.approx(2 * x - 1)
    for knot, value in zip(knots, values, strict=True):
        spared = 3 / 16 * ROUNDING_FRACTION * 0.5 * np.abs(np.diff(values) / np.diff(knots)).max() * 2
        assert abs(wrench_of(law, time=knot)[0] - value) <= spared + 1e-12


@given(pose=poses(), values=vectors(6, -5, 5))
def test_a_field_over_places(pose, values):
    """Rounded along y within, along x of what that gives: two one-dimensional quadratures."""
    x_knots, y_knots, table = (-1.0, 0.0, 2.0), (-0.5, 1.0), values.reshape(3, 2)
    law = LearnedForce("lateral_force", "place", knots=x_knots, knots_y=y_knots, amplitudes=tuple(values))
    rows = [rounded(pose[1], y_knots, row) for row in table]
    np.testing.assert_allclose(wrench_of(law, pose)[1], rounded(pose[0], x_knots, rows), atol=2e-3)
    assert [p.name for p in law.parameters][:3] == ["value_1_1", "value_1_2", "value_2_1"]


@given(heading=numbers(-4, 4), direction=numbers(-4, 4))
def test_wind_blows_one_way_in_the_world(heading, direction):
    law = LearnedForce("world_force", "time", direction=direction, amplitudes=(5.0,))
    fx, fy, moment = wrench_of(law, (0.3, 0.2, heading))
    c, s = np.cos(heading), np.sin(heading)
    blown = 5 * np.array([np.cos(direction), np.sin(direction)])
    np.testing.assert_allclose([c * fx - s * fy, s * fx + c * fy], blown, atol=1e-12)
    assert moment == 0


@given(heading=numbers(-4, 4), direction=numbers(-4, 4))
def test_a_force_of_the_world_may_act_ahead(heading, direction):
    law = LearnedForce("world_force", "time", direction=direction, ahead=0.4, amplitudes=(5.0,))
    fx, fy, moment = wrench_of(law, (0.3, 0.2, heading))
    np.testing.assert_allclose([fx, fy], 5 * np.array([np.cos(direction - heading), np.sin(direction - heading)]))
    assert moment == pytest.approx(0.4 * fy)
    sideways = LearnedForce("lateral_force", "time", ahead=0.4, amplitudes=(5.0,))
    np.testing.assert_allclose(wrench_of(sideways), [0, 5, 2])


@given(way=numbers(-5, 5))
def test_a_moment_may_follow_a_wheel_about_a_mean(way):
    law = LearnedForce(
        "yaw_moment", "travelled_distance", lever=0.3, period=0.5, harmonics=(0, 1), amplitudes=(2, 0, 1, 3)
    )
    phase = 2 * np.pi * way / 0.5
    np.testing.assert_allclose(wrench_of(law, way=way), [0, 0, 2 + np.cos(phase) + 3 * np.sin(phase)], atol=1e-11)
    cart = cart_with(law, constraints=RollingConstraints(0.0))
    rates = cart.state_rate(cart.state((0, 0, 0), (0.7, 0.4)), np.zeros(3))
    assert rates[cart.memory_slice] == pytest.approx([0.7 - 0.3 * 0.4])


@given(velocity=velocities())
def test_drag_is_against_the_motion_of_its_point(velocity):
    law = LearnedForce("drag", "speed", lever=0.3, knots=(0.0, 0.5, 1.5), amplitudes=(1.0, 2.0, 6.0))
    speed = velocity[0] - 0.3 * velocity[2]
    fx, fy, moment = wrench_of(law, velocity=velocity)
    assert fy == 0
    assert moment == pytest.approx(-0.3 * fx)
    assert fx * speed <= 0
    if abs(speed) > 0.05:  # the smooth sign and the smooth absolute value are low by (0.002 / speed)² / 2
        expected = -np.sign(speed) * rounded(abs(speed), (0.0, 0.5, 1.5), (1.0, 2.0, 6.0))
        assert fx == pytest.approx(expected, rel=3e-3)


@given(velocity=velocities(), way=numbers(-5, 5))
def test_a_viscous_drag_is_in_proportion_to_the_speed_of_its_point(velocity, way):
    law = LearnedForce("viscous_drag", "travelled_distance", lever=0.3, knots=(-1.0, 1.0), amplitudes=(1.0, 3.0))
    speed = velocity[0] - 0.3 * velocity[2]
    force = -speed * rounded(way, (-1.0, 1.0), (1.0, 3.0))
    np.testing.assert_allclose(wrench_of(law, velocity=velocity, way=way), [force, 0, -0.3 * force], atol=1e-3)


LAWS = [
    LearnedForce("forward_force", "time", period=1.7, harmonics=(1, 4)),
    LearnedForce("yaw_moment", "heading", harmonics=(2,)),
    LearnedForce("forward_force", "time", knots=(-1.0, 0.0, 1.5, 2.0)),
    LearnedForce("lateral_force", "time", knots=(0.5,)),
    LearnedForce("forward_force", "time"),
    LearnedForce("lateral_force", "place", knots=(-1.0, 0.0, 2.0), knots_y=(-0.5, 1.0)),
]


@pytest.mark.parametrize("law", LAWS, ids=lambda law: f"{law.acts_on}, {len(law.parameters)}")
@given(x=numbers(-3, 4), y=numbers(-2, 2))
def test_shares_are_what_amplitudes_count_for_in_the_wrench(law, x, y):
    """Worked out in numpy, against the kernel."""
    at = [[x, y]] if law.knots_y else [x]
    pose = (x, y, x) if law.of == "heading" else (x, y, 0.0)
    component = {"forward_force": 0, "lateral_force": 1, "yaw_moment": 2}[law.acts_on]
    count = len(law.parameters)
    found = [wrench_of(law.with_values(one), pose, time=x)[component] for one in np.eye(count)]
    np.testing.assert_allclose(law.shares(at), [found], atol=1e-11)


# --- since the last reversal ---------------------------------------------------------------------------------


def told_ways(speeds, step=0.002):
    """|q| (n,) along speeds (n,), as the memory has it, and the way rolled since the direction was another."""
    cart = cart_with(LearnedForce("drag", "since_reversal", knots=(0.1, 1.0)), constraints=RAIL)
    n = len(speeds)
    told = cart.memory_along(np.zeros((n, 3)), speeds[:, None], step * np.arange(n))[:, 0]
    ways, way, last = np.zeros(n), INITIAL_REVERSAL_DISTANCE, np.sign(speeds[0])
    for i in range(1, n):
        rolled = step * (speeds[i] + speeds[i - 1]) / 2
        way = abs(rolled) if rolled * last < 0 else way + abs(rolled)
        last = np.sign(rolled) or last
        ways[i] = way
    ways[0] = INITIAL_REVERSAL_DISTANCE
    return np.abs(told), ways


@pytest.mark.parametrize("lever", [0.27, -0.27])
def test_a_turn_on_the_spot_begins_without_a_reversal(lever):
    """Of the wheel at the lever, whichever way it rolls."""
    cart = cart_with(LearnedForce("drag", "since_reversal", lever=lever, knots=(0.1, 1.0)))
    n = 200
    told = cart.memory_along(np.zeros((n, 3)), np.tile([0.0, 0.0, 1.0], (n, 1)), 0.01 * np.arange(n))[:, 0]
    np.testing.assert_allclose(np.abs(told), INITIAL_REVERSAL_DISTANCE + 0.27 * 0.01 * np.arange(n), atol=1e-9)


@pytest.mark.parametrize("pace", [0.2, 1.0, 2.5])
def test_a_reversal_is_told_within_some_centimetres_at_any_speed(pace):
    """After h log(1 + D / h) at D, h being `REVERSAL_LENGTH`; from there on the way is short by that, and by
    what rounding costs."""
    speeds = pace * np.sin(2 * np.pi * np.arange(round(3000 / pace)) * 0.002 * pace / 4.0 + 0.3)
    told, ways = told_ways(speeds)
    late = REVERSAL_LENGTH * np.log(1 + (INITIAL_REVERSAL_DISTANCE + 1.5) / REVERSAL_LENGTH) + REVERSAL_LENGTH
    since = ways > late
    assert (np.diff(np.sign(speeds)) != 0).sum() == 3
    assert np.all(told[since] <= ways[since] + 0.5 * REVERSAL_LENGTH)
    assert np.all(told[since] >= ways[since] - late)
    assert told[np.argmax((ways > late / 2) & (ways < late) & (np.arange(len(ways)) > 100))] < INITIAL_REVERSAL_DISTANCE


def test_a_stop_on_the_way_counts_for_nothing():
    speeds = np.concatenate([np.full(500, -0.4), np.full(500, 0.5), np.zeros(1000), np.full(500, 0.5)])
    told, ways = told_ways(speeds)
    assert np.ptp(told[1010:1990]) < 1e-9
    assert told[-1] - told[1000] == pytest.approx(0.5, abs=0.01)
    assert ways[-1] - told[-1] < 0.06


# --- what it gives to a cart ---------------------------------------------------------------------------------


def kinetic_energy(cart, state):
    u, w, r = cart.basis_b @ state[cart.velocity_slice]
    x, y = cart.inertia.com
    return MASS / 2 * ((u - y * r) ** 2 + (w + x * r) ** 2) + ABOUT / 2 * r**2


def coasting(cart, velocity, duration, step=0.01, pose=(0.0, 0.0, 0.0)):
    """States (n, s) of the plant, nobody pushing."""
    plant, found = ModelPlant(cart, pose, velocity, timestep=0.002), []
    idle = ContactWrenches({}, {})
    for _ in range(round(duration / step)):
        found.append(plant.state)
        plant.step(idle, step)
    return np.array([*found, plant.state])


def test_the_work_of_a_flat_spot_is_the_integral_over_the_way_of_its_wheel():
    """On a cart with an axle, that turns: the way of the wheel from its own positions in the plant."""
    law = LearnedForce("forward_force", "travelled_distance", lever=0.27, period=0.525, amplitudes=(6.0, 3.0))
    cart = cart_with(law, constraints=RollingConstraints(0.0))
    states = coasting(cart, (0.7, 0.4), 3.0)
    energy = np.array([kinetic_energy(cart, s) for s in states])
    x, y, heading = states[:, :3].T
    wheel = np.column_stack([x - 0.27 * np.sin(heading), y + 0.27 * np.cos(heading)])
    half = (heading[1:] + heading[:-1]) / 2
    along = np.column_stack([np.cos(half), np.sin(half)])
    way = np.append(0.0, np.cumsum((np.diff(wheel, axis=0) * along).sum(axis=1)))
    pace = 2 * np.pi / 0.525
    work = 6 / pace * np.sin(pace * way) + 3 / pace * (1 - np.cos(pace * way))
    np.testing.assert_allclose(energy - energy[0], work, atol=2e-4)
    assert np.ptp(work) > 0.5  # J
    assert way[-1] > 1.0


def test_wind_gives_force_times_the_way_along_it():
    law = LearnedForce("world_force", "time", direction=0.8, amplitudes=(3.0,))
    cart = cart_with(law, constraints=RollingConstraints(0.0))
    states = coasting(cart, (0.5, 0.6), 3.0)
    energy = np.array([kinetic_energy(cart, s) for s in states])
    way = (states[:, :2] - states[0, :2]) @ [np.cos(0.8), np.sin(0.8)]
    np.testing.assert_allclose(energy - energy[0], 3.0 * way, atol=1e-6)


def test_a_sine_in_time_on_a_rail():
    law = LearnedForce("forward_force", "time", period=0.8, amplitudes=(0.0, 12.0))
    states = coasting(cart_with(law, constraints=RAIL), (0.3,), 2.0)
    time, pace = 0.01 * np.arange(len(states)), 2 * np.pi / 0.8
    np.testing.assert_allclose(states[:, 3], 0.3 + 12 / MASS / pace * (1 - np.cos(pace * time)), atol=1e-7)


def test_drag_on_a_patch_brakes_to_rest_and_no_further():
    law = LearnedForce("drag", "place", knots=(0.4, 0.5), amplitudes=(0.0, 20.0))
    states = coasting(cart_with(law, constraints=RAIL), (0.6,), 4.0)
    assert (states[:, 3] > -1e-6).all()
    assert abs(states[-1, 3]) < 1e-3
    stopped = 0.45 + MASS * 0.6**2 / 2 / 20  # the ramp brakes as its half does
    assert states[-1, 0] == pytest.approx(stopped, abs=2e-3)


@pytest.mark.parametrize(
    "law",
    [
        LearnedForce("world_force", "time", direction=0.4, period=1.5, amplitudes=(8.0, 6.0)),
        LearnedForce("forward_force", "travelled_distance", lever=0.27, period=0.525, amplitudes=(16.0, 8.0)),
        LearnedForce(
            "drag", "place", knots=(0.3, 0.5, 0.8), knots_y=(-1.0, 1.0), amplitudes=(0.0, 0.0, 4.0, 9.0, 1.0, 2.0)
        ),
    ],
    ids=lambda law: f"{law.acts_on} of {law.of}",
)
def test_mujocos_cart_moves_as_ours(law):
    """Its spinning wheels are 0.1 % more mass, and its axle creeps by 1 ms times u r."""
    cart = CartModel(Inertia(MASS, (0.3, 0.0), ABOUT), RollingConstraints(0.0), (law,), SHOPPING_CART, com_height=0.45)
    plants = ModelPlant(cart, velocity=(0.5, 0.3)), MujocoPlant(cart, velocity=(0.5, 0.3))
    idle = ContactWrenches({}, {})
    for _ in range(200):
        for plant in plants:
            plant.step(idle, 0.01)
    (ours, theirs), bare = (plant.motion for plant in plants), coasting(replace(cart, effects=()), (0.5, 0.3), 2.0)[-1]
    np.testing.assert_allclose(theirs.pose_sb, ours.pose_sb, atol=0.006)
    np.testing.assert_allclose(theirs.velocity, ours.velocity, atol=0.006)
    assert np.abs(ours.pose_sb - bare[:3]).max() > 0.05


def test_a_plant_follows_a_stiff_law():
    """A drag that comes within 2 mm, through which steps of 5 ms would fall."""
    law = LearnedForce("drag", "place", knots=(0.5, 0.502), amplitudes=(0.0, 200.0))
    states = coasting(cart_with(law, constraints=RAIL), (1.0,), 1.0)
    run = solve_ivp(
        lambda _, s: [s[1], -200.0 / MASS * np.tanh(s[1] / 0.002) * rounded(s[0], (0.5, 0.502), (0.0, 1.0))],
        (0, 1),
        [0.0, 1.0],
        max_step=0.002,
    )
    assert states[-1, 0] == pytest.approx(run.y[0, -1], abs=2e-3)


# --- where it stands -----------------------------------------------------------------------------------------

CART = """\
mass: 24.0
com: [0.3, 0.05]
inertia: 2.0
effects:
  learned_force:  # no name fits
    spot: {acts_on: forward_force, of: travelled_distance, lever: 0.27, period: 0.525, cos_1: 3.0, sin_1: -1.0}
    wind: {acts_on: world_force, of: time, direction: 1.57, knots: [0.0, 30.0], value_1: 2.0, value_2: 4.0}  # gusts
std: {learned_force.wind.value_2: 0.5}
known: [learned_force.spot]
"""


def test_laws_stand_in_the_cart_file_in_plain_numbers():
    cart = cart_from_text(CART)
    spot, wind = cart.effects
    assert spot == LearnedForce(
        "forward_force", "travelled_distance", lever=0.27, period=0.525, amplitudes=(3, -1), label="spot"
    )
    assert wind == LearnedForce("world_force", "time", direction=1.57, knots=(0, 30), amplitudes=(2, 4), label="wind")
    assert cart.parameter_names[4:] == (*spot.keys, *wind.keys)
    assert spot.keys == ("learned_force.spot.cos_1", "learned_force.spot.sin_1")
    moved = cart.with_parameters([*cart.parameters[:-1], 7.0])
    assert CART.replace("value_2: 4.0", "value_2: 7.0").partition("effects:")[2] in cart_text(moved)
    assert cart_from_text(cart_text(moved)).effects == moved.effects


def test_a_new_law_is_written_with_its_form_and_nothing_that_is_usual():
    law = LearnedForce("yaw_moment", "place", knots=(0, 1), knots_y=(0, 2), amplitudes=(1, 2, 3, 4), label="field")
    text = cart_text(cart_with(law))
    assert "knots: [0.0, 1.0]" in text
    assert "value_2_1: 3.0" in text
    assert "lever" not in text
    assert cart_from_text(text).effects == (law,)


HEAD = "mass: 24\ncom: [0.3, 0.05]\ninertia: 2.0\neffects:\n  learned_force:\n    "
REFUSED = {
    "acts_on: drag": "5:3: effects.learned_force.of: is missing; add one of time",
    "of: time": "5:3: effects.learned_force.acts_on: is missing; add one of forward_force",
    "acts_on: drug\n    of: time": "6:5: effects.learned_force.acts_on: 'drug' is none of forward_force",
    "acts_on: drag\n    of: pushed_force": "7:5: effects.learned_force.of: a law of what the arms give",
    "acts_on: drag\n    of: [time]": r"7:5: effects.learned_force.of: \['time'\] is none of",
    "acts_on: drag\n    of: time\n    knots: [1, 0]": r"8:5: .*knots: \[1.0, 0.0\] does not increase",
    "acts_on: drag\n    of: time\n    knots: [1, b]": "8:16: effects.learned_force.knots.1: 'b' is not a number",
    "acts_on: drag\n    of: time\n    knots: 3": "8:5: effects.learned_force.knots: 3 is not a list of numbers",
    "acts_on: drag\n    of: time\n    period: .nan": "8:5: effects.learned_force.period: nan is not a finite number",
    "acts_on: drag\n    of: time\n    period: -1": "8:5: effects.learned_force.period: -1 is below 1e-06",
    "acts_on: drag\n    of: time\n    period: 2\n    cos_2: 1": "9:5: .*cos_2: unknown parameter; did you mean cos_1",
    "acts_on: drag\n    of: time\n    period: 2\n    knots: [1, 2]": "9:5: .*knots: what repeats has harmonics",
    "acts_on: drag\n    of: heading\n    period: 2": "8:5: .*period: a heading repeats every turn",
    "acts_on: drag\n    of: time\n    harmonics: [1, 2]": "8:5: .*harmonics: only what repeats has some",
    "acts_on: drag\n    of: heading\n    harmonics: [1.5]": "8:5: .*harmonics: some whole numbers from 0",
    "acts_on: drag\n    of: heading\n    harmonics: []": "8:5: .*harmonics: some whole numbers from 0",
    "acts_on: yaw_moment\n    of: time\n    lever: 1": "8:5: .*lever: only one of .*, viscous_drag has one",
    "acts_on: drag\n    of: time\n    direction: 1": "8:5: .*direction: only a world_force or a way along it",
    "acts_on: drag\n    of: time\n    knots_y: [1, 2]": "8:5: .*knots_y: only a place with knots along x",
    "acts_on: drag\n    of: place\n    knots: [1, 2]\n    knots_y: [1]": "9:5: .*knots_y: two are needed",
    "acts_on: drag\n    of: time\n    knots: [0, 1e-9]": "8:5: .*knots: two stand closer than 1e-06",
    "acts_on: drag\n    of: time\n    value_1: many": "8:5: .*value_1: 'many' is not a number",
}


@pytest.mark.parametrize("entry", REFUSED)
def test_mistakes_are_refused_with_their_place(entry):
    with pytest.raises(FileError, match=f"^cart.yaml:{REFUSED[entry]}"):
        cart_from_text(HEAD + entry + "\n")


def test_a_law_may_not_have_hundreds_of_amplitudes():
    with pytest.raises(UsageError, match=r"^learned_force\.knots: more than 400 amplitudes"):
        LearnedForce("drag", "place", knots=range(21), knots_y=range(20))


def test_a_law_whose_label_is_heading_has_no_caster():
    law = LearnedForce("forward_force", "travelled_distance", period=1.0, label="heading")
    assert ModelPlant(cart_with(law)).caster_headings is None


def test_python_is_told_the_same():
    for form, why in (
        ({"of": "place", "acts_on": "up"}, "learned_force.acts_on: 'up' is none of"),
        ({"knots": (0.0, np.inf)}, "learned_force.knots: .* is not finite"),
        ({"amplitudes": (1.0, 2.0)}, "learned_force.amplitudes: 2 numbers, but the law has 1"),
        ({"amplitudes": (np.nan,)}, "learned_force.value_1: nan is not a finite number"),
    ):
        with pytest.raises(UsageError, match=f"^{why}"):
            LearnedForce(**form)
    assert LearnedForce(knots=np.array([0, 1]), amplitudes=[1, 2]) == LearnedForce(knots=(0, 1), amplitudes=(1, 2))


@given(label=st.sampled_from(["", "left"]))
def test_units_are_those_of_what_it_acts_on(label):
    for acts_on, unit in (("drag", "N"), ("yaw_moment", "N·m"), ("world_force", "N")):
        law = LearnedForce(acts_on, "time", period=1.0, label=label)
        assert [(p.name, p.unit, p.estimated) for p in law.parameters] == [("cos_1", unit, True), ("sin_1", unit, True)]
        assert np.isinf([law.parameters[0].lower, law.parameters[0].upper]).all()
