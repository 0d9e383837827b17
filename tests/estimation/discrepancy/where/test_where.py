"""Where a residual is large, in words: misfits put under one circumstance at a time, change points against a search
through all of them, maps against straight lines."""

import re
from dataclasses import replace
from itertools import combinations, pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cartgrasp.effects import LearnedForce
from estimation.discrepancy.search.covariates import Covariates
from estimation.discrepancy.search.periods import Scan
from estimation.discrepancy.where.changes import CHANGE_POINT_PENALTY, changes
from estimation.discrepancy.where.circumstances import Circumstances
from estimation.discrepancy.where.residual import LATERAL_VELOCITY, MIN_CREEP_SPEED, Residual
from estimation.discrepancy.where.residual_map import residual_maps
from estimation.discrepancy.where.where import MAX_SENTENCES, repeats, where

STRETCHES, DURATION = 240, 0.5


def circumstances(seed, names=("run",)):
    """Of stretches that have nothing to do with one another, so that no circumstance stands for another."""
    random, b = np.random.default_rng(seed), STRETCHES
    wrenches = {arm: random.uniform(-30, 30, (b, 3)) for arm in ("left", "right")}
    contacts = {arm: random.choice([-0.4, 0.0], (b, 2)) for arm in wrenches}
    time, way = np.arange(b) * DURATION + DURATION / 2, np.cumsum(random.uniform(0.1, 0.3, b))
    course = Covariates(
        time,
        way,
        way,
        random.uniform(-np.pi, np.pi, b),
        random.uniform(-0.8, 0.8, b),
        random.uniform(-0.5, 0.5, b),
        random.uniform(0.0, 4.0, (b, 2)),
        random.uniform(0.0, 3.0, b),
    )
    log = np.arange(b) * len(names) // b
    return Circumstances(time, log, names, course, wrenches, contacts)


def residual(found, push, coordinate="forward_force", std=0.5, seed=0):
    noise = np.random.default_rng(seed).standard_normal(STRETCHES)
    start = np.arange(STRETCHES) * DURATION
    return Residual(coordinate, std * noise + push, np.full(STRETCHES, std), start, DURATION, found)


UNDER = {
    "within 0.4 m after a reversal": lambda c: (
        (c.covariates.since_reversal < 0.4) & (np.abs(c.covariates.speed) > 0.02)
    ),
    "while it rolls forward": lambda c: c.covariates.speed > 0.02,
    "while it rolls backward": lambda c: c.covariates.speed < -0.02,
    "below 0.12 m/s": lambda c: np.abs(c.covariates.speed) < 0.12,
    "above 0.60 m/s": lambda c: np.abs(c.covariates.speed) > 0.6,
    "while it turns left": lambda c: c.covariates.yaw_rate > 0.08,
    "while it turns right": lambda c: c.covariates.yaw_rate < -0.08,
    "while it goes straight": lambda c: np.abs(c.covariates.yaw_rate) < 0.08,
    "while it heads along the floor's +y": lambda c: np.abs(c.covariates.heading - np.pi / 2) < np.pi / 4,
    "while it heads along the floor's -x": lambda c: np.abs(c.covariates.heading) > 3 * np.pi / 4,
    "where x is 1 to 2 m and y 2 to 3 m": lambda c: (np.floor(c.covariates.place) == (1, 2)).all(axis=1),
    "from t = 30.0 s to 42.0 s, ": lambda c: (c.covariates.time > 30) & (c.covariates.time < 42),
    "after t = 90.0 s, ": lambda c: c.covariates.time > 90,
    "before t = 50.0 s, ": lambda c: c.covariates.time < 50,
    "while the arms push it forward with more than": lambda c: c.total[:, 0] > 37,
    "while the arms pull it backward with more than": lambda c: c.total[:, 0] < -37,
    "while the arms push or pull with less than": lambda c: np.abs(c.total[:, 0]) < 10,
    "while the arms turn it to the left with more than": lambda c: c.total[:, 2] > 37,
    "while the arms turn it with less than": lambda c: np.abs(c.total[:, 2]) < 10,
    "while arm left gives more than": lambda c: np.hypot(*c.wrenches["left"][:, :2].T) > 28,
    "while arm right gives most of the force": lambda c: (
        np.hypot(*c.wrenches["right"][:, :2].T) > np.hypot(*c.wrenches["left"][:, :2].T)
    ),
    "while arm left holds at x = -0.40 m, y = 0.00 m": lambda c: (c.contacts["left"] == (-0.4, 0.0)).all(axis=1),
}


@pytest.mark.some(15)
@pytest.mark.long
@pytest.mark.parametrize("words", UNDER)
@pytest.mark.parametrize("size", [4.0, -6.0])
def test_a_misfit_under_one_circumstance_is_told_by_it(words, size):
    for seed in range(3):
        found = circumstances(seed)
        chosen = UNDER[words](found)
        first = where([residual(found, size * chosen, seed=seed)])[0]
        assert words in first.condition
        assert first.coordinate == "forward_force"
        assert first.share > 0.6
        assert first.size == pytest.approx(abs(size), rel=0.25)
        moves = (np.abs(found.covariates.speed) > 0.02) | (np.abs(found.covariates.yaw_rate) > 0.08)
        share = 100 * (chosen & moves).sum() / moves.sum()
        assert int(first.condition.split("(")[1].split()[0]) == pytest.approx(share, abs=8)
        inside = np.array([any(a < t < b for a, b in first.intervals) for t in found.covariates.time])
        assert (inside == chosen).mean() > 0.9
        if " t = " in words:
            begin, end = found.covariates.time[chosen][[0, -1]]
            assert (first.start, first.stop) == pytest.approx((begin - 0.25, end + 0.25))


def numbers(condition):
    """Of its two ends: the residual there, and where that is."""
    return [float(word) for word in re.findall(r"-?\d+\.?\d*(?= N at| rad| m/s)", condition)]


@pytest.mark.parametrize("seed", range(3))
def test_what_is_everywhere_is_told_by_what_it_goes_with(seed):
    """As a slope, of which one along y is 5 N forward, and one along -y 5 N back; or a drag."""
    found = circumstances(seed)
    slope = residual(found, 5.0 * np.sin(found.covariates.heading), seed=seed)
    told = next(one for one in where([slope]) if "goes with" in one.condition)
    assert "goes with the heading: " in told.condition
    assert numbers(told.condition) == pytest.approx([-4.9, -np.pi / 2, 4.9, np.pi / 2], abs=0.25)
    assert told.share > 0.9
    drag = residual(found, -6.0 * found.covariates.speed, seed=seed)
    (told,) = (one for one in where([drag]) if "goes with" in one.condition)
    assert "goes with the speed: " in told.condition
    assert numbers(told.condition) == pytest.approx([4.2, -0.7, -4.2, 0.7], abs=0.3)
    assert told.share == pytest.approx(0.95, abs=0.06)


def test_what_holds_whenever_a_cart_moves_is_not_told():
    """Pushed forward along +x, with stops in half of the time, and a drag."""
    found = circumstances(4)
    stops = np.arange(STRETCHES) // 10 % 2 == 0
    speed = np.where(stops, 0.0, np.abs(found.covariates.speed) + 0.1)
    nothing = np.zeros(STRETCHES)
    course = replace(found.covariates, speed=speed, yaw_rate=nothing, heading=nothing, since_reversal=nothing + np.inf)
    told = where([residual(replace(found, covariates=course), 5.0 * ~stops)])
    assert "goes with the speed: 0.0" in told[0].condition
    words = " ".join(one.condition for one in told)
    assert "forward" not in words.replace("push it forward", "")
    assert "heads" not in words
    assert "straight" not in words


@pytest.mark.parametrize("period", [0.7, 1.9])
def test_what_repeats_is_told_first_with_its_period(period):
    """A wave of which a second and more is one period, against its own formula."""
    found = circumstances(6)
    law = Scan("time", LearnedForce("forward_force", "time", period=1.0), "force", np.array([0.5, 0.6]), 4.8).law(
        period
    )
    one = residual(found, 3.0 * np.sin(2 * np.pi * found.time / period))
    (told,) = repeats(one, found.time, law)
    assert f"repeats every {period:g} s of time" in told.condition
    low, at_low, high, at_high = map(float, re.findall(r"-?\d+\.?\d*(?= N at| s of it)", told.condition))
    assert (low, high) == pytest.approx((-2.9, 2.9), abs=0.35)
    assert (at_low, at_high) == pytest.approx((0.75 * period, 0.25 * period), abs=period / 10)
    assert told.share == pytest.approx(0.97, abs=0.05)
    assert where([one], [told])[0] is told
    assert not list(repeats(residual(found, 0.0), found.time, law))


def test_the_worst_moment_is_told_where_it_holds_much():
    found = circumstances(7)
    first = where([residual(found, 20.0 * (np.abs(found.time - 50.25) < 0.3))])[0]
    assert "t = 50.0 s" in first.condition
    assert (first.start, first.stop) == (50.0, 50.5)


def test_few_things_are_told():
    found = circumstances(8)
    assert (
        len(where([residual(found, 5.0 * found.covariates.speed, name) for name in ("forward_force", "yaw_moment")]))
        <= MAX_SENTENCES
    )


def test_without_arms_there_is_no_force_to_tell():
    found = replace(circumstances(5), wrenches={}, contacts={})
    one = residual(found, 4.0 * (found.covariates.speed > 0.02))
    assert "rolls forward" in where([one])[0].condition
    assert not any("arm" in m.variable for m in residual_maps([one], [one]))
    assert not found.total.any()


def test_in_one_of_several_logs():
    found = circumstances(1, ("monday", "<b>tuesday"))
    first = where([residual(found, 4.0 * (found.log == 1))])[0]
    assert "in <b>tuesday" in first.condition
    assert where([residual(found, 4.0 * (found.log == 0))])[0].start == 0.0


def test_of_several_conditions_that_are_alike_one_is_told():
    found = circumstances(2)
    found = replace(found, covariates=replace(found.covariates, yaw_rate=found.covariates.speed))
    told = [one.condition for one in where([residual(found, 4.0 * (found.covariates.speed > 0.02))])]
    assert sum("rolls forward" in words or "turns left" in words for words in told) == 1


def test_what_holds_a_push_that_was_told_says_nothing_new():
    """It lies after its begin, and along one heading, too."""
    found = circumstances(3)
    during = (found.covariates.time > 30) & (found.covariates.time < 42)
    found = replace(
        found, covariates=replace(found.covariates, heading=np.where(found.covariates.time < 60, 0.0, np.pi))
    )
    told = where([residual(found, 6.0 * during)])
    assert "from t = 30.0 s to 42.0 s" in told[0].condition
    assert not any("after t" in one.condition or "heads" in one.condition for one in told)


def test_noise_disagrees_nowhere():
    """Three deviations of what its squares make: one in a hundred and more may, for they have a long tail."""
    told = [where([residual(circumstances(seed), 0.0, seed=seed)]) for seed in range(200)]
    assert sum(map(bool, told)) <= 5


def test_a_creep_that_every_bearing_has_is_not_told():
    found = circumstances(3)
    creep = np.where(found.covariates.speed > 0.4, 1.0, 0.0)
    for size, count in ((MIN_CREEP_SPEED, 0), (3 * MIN_CREEP_SPEED, 1)):
        told = where([residual(found, size * creep, LATERAL_VELOCITY, std=1e-4)])
        assert bool(told) == bool(count)


def cost(standard, start, end):
    part = standard[start:end]
    variance = max(np.mean(part**2), 1.0)
    return sum(np.log(variance) + z**2 / variance for z in part)


@settings(max_examples=60, deadline=None)
@given(st.lists(st.floats(-20, 20), min_size=2, max_size=9))
def test_changes_are_the_best_of_all(values):
    standard = np.array(values)
    n = len(standard)

    def total(places):
        ends = (0, *places, n)
        each = sum(cost(standard, a, b) for a, b in pairwise(ends))
        return each + CHANGE_POINT_PENALTY * np.log(n) * len(places)

    best = min(total(places) for k in range(n) for places in combinations(range(1, n), k))
    assert total(changes(standard)) == pytest.approx(best)


@pytest.mark.parametrize("sign", [1, -1])
def test_a_change_of_size_is_found_at_its_place_whatever_the_signs(sign):
    random = np.random.default_rng(5)
    standard = random.standard_normal(120)
    standard[48:66] += 6.0 * sign ** np.arange(18)
    assert changes(standard) == pytest.approx([48, 66], abs=1)


def test_long_residuals_are_looked_at_more_coarsely():
    standard = np.random.default_rng(6).standard_normal(3000)
    standard[1600:] *= 5.0
    assert changes(standard) == pytest.approx([1600], abs=10)
    assert changes(standard[:1]) == []


def test_a_map_is_a_line_where_the_residual_is_one():
    found = circumstances(4)
    before = residual(found, 5.0 * found.covariates.speed, std=0.1)
    after = residual(found, 0.0, std=0.1)
    one = next(m for m in residual_maps([before], [after]) if m.variable == "speed")
    assert len(one.refitted.at) == 8
    assert one.refitted.std == pytest.approx(0.1 / np.sqrt(STRETCHES / 8))
    np.testing.assert_allclose(one.refitted.mean, 5.0 * one.refitted.at, atol=4 * one.refitted.std[0])
    np.testing.assert_allclose(one.extended.mean, 0.0, atol=4 * one.extended.std[0])
    told = one.as_dict()
    assert (told["variable"], told["variable_unit"], told["unit"]) == ("speed", "m/s", "N")
    assert told["extended_std"] == one.extended.std.tolist()


def test_a_map_has_all_that_a_residual_may_depend_on():
    found = circumstances(5)
    never = replace(found, covariates=replace(found.covariates, since_reversal=np.full(STRETCHES, np.inf)))
    names = [m.variable for m in residual_maps([residual(found, 0.0)], [residual(found, 0.0)])]
    less = [m.variable for m in residual_maps([residual(never, 0.0)], [residual(never, 0.0)])]
    assert set(names) - set(less) == {"distance since a reversal"}
    assert {"time", "heading", "way travelled", "force of arm left", "forward force of the arms"} <= set(less)
