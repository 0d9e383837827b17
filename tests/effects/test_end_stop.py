"""End stops: what an impact and a spring must do, from momentum, energy and closed forms; and in simulation."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from cartgrasp.bounce import bounced, walls_of
from cartgrasp.cart_file import cart_from_text, cart_text
from cartgrasp.constraints import RollingConstraints
from cartgrasp.contacts import ContactWrenches
from cartgrasp.effects import EndStop, FloorSlope, LoadSlosh, RollingResistance
from cartgrasp.frames import body_to_world
from cartgrasp.inertia import Inertia
from cartgrasp.model import CartModel
from cartgrasp.simulation.integrate import held
from cartgrasp.simulation.plant import ModelPlant
from tests.core.drawn import numbers, vectors

MASS, COM, ABOUT_COM = 20.0, (0.3, 0.1), 2.0
RAIL = RollingConstraints(0.0, no_rotation=True)
NOBODY = ContactWrenches({}, {})
ROLLING = st.sampled_from([RollingConstraints(None), RollingConstraints(0.0), RollingConstraints(0.2), RAIL])
SIDES = pytest.mark.parametrize("side", [1.0, -1.0])


def rail_cart(*effects, mass=MASS):
    return CartModel(Inertia(mass, (0.0, 0.0), ABOUT_COM), RAIL, effects)


def rolled(cart, x, speed, duration, step=0.002):
    """Times, positions and speeds (n,) of a cart on a rail that nobody touches."""
    plant, rows = ModelPlant(cart, (x, 0.0, 0.0), [speed], timestep=step), []
    for _ in range(round(duration / step)):
        plant.step(NOBODY, step)
        rows.append((plant.time, plant.motion.pose_sb[0], plant.motion.velocity[0]))
    return np.array(rows).T


def kinetic(cart, state):
    """½ m v² of the CoM and ½ I r², by hand."""
    u, w, r = cart.basis_b @ state[cart.velocity_slice]
    body, (x, y) = cart.inertia, cart.inertia.com
    return body.mass * ((u - r * y) ** 2 + (w + r * x) ** 2) / 2 + body.about_com * r**2 / 2


def hit(cart, pose, velocity, step=0.01, share=0.5):
    """States before and after a step in which a cart goes on as it was, through a wall at the middle of its way."""
    middle = cart.state(pose, velocity)
    way = np.zeros(len(middle))
    way[:3] = body_to_world(pose[2]) @ cart.constraints.basis_b @ velocity
    before, after = middle - step * share * way, middle + step * (1 - share) * way
    before[2] = after[2] = pose[2]  # the heading in which it is
    return before, after


# --- the impact ----------------------------------------------------------------------------------------------


@given(
    rolling=ROLLING,
    pose=vectors(3, -3, 3),
    twist=vectors(3, -2, 2),
    restitution=numbers(0, 1),
    side=st.sampled_from([1.0, -1.0]),
)
def test_an_impact_keeps_momentum_across_and_gives_back_its_share(rolling, pose, twist, restitution, side):
    """Of the whole body: the impulse of the wall is along x at {b}'s origin; wheels add one along their constraint,
    which does no work. Energy falls by ½ (1 - e²) v² times the mass that the wall feels."""
    stop = EndStop(pose[0], side, restitution)
    cart = CartModel(Inertia(MASS, COM, ABOUT_COM), rolling, (stop,))
    velocity = rolling.free_velocity(twist)
    basis_s = body_to_world(pose[2]) @ rolling.basis_b
    approach = side * (basis_s @ velocity)[0]
    assume(approach > 1e-3 and abs(basis_s[0]).max() > 0.1)
    before, after = hit(cart, pose, velocity)
    found = bounced(cart, before, after, 0.0, 0.01)
    rows = cart.velocity_slice
    leaving = side * (basis_s @ found[rows])[0]
    assert leaving == pytest.approx(-restitution * approach, abs=1e-12)

    (x, y), (c, s) = COM, (math.cos(pose[2]), math.sin(pose[2]))
    du, dw, dr = rolling.basis_b @ (found[rows] - before[rows])
    push = MASS * np.array([du - dr * y, dw + dr * x])  # what the CoM's momentum gained, in {b}
    moment = ABOUT_COM * dr + x * push[1] - y * push[0]  # about {b}'s origin, where the wall's impulse has no lever
    if not rolling.n_rows:
        assert moment == pytest.approx(0.0, abs=1e-10)
        assert s * push[0] + c * push[1] == pytest.approx(0.0, abs=1e-10)
    elif not rolling.no_rotation:  # the axle's impulse, across the cart at x = a, takes the rest
        axle = moment / rolling.axle_x if rolling.axle_x else push[1] + s / c * push[0] if abs(c) > 1e-3 else None
        if axle is not None:
            assert s * push[0] + c * (push[1] - axle) == pytest.approx(0.0, abs=1e-7)
        if rolling.axle_x == 0.0:
            assert moment == pytest.approx(0.0, abs=1e-10)
    felt = abs((rolling.basis_b.T @ np.append(push, moment)) @ velocity / approach)  # (1 + e) of it
    lost = kinetic(cart, before) - kinetic(cart, found)
    assert lost == pytest.approx(felt * (1 - restitution) * approach / 2, abs=1e-9)
    still = side * (found[0] - pose[0])
    assert still <= 1e-12  # on the side it came from


@pytest.mark.parametrize("rolling", [RollingConstraints(None), RollingConstraints(0.5)])
@pytest.mark.parametrize("swinging", [8.0, 11.6, 14.0])
def test_whatever_swings_a_cart_bounces(rolling, swinging):
    """What swings beyond all that a free cart lets is as little to be felt at once as in its motion."""
    effects = EndStop(1.0, restitution=0.5), LoadSlosh(swinging, 1.0, 0.1)
    cart = CartModel(Inertia(24.0, (0.3, 0.3), ABOUT_COM), rolling, effects)
    before, after = hit(cart, (1.0, 0.0, 0.9), rolling.free_velocity([1.0, 0.0, 0.0]))
    found, rows = bounced(cart, before, after, 0.0, 0.01), cart.velocity_slice
    wall = body_to_world(0.9)[0]
    impulse = cart.rate(before, -wall).value[rows] - cart.rate(before, 0 * wall).value[rows]
    change, speed = found[rows] - before[rows], wall @ rolling.basis_b @ before[rows]
    assert wall @ rolling.basis_b @ found[rows] == pytest.approx(-0.5 * speed, abs=1e-9)
    np.testing.assert_allclose(change / np.linalg.norm(change), impulse / np.linalg.norm(impulse), atol=1e-9)


@given(speed=numbers(0.05, 3.0), restitution=numbers(0, 1), mass=numbers(0.5, 300.0))
def test_on_a_rail_the_share_of_energy_that_is_left_is_e_squared(speed, restitution, mass):
    cart = rail_cart(EndStop(1.0, restitution=restitution), mass=mass)
    _, x, v = rolled(cart, 1.0 - 0.1 * speed, speed, 0.2)
    assert v[-1] ** 2 == pytest.approx(restitution**2 * speed**2, abs=1e-12)
    assert x.max() <= 1.0 + 1e-12
    assert x[-1] == pytest.approx(1.0 - 0.1 * restitution * speed, abs=1e-9)


@SIDES
@pytest.mark.parametrize("heading", [0.0, math.pi])
def test_either_side_and_either_end_of_the_cart_may_be_the_one(side, heading):
    cart = rail_cart(EndStop(0.4, side, 0.5))
    forward = side * math.cos(heading)
    state = cart.state((0.4 - side * 0.1, 0.0, heading), [forward])
    state = held(cart, state, np.zeros(3), 0.0, (0.001, 200))
    assert state[0] == pytest.approx(0.4 - side * 0.05)
    assert state[3] == pytest.approx(-0.5 * forward)


def test_flights_on_a_slope_shrink_by_the_restitution_until_it_stays():
    """Each flight lasts 2 v / a, so e times as long as the one before; all of them 2 v / a / (1 - e)."""
    e, pull = 0.7, 0.03 * 9.80665
    cart = rail_cart(EndStop(1.0, restitution=e), FloorSlope(-0.03))
    drop, first = 0.4, math.sqrt(2 * 0.4 / pull)
    last = first + 2 * e * first / (1 - e)
    time, x, v = rolled(cart, 1.0 - drop, 0.0, last + 1.0)
    assert x.max() <= 1.0 + 1e-9
    turns = time[1:][(v[1:] < -1e-3) & (v[:-1] > 0)]
    expected = first + 2 * first * e * (1 - e ** np.arange(8)) / (1 - e)
    assert turns[:8] == pytest.approx(expected, abs=0.004)
    heights = [1.0 - x[(time > a) & (time < b)].min() for a, b in pairwise(expected[:6])]
    assert heights == pytest.approx(drop * e ** (2 * np.arange(1, 6)), rel=0.01)
    stays = time > last + 0.1
    assert x[stays] == pytest.approx(1.0, abs=1e-9)
    assert v[stays] == pytest.approx(0.0, abs=1e-9)


def test_what_is_pressed_against_a_dead_stop_stays_and_comes_away():
    cart = rail_cart(EndStop(1.0, restitution=0.0), RollingResistance(0.01))
    state = cart.state((0.99, 0.0, 0.0), [0.5])
    pressed = held(cart, state, np.array([50.0, 0.0, 0.0]), 0.0, (0.005, 200))
    assert pressed[[0, 3]] == pytest.approx([1.0, 0.0], abs=1e-12)
    away = held(cart, pressed, np.array([-50.0, 0.0, 0.0]), 1.0, (0.005, 100))
    pull = 50.0 / MASS - 0.01 * 9.80665
    assert away[3] == pytest.approx(-pull * 0.5, rel=1e-3)


@SIDES
def test_beyond_a_wall_it_gets_no_further_and_may_come_back(side):
    cart = rail_cart(EndStop(0.0, side, 0.5))
    for speed, expected in ((1.0, -0.5), (-1.0, -1.0)):
        state = held(cart, cart.state((side * 0.3, 0, 0), [side * speed]), np.zeros(3), 0.0, (0.01, 10))
        assert state[3] == pytest.approx(side * expected)
        assert side * state[0] < 0.3


def test_between_two_walls():
    cart = rail_cart(EndStop(0.0, -1.0, 1.0, label="low"), EndStop(1.0, 1.0, 1.0, label="high"))
    _, x, v = rolled(cart, 0.5, 1.0, 4.0)
    assert (x.min(), x.max()) == (pytest.approx(0.0, abs=0.003), pytest.approx(1.0, abs=0.003))
    assert x[-1] == pytest.approx(0.5, abs=1e-9)  # two rounds of 2 m
    assert (np.diff(np.sign(v)) != 0).sum() == 4


def test_rolling_along_a_wall_is_no_touch():
    cart = CartModel(Inertia(MASS, COM, ABOUT_COM), RollingConstraints(0.0), (EndStop(0.0, restitution=1.0),))
    state = cart.state((0.0, 0.0, math.pi / 2), [1.0, 0.0])
    assert held(cart, state, np.zeros(3), 0.0, (0.01, 100)) == pytest.approx([0, 1, math.pi / 2, 1, 0], abs=1e-9)


@given(
    states=st.lists(vectors(5, -1, 1), min_size=3, max_size=3),
    moves=st.lists(vectors(5, -1, 1), min_size=3, max_size=3),
)
def test_many_at_once_are_as_each_alone(states, moves):
    cart = CartModel(Inertia(MASS, COM, ABOUT_COM), RollingConstraints(0.0), (EndStop(0.1, restitution=0.5),))
    before, after = np.array(states), np.array(states) + 0.1 * np.array(moves)
    steps = np.array([0.1, 0.2, 0.3])
    many = bounced(cart, before, after, 0.0, steps)
    for i in range(3):
        np.testing.assert_allclose(many[i], bounced(cart, before[i], after[i], 0.0, steps[i]), atol=1e-12)


def test_one_that_does_not_bounce_is_no_wall():
    assert walls_of(rail_cart(EndStop(1.0), EndStop(1.0, stiffness=1e4, label="b"))) == ()
    assert rolled(rail_cart(EndStop(1.0)), 0.9, 1.0, 0.2)[1][-1] == pytest.approx(1.1)


# --- the spring ----------------------------------------------------------------------------------------------


@pytest.mark.some(3)
@SIDES
@pytest.mark.parametrize(("stiffness", "speed"), [(2e4, 1.0), (5e3, 0.5), (1e5, 2.0)])
def test_a_spring_is_touched_for_half_a_period(stiffness, speed, side):
    """Depth is a half sine, v sqrt(m / k) deep (28 to 32 mm here), for pi sqrt(m / k); the force sets in over 2 mm."""
    pace = math.sqrt(stiffness / MASS)
    cart = rail_cart(EndStop(0.0, side, stiffness=stiffness))
    time, x, v = rolled(cart, -side * 0.2, side * speed, 0.4 / speed + math.pi / pace, step=1e-4)
    depth = side * x
    assert v[-1] == pytest.approx(-side * speed, rel=1e-5)
    lasts = time[-1] - (0.2 - depth[-1]) / speed  # what is not spent on the ways to and fro
    assert lasts == pytest.approx(math.pi / pace, rel=0.01)
    assert depth.max() == pytest.approx(speed / pace, abs=1e-3)
    touching = (time > 0.2 / speed) & (time < 0.2 / speed + math.pi / pace)
    expected = speed / pace * np.sin(pace * (time[touching] - 0.2 / speed))
    np.testing.assert_allclose(depth[touching], expected, atol=1e-3)


@pytest.mark.parametrize("share", [0.05, 0.2, 0.5])
def test_a_damped_spring_that_never_pulls_has_the_known_restitution(share):
    """exp(-b / w (pi - atan(2 b w / (w² - b²)))) with b = c / 2 m and w² = k / m - b², for b below w (Schwager and
    Pöschel, Granular Matter 9, 2007): one that could pull would end at depth 0 and give exp(-pi b / w)."""
    stiffness = 1e4
    pace = math.sqrt(stiffness / MASS)
    fade = share * pace
    turn = math.sqrt(pace**2 - fade**2)
    cart = rail_cart(EndStop(0.0, stiffness=stiffness, damping=2 * MASS * fade))
    _, _, v = rolled(cart, -0.1, 2.0, 0.6, step=1e-4)
    expected = math.exp(-fade / turn * (math.pi - math.atan2(2 * fade * turn, turn**2 - fade**2)))
    assert -v[-1] / 2.0 == pytest.approx(expected, abs=0.01)
    assert abs(expected - math.exp(-math.pi * fade / turn)) > 0.01 or share < 0.1


@pytest.mark.parametrize("stiffness", [1e4, 1e6, 1e8])
def test_a_plant_takes_steps_as_short_as_a_stop_needs(stiffness):
    """At the default step a stop of 1e8 N/m would be left at any speed."""
    _, _, v = rolled(rail_cart(EndStop(0.0, stiffness=stiffness)), -0.5, 1.0, 1.2, step=0.01)
    assert v[-1] == pytest.approx(-1.0, abs=1e-3)


# --- where it stands -----------------------------------------------------------------------------------------

CART = """\
mass: 20.0
com: [0.0, 0.0]
inertia: 2.0
constraints:
  - no_lateral_slip: {x: 0.0}
  - no_rotation: {}
effects:
  end_stop:
    low: {position: 0.2, side: -1, stiffness: 2.0e+4, damping: 30}
    high: {position: 1.15, restitution: 0.8}
"""


def test_stops_stand_in_the_cart_file():
    low, high = cart_from_text(cart_text(cart_from_text(CART))).effects
    assert low == EndStop(0.2, -1.0, stiffness=2e4, damping=30.0, label="low")
    assert high == EndStop(1.15, restitution=0.8, label="high")


def test_a_search_in_forces_does_not_offer_it():
    from cartgrasp.effects import KNOWN_EFFECTS

    assert "end_stop" in {kind.name for kind in KNOWN_EFFECTS.values() if not kind.searched}
