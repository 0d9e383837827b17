"""Scans of periods against sums over the motion, and against least squares at each period."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cartgrasp.effects import LearnedForce
from estimation.discrepancy.search.covariates import Covariates
from estimation.discrepancy.search.laws import Law
from estimation.discrepancy.search.model import Model
from estimation.discrepancy.search.periods import (
    LAW_HARMONICS,
    LAW_VARIABLE_OF,
    Scan,
    coarse_columns,
    is_like_a_scans,
    scanned,
)
from estimation.discrepancy.search.screening import Screen
from estimation.weak_form.balances import Balances

from .test_laws import CART, resisted

FREQUENCIES = np.arange(0.5, 4.0, 0.02)


@pytest.mark.parametrize(("variable", "lever"), [("time", 0.0), ("way", 0.0), ("way", 0.3), ("x", 0.0)])
def test_power_is_that_of_the_sum_over_the_motion(variable, lever):
    """Against sines and cosines at each frequency, of a motion to and fro whose samples crowd where it turns."""
    random, time = np.random.default_rng(0), np.linspace(0.0, 20.0, 2001)
    way, heading = 3.0 * np.sin(0.7 * time), 0.8 * np.sin(0.3 * time)
    place = np.column_stack([way * np.cos(heading), way * np.sin(heading)])
    course = Covariates(time, way, np.abs(way), heading, np.gradient(way), np.zeros(2001), place, np.abs(way))
    pull = random.standard_normal((2001, 2))
    acts_on = "world_force" if variable == "x" else "forward_force"
    scan = Scan(
        variable,
        LearnedForce(acts_on, LAW_VARIABLE_OF[variable], lever=lever, period=1.0),
        "",
        FREQUENCIES,
        LAW_HARMONICS[-1] * 4.0,
    )
    weight = pull[:, 0] - lever * pull[:, 1]
    weight = weight * (np.cos(heading) if variable == "x" else 1.0)
    phase = 2j * np.pi * (getattr(course, variable) - lever * heading)
    power, frequencies = scan.power([course], [pull])
    assert frequencies[-1] == pytest.approx(scan.highest, abs=scan.spacing)
    inside = frequencies > scan.frequencies[0]
    direct = np.abs(np.exp(frequencies[inside, None] * phase) @ weight) ** 2
    assert power[inside] == pytest.approx(direct, abs=0.12 * direct.max())
    assert np.argmax(power[inside]) == np.argmax(direct)


@settings(max_examples=20, deadline=None)
@given(
    harmonics=st.sampled_from(LAW_HARMONICS),
    frequency=st.floats(0.6, 3.5),
    seed=st.integers(0, 1000),
)
def test_a_comb_is_highest_where_least_squares_leave_least(harmonics, frequency, seed):
    """A pulse has next to nothing in its first harmonic: the period is told by all of them."""
    random, time = np.random.default_rng(seed), np.linspace(0.0, 20.0, 2001)
    sizes = random.uniform(0.5, 1.0, harmonics) * np.minimum(np.arange(1, harmonics + 1) / harmonics, 1.0)
    phases = random.uniform(0.0, 2 * np.pi, harmonics)
    turns = 2 * np.pi * np.arange(1, harmonics + 1)
    pull = np.cos(np.outer(frequency * time, turns) + phases) @ sizes + 0.3 * random.standard_normal(2001)
    none = np.zeros(2001)
    course = Covariates(time, time, time, none, none, none, np.zeros((2001, 2)), time)
    scan = Scan("time", LearnedForce("forward_force", "time", period=1.0), "", FREQUENCIES, LAW_HARMONICS[-1] * 4.0)
    power, frequencies = scan.power([course], [np.column_stack([pull, none])])
    combs = [one for one in scan.combs(power, frequencies) if one[2] == harmonics]

    def left(at):
        columns = np.exp(1j * np.outer(at * time, turns))
        own = np.hstack([columns.real, columns.imag])
        return ((pull - own @ np.linalg.lstsq(own, pull)[0]) ** 2).sum()

    _, found, _ = max(combs)
    near = min((at for _, at, _ in combs), key=lambda at: abs(at - frequency))
    assert near == pytest.approx(found, abs=scan.spacing / harmonics)
    assert found == pytest.approx(frequency, abs=scan.spacing / harmonics)
    assert left(found) <= 1.3 * min(left(at) for _, at, _ in sorted(combs, reverse=True)[:40])


def hummed(period, force, duration):
    """A model of a log in which a sine of time resisted, that knows nothing of it."""
    log = resisted(lambda time, truth: force * np.sin(2 * np.pi * time / period), 1, duration)
    return replace(Model.started([Balances.of(log, CART)], CART), compares=True).rewhitened()


@pytest.mark.parametrize(("duration", "period"), [(12.0, 0.9091), (12.0, 1.25), (20.0, 0.7576)])
def test_a_sine_is_told_at_its_own_period(duration, period):
    """Not at two of them, though its frequency lies half-way between two of the scan's."""
    screen = Screen(hummed(period, 15.0, duration))
    laws = [(screen.of_law(law), law) for law, _ in screen.laws() if law.period]
    _, best = max(laws, key=lambda one: one[0])
    assert best.period == pytest.approx(period, rel=0.01)
    assert best.size == 2


def test_what_a_scan_expects_to_gain_is_what_columns_gain():
    """Of one harmonic, by its power and the information about it."""
    screen = Screen(hummed(1.3, 15.0, 24.0))
    model, (balances,), (whiten,) = screen.model, screen.model.logs, screen.model.whitenings
    scale, left = model.score.scale, model.rows[..., -1] - model.rows[..., :-1] @ model.score.fit

    pull = balances.integrals.spread(whiten.transposed(left / scale**2))[:, :2]
    found, _ = scanned(model, [pull], screen.gains)
    gained, scan, period, harmonics = max((best[0] for best in found), key=lambda one: one[0])
    assert period == pytest.approx(1.3, rel=0.02)
    assert harmonics == 1
    course = Covariates.along(balances.motion)
    power, frequencies = scan.power([course], [pull])
    at, std = int(np.argmax(power)), scan.effect.parameters[0].typical
    own = model.whitened([scan.columns(frequencies[at : at + 1], 1, course, balances, model.cart)[:, :, 0]])
    information = ((own / scale[:, None]) ** 2).sum()
    foreseen = power[at] / (information + 2 / std**2) - np.log1p(std**2 * information / 2)
    assert foreseen == pytest.approx(screen.gains(own[None], np.full(2, std))[0], rel=0.15)
    assert foreseen == pytest.approx(gained, rel=0.15)


def test_a_proposed_mean_has_no_period_to_be_tuned():
    screen = Screen(hummed(1.3, 15.0, 12.0))
    mean = Law.free("as proposed", LearnedForce("forward_force", "time", period=1.0, harmonics=(0,)))
    assert screen.tuned(mean) is mean


@pytest.mark.parametrize(
    ("effect", "scanned"),
    [
        (LearnedForce("forward_force", "time", period=1.3, harmonics=(0, 1, 2)), True),
        (LearnedForce("yaw_moment", "travelled_distance", lever=0.2, period=0.5), True),
        (LearnedForce("world_force", "place", direction=np.pi / 2, period=0.7), True),
        (LearnedForce("world_force", "place", direction=0.4, ahead=0.2, period=0.7), True),
        (LearnedForce("drag", "travelled_distance", period=0.5), False),
        (LearnedForce("yaw_moment", "heading"), False),
    ],
)
def test_its_columns_are_the_effects(effect, scanned):
    """But for how densely a motion is summed over, and in which steps its way is added up. What is no wave of a scan's
    variable is told from it."""
    assert is_like_a_scans(effect) == scanned
    if scanned:
        model = hummed(1.3, 15.0, 12.0)
        (balances,) = model.logs
        law = Law.free("as it is", effect)
        exact = law.columns(balances, model.cart)
        coarse = coarse_columns(law, balances, model.cart)
        assert np.abs(coarse - exact).max() < 0.07 * np.abs(exact).max()
