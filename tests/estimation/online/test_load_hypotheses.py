"""What surprises is a push, a load or another floor: odds against likelihoods written out, and all three in runs."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import multivariate_normal

from cartgrasp.constraints import RollingConstraints
from cartgrasp.effects import PayloadChange, RollingResistance, ViscousDrag
from cartgrasp.inertia import Inertia
from cartgrasp.model import CartModel
from cartgrasp.simulation.pushed_plant import Push, no_pushes
from cartgrasp.studies.estimators import CONTROL_PERIOD, HANDS, SENSOR_SETS, Job, drive_cart
from cartgrasp.studies.scenario import filter_noise
from cartgrasp.wheels import GRAVITY
from estimation import CartFilter, Prior
from estimation.gaussian import Gaussian
from estimation.online.kernels.row_algebra import FilteredRow
from estimation.online.regressor.load_hypotheses import (
    CHANGE_ONSET_ROWS,
    MAX_HYPOTHESES_ROWS,
    MIN_HYPOTHESES_BLOCKS,
    PUSH_END_ROWS,
    PUSH_STEP_STD_RATIO,
    HypothesesOpening,
    LearnedRow,
)
from estimation.online.regressor.load_monitor import LoadMonitor
from estimation.online.regressor.mass_products import MassProducts
from estimation.online.regressor.regression_belief import RegressionBelief, Unlinked, mixture
from estimation.whole_log.replay import replay

FADE, NOISE, USUAL, LOAD = 0.8, 0.09, np.array([[1600.0]]), np.array([[36.0]])
MASS, KNOWN = 20.0, 0.25


def belief(mean=MASS, variance=KNOWN):
    first = Gaussian(np.array([mean]), np.array([[variance]]))
    return RegressionBelief(np.array([0]), first, 1, np.zeros(1), MassProducts(np.zeros(0, np.int64), 0.0, np.zeros(0)))


def row(rise, force):
    """Of a mass alone, with exact motion, around nought."""
    exact = np.array([[1e-12]])
    return FilteredRow(
        residual=np.array([force]),
        slopes=np.array([[rise, 0.0]]),
        ends=np.zeros((1, 1)),
        fade=FADE,
        noise=np.array([[NOISE]]),
        before=exact,
        after=exact,
        shared=np.zeros((1, 1)),
        curvature=np.zeros((1, 1)),
        by_rise=np.zeros((1, 1, 1)),
        quieter=np.zeros((1, 1)),
        of_wrenches=np.array([[NOISE]]),
        of_delay=np.zeros((2, 1, 1)),
        bent_by_delay=np.zeros(1),
    )


def trial(rows):
    """Begun with the first row."""
    at = np.zeros(1)
    beginning = HypothesesOpening.of(0.0, [LearnedRow(belief(), rows[0], at)], LOAD, 0.0 * LOAD, USUAL)
    while beginning.left:
        beginning = beginning.go_on()
    found = beginning.hypotheses
    for one in rows[1:]:
        on_its_way = found.with_row(one, at)
        while on_its_way.hypotheses is None:
            on_its_way = on_its_way.go_on()
        found = on_its_way.hypotheses
    return found


def log_density(value, mean, variance):
    return float(multivariate_normal(mean, variance).logpdf(value))


def test_odds_are_a_ratio_of_likelihoods():
    """Of three rows after those in which it sets in: of a load, jointly normal; of a push, steady over two more rows
    and gone in the third."""
    rises, forces, gain = np.array([0.6, 0.5, 0.4]), np.array([14.0, 12.0, 8.4]), 1.0 - FADE
    setting_in = [row(0.5, 12.0)] * CHANGE_ONSET_ROWS
    found = trial([*setting_in, *(row(*one) for one in zip(rises, forces, strict=True))])
    loaded = NOISE * np.eye(3) + (KNOWN + LOAD[0, 0]) * np.outer(rises, rises)
    of_load = log_density(forces, MASS * rises, loaded)
    spread, news, steady = KNOWN * rises**2 + NOISE, 2.0, (gain * PUSH_STEP_STD_RATIO) ** 2 * USUAL[0, 0]
    pushed = [log_density(forces[i], MASS * rises[i] + news, spread[i] + steady) for i in (0, 1)]
    third = log_density(forces[2], MASS * rises[2], spread[2])
    (changed,) = found.changed
    assert changed.odds == pytest.approx(of_load - sum(pushed) - third, abs=1e-3)
    assert found.pushed.rows == 1
    left = Gaussian(np.array([MASS]), np.array([[KNOWN]]))
    gained = 1 / (1 / KNOWN + rises[2] ** 2 / NOISE)
    mean = gained * (left.mean[0] / KNOWN + rises[2] * forces[2] / NOISE)
    assert found.pushed.belief.parameters.mean[0] == pytest.approx(mean, rel=1e-4)  # a little is forgotten
    assert found.pushed.belief.parameters.covariance[0, 0] == pytest.approx(gained, rel=1e-3)


def test_a_load_goes_on_and_a_push_ends():
    random = np.random.default_rng(0)
    rises = random.uniform(0.3, 0.8, MAX_HYPOTHESES_ROWS)
    noise = math.sqrt(NOISE) * random.standard_normal(MAX_HYPOTHESES_ROWS)
    load = trial([row(r, 26.0 * r + e) for r, e in zip(rises[:MIN_HYPOTHESES_BLOCKS], noise, strict=False)])
    assert load.is_reported
    assert load.is_over
    assert load.belief.parameters.mean[0] == pytest.approx(26.0, abs=3 * load.belief.parameters.covariance[0, 0] ** 0.5)
    pushes = [-3.0, -3.2, -2.8, *np.zeros(PUSH_END_ROWS)]
    push = trial([row(r, MASS * r + p + e) for r, p, e in zip(rises, pushes, noise, strict=False)])
    assert push.is_over
    assert not push.is_loaded
    assert abs(push.belief.parameters.mean[0] - MASS) < 3 * push.belief.parameters.covariance[0, 0] ** 0.5 < 1.0
    wild = 8.0 * random.standard_normal(MAX_HYPOTHESES_ROWS)
    endless = trial([row(r, MASS * r + p) for r, p in zip(rises, wild, strict=True)])
    assert endless.is_over
    assert endless.is_endless
    early = trial([row(r, 26.0 * r + e) for r, e in zip(rises[: MIN_HYPOTHESES_BLOCKS - 1], noise, strict=False)])
    assert not early.is_over  # a push may last so long
    assert early.without_link(is_still=True).is_over  # nothing more is learned
    assert not early.without_link(is_still=False).is_over


@pytest.mark.parametrize("told", [0, 1])
def test_what_is_not_told_apart_is_as_wide_as_both(told):
    """One of them is told, with the mean square distance of both from it."""
    random, share = np.random.default_rng(1), 0.3
    one, other = belief(20.0, 0.25), belief(26.0, 1.0)
    drawn = np.where(
        random.random(200_000) < share, random.normal(26.0, 1.0, 200_000), random.normal(20.0, 0.5, 200_000)
    )
    found, mean = (
        mixture([Unlinked.of(one), Unlinked.of(other)], np.array([1.0 - share, share]), told).parameters,
        (20.0, 26.0)[told],
    )
    assert found.mean[0] == pytest.approx(mean, rel=1e-9)
    assert found.covariance[0, 0] == pytest.approx(np.mean((drawn - mean) ** 2), rel=0.01)


def test_no_load_is_told_before_it_is_sure():
    """However likely it is by then."""
    rises = np.full(MIN_HYPOTHESES_BLOCKS - 1, 0.5)
    found = trial([row(r, 26.0 * r) for r in rises])
    (load,) = found.changed
    assert load.odds > 3.0
    assert not found.is_loaded or not found.is_over
    undecided = trial([row(0.1, 2.02)] * (CHANGE_ONSET_ROWS + 2))
    assert undecided.belief.parameters.mean[0] == pytest.approx(undecided.pushed.belief.parameters.mean[0])
    assert undecided.belief.parameters.covariance[0, 0] > undecided.pushed.belief.parameters.covariance[0, 0]


def test_what_surprises_thrice_speaks_against_the_model():
    """Told apart or not; but not another floor."""
    load = trial([row(0.5, 13.0)] * MIN_HYPOTHESES_BLOCKS)
    unsure = trial([row(1e-6, 0.0)] * MAX_HYPOTHESES_ROWS)
    floor = replace(load, changed=tuple(one._replace(is_load=False) for one in load.changed))
    assert load.is_loaded
    assert not unsure.is_loaded
    assert floor.is_on_another_floor
    for found, health in ((load, "inconsistent"), (unsure, "inconsistent"), (floor, "ok")):
        assert found.is_over
        watch = LoadMonitor(1, 1)
        for time in (1.0, 7.0):
            watch.settle(time, found)
            watch.note_time(time + 3.0)
            assert watch.health == "ok"
        watch.settle(13.0, found)
        assert watch.health == health


def driven(outside=no_pushes, load=0.0, seed=0, effects=(), duration=10.0, prior=None):
    """The estimates from 4 s on: of 24 kg, on curves, pushed or loaded at 4 s."""
    loads = (PayloadChange(4.0, load, 0.2, 0.1),) if load else ()
    truth = CartModel(Inertia(24.0, (0.28, 0.06), 2.2), RollingConstraints(), (ViscousDrag(3.0, 1.2), *effects, *loads))
    guess = CartModel(Inertia(20.0, (0.3, 0.0), 1.8), RollingConstraints(), (ViscousDrag(2.0, 1.0), *effects))
    log = drive_cart(truth, Job("curves", "usual", seed), duration, outside).log
    told = replay(log, CartFilter(guess, list(HANDS), noise=filter_noise(SENSOR_SETS["usual"]), prior=prior)).estimates
    return [one for one in told if one.time > 4.0]


def mass_and_health(told):
    return told[-1].parameters["mass"], [one.health for one in told]


@pytest.mark.some(1)
@pytest.mark.parametrize("angle", [0.0, 1.0, math.pi])
@pytest.mark.parametrize("force", [15.0, 50.0])
def test_a_push_teaches_no_mass(force, angle):
    """Three draws of the sensors' noise: in one of a hundred a load is thought of a second later, which leaves the mass
    right and for some seconds half as sure."""
    push = Push(force * np.array([math.cos(angle), math.sin(angle), 0.0]), np.array([0.3, 0.1, 0.4]))
    widths = []
    for seed in range(3):
        mass, health = mass_and_health(driven(lambda time, _: [push] if 4.0 <= time < 4.4 else [], seed=seed))
        assert abs(mass.value - 24.0) < 3 * mass.std
        assert health[-1] == "ok"
        assert 0.1 < CONTROL_PERIOD * health.count("load_changed") < 2.0
        widths.append(3 * mass.std)
    assert np.median(widths) < 2.5
    assert max(widths) < 4.0


@pytest.mark.long
def test_a_load_does():
    mass, health = mass_and_health(driven(load=8.0, duration=10.5, prior=Prior(slope=0.0)))
    assert abs(mass.value - 32.0) < 3 * mass.std < 3.5
    assert "load_changed" in health
    assert health[-1] == "ok"


@pytest.mark.long
@pytest.mark.some(1)
@pytest.mark.parametrize("more", [0.02, 0.04])
def test_another_floor_teaches_its_resistance_and_no_mass(more):
    """From 7 s on, by a force that nobody gave: coefficient times weight, against the way the cart rolls."""
    weight, resistance = GRAVITY * 24.0, RollingResistance(0.01)

    def rough(time, motion):
        drag = -more * weight * math.tanh(motion.velocity[0] / 0.01)
        return [Push(np.array([drag, 0.0, 0.0]), np.array([0.28, 0.06, 0.0]))] if time >= 7.0 else []

    told = driven(rough, effects=(resistance,), duration=14.0)
    mass, health = mass_and_health(told)
    coefficient = told[-1].parameters["rolling_resistance.coefficient"]
    assert abs(mass.value - 24.0) < 3 * mass.std < 4.0
    assert abs(coefficient.value - 0.01 - more) < 3 * coefficient.std < 0.012
    assert health[-1] == "ok"
