"""End stops from impacts: where, how much comes back, and what is no stop."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cartgrasp.constraints import RollingConstraints
from cartgrasp.contacts import ContactWrenches
from cartgrasp.effects import EndStop, FloorSlope
from cartgrasp.inertia import Inertia
from cartgrasp.logs import ArmLog, RunLog
from cartgrasp.model import CartModel
from cartgrasp.simulation.plant import ModelPlant
from estimation.impacts.end_stops import end_stops
from estimation.impacts.impacts import Impact, impacts

RAIL = CartModel(Inertia(0.5, (0.0, 0.0), 0.01), RollingConstraints(0.0, no_rotation=True))


def hits(places, before, after, heading=0.0):
    return [
        Impact(float(i), np.array([x, 0.0, heading]), b, a)
        for i, (x, b, a) in enumerate(zip(places, before, after, strict=True))
    ]


@given(
    place=st.floats(-5, 5),
    share=st.floats(0.1, 1.0),
    speeds=st.lists(st.floats(0.1, 2.0), min_size=3, max_size=6),
    heading=st.sampled_from([0.0, 0.6, math.pi]),
    ahead=st.booleans(),
)
def test_exact_impacts_give_the_stop_exactly(place, share, speeds, heading, ahead):
    """Whichever end of the cart comes first, and from whichever side."""
    signed = [v if ahead else -v for v in speeds]
    (stop,) = end_stops(hits([place] * len(speeds), signed, [-share * v for v in signed], heading))
    assert stop.position == pytest.approx(place)
    assert stop.restitution == pytest.approx(share)
    assert (stop.position_std, stop.restitution_std) == pytest.approx((0.0, 0.0), abs=1e-9)
    assert stop.side == math.copysign(1.0, math.cos(heading) * signed[0])
    assert stop.count == len(speeds)
    assert stop.effect("far") == EndStop(stop.position, stop.side, min(stop.restitution, 1.0), label="far")


def test_deviations_are_as_large_as_errors_are():
    """Over 400 draws of five impacts each the errors over the deviations told follow Student's t with 4 degrees of
    freedom, of which 78 % are within 1.4 (its tails are what a small sample makes)."""
    random = np.random.default_rng(2)
    shares = []
    for _ in range(400):
        before = random.uniform(0.3, 1.0, 5)
        after = -0.7 * before + random.normal(0, 0.02, 5)
        (stop,) = end_stops(hits(1.0 + random.normal(0, 0.004, 5), before, after))
        shares.append([(stop.position - 1.0) / stop.position_std, (stop.restitution - 0.7) / stop.restitution_std])
    inside = (np.abs(shares) < 1.4).mean(axis=0)
    assert inside == pytest.approx([0.766, 0.766], abs=0.07)


@pytest.mark.parametrize(
    "found",
    [
        hits([1.0, 1.0], [1, 1], [-1, -1]),  # too few
        hits([1.0, 1.2, 1.4], [1, 1, 1], [-1, -1, -1]),  # at no one place
        hits([1.0, 1.0, 1.0], [1, 1, 1], [0.5, 0.5, 0.5]),  # a threshold that it goes over
        hits([1.0, 1.0, 1.0], [1, -1, 1], [-1, 1, -1]),  # one of them from behind
        hits([1.0, 1.0, 1.0], [1, 1, 1], [-1, -1, -1], heading=math.pi / 2),  # along y
        [],
    ],
)
def test_what_is_no_stop(found):
    assert end_stops(found) == ()


def test_two_stops_and_a_stray_impact():
    found = [
        *hits([0.0, 0.02, 0.01], [-1, -0.8, -0.5], [0.5, 0.4, 0.25]),
        *hits([2.0, 2.01, 2.02, 2.0], [1, 0.8, 0.5, 0.3], [-0.9, -0.72, -0.45, -0.27]),
        *hits([1.0], [1.0], [-0.1]),
    ]
    low, high = end_stops(found)
    assert (low.position, low.side, low.count) == (pytest.approx(0.01), -1.0, 3)
    assert (high.position, high.side, high.count) == (pytest.approx(2.0075), 1.0, 4)
    assert (low.restitution, high.restitution) == (pytest.approx(0.5), pytest.approx(0.9))


@pytest.mark.parametrize(("noise", "step"), [(5e-4, 0.0), (0.0, 0.01)])
def test_a_simulated_stop_is_found_again(noise, step):
    """A cart bounces down a slope of 2 degrees in our plant; flights last 2 v / a, so the first three touches take
    sqrt(2 h / a) (1 + 2 e + 2 e²) s."""
    cart = CartModel(RAIL.inertia, RAIL.constraints, (EndStop(1.15, restitution=0.85), FloorSlope(-0.035)))
    plant = ModelPlant(cart, (0.45, 0.0, 0.0))
    rows = []
    for _ in range(1200):
        rows.append((plant.time, *plant.motion.pose_sb))
        plant.step(ContactWrenches({}, {}), 0.01)
    table = np.array(rows)
    table[:, 1] += np.random.default_rng(0).normal(0, noise, len(table)) if noise else 0.0
    table[:, 1] = np.round(table[:, 1] / step) * step if step else table[:, 1]
    found = impacts(RunLog(table[:, 0], table[:, 1:], None, {}), RAIL)
    begin = math.sqrt(2 * 0.7 / (0.035 * 9.80665))
    assert [one.time for one in found[:3]] == pytest.approx(
        [begin, begin * (1 + 2 * 0.85), begin * (1 + 2 * 0.85 + 2 * 0.85**2)], abs=0.03
    )
    (stop,) = end_stops(found)
    assert stop.position == pytest.approx(1.15, abs=0.01)
    assert stop.restitution == pytest.approx(0.85, abs=0.03)


def test_a_push_just_after_a_hit_is_no_part_of_it():
    """Between two stops 2 m apart, of which 0.7 of the speed comes back. A hand pushes whenever the cart is slower than
    0.6 m/s, for 0.2 s after each hit: a parabola over twice that had told 0.84, and a deviation of 0.005."""
    step, x, speed, way, force = 1e-3, 1.0, 0.8, [], []
    for _ in range(20_000):
        force.append(20.0 * math.copysign(abs(speed) < 0.6, speed))
        way.append(x)
        speed += step * force[-1] / 24.0
        x += step * speed
        if (x > 2.0 and speed > 0.0) or (x < 0.0 and speed < 0.0):
            speed *= -0.7
    pose, wrench = np.zeros((2000, 3)), np.zeros((2000, 6))
    pose[:, 0], wrench[:, 0] = way[::10], force[::10]
    pose += 3e-4 * np.random.default_rng(0).standard_normal(pose.shape)
    log = RunLog(0.01 * np.arange(2000), pose, None, {"hand": ArmLog(np.zeros((2000, 3)), wrench)})
    rail = CartModel(Inertia(24.0, (0.0, 0.0), 0.5), RAIL.constraints)
    for stop in end_stops(impacts(log, rail)):
        assert stop.count == 3
        assert stop.restitution == pytest.approx(0.7, abs=0.06)
