"""The filtered regression: its rows by another road, honest over seeds, and changes of load noticed in time."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import block_diag
from scipy.stats import multivariate_normal

from cartgrasp.effects import RollingResistance, ViscousDrag
from cartgrasp.inertia import Inertia
from cartgrasp.model import CartModel
from estimation import FilterNoise, Prior, RegressorEstimator
from estimation.gaussian import Gaussian
from estimation.log_noise.log_noise import noise_of_log
from estimation.online.kernels.row_algebra import FilteredRow, Smoothed, weights
from estimation.online.kernels.row_parts import FILTER_RATE
from estimation.online.load_change import root_of
from estimation.online.regressor import regression_belief
from estimation.online.regressor.filtered_row import Block
from estimation.online.regressor.load_monitor import LoadMonitor
from estimation.online.regressor.mass_products import MassProducts
from estimation.online.regressor.regression_belief import Innovation, RegressionBelief
from estimation.online.regressor.wrench_noise_scale import WrenchNoiseScale
from estimation.whole_log.replay import replay

from ..runs import integrate, pushed, simulate, simulate_two_hands, wrench_rows
from ..whole_log.test_identification import at_rest
from .declared import filtered_row, unmodelled_noise

NONE = np.zeros(0, np.int64)
TRUTH = (24.0, 0.28, 0.06, 2.2, 3.0, 1.2, 0.02)
DRAGS = (ViscousDrag(linear=2.0, angular=1.0), RollingResistance(coefficient=0.015))


def guess(effects=DRAGS):
    return CartModel(Inertia(20.0, (0.3, 0.0), 1.8), effects=effects)


def learned(log, cart=None, **arguments):
    cart = cart or guess()
    return replay(log, RegressorEstimator(cart, list(log.arms), noise=noise_of_log(log, cart), **arguments))


# --- rows ----------------------------------------------------------------------------------------------------


def test_a_block_is_what_is_new_of_a_filter():
    """`F_k - fade F_(k-1)` of the filter's own differential equation, over uneven steps."""
    random = np.random.default_rng(0)
    time = np.cumsum(random.uniform(0.002, 0.05, 12))
    knots = random.standard_normal(12)

    def follow(value):
        flow = solve_ivp(
            lambda t, y: FILTER_RATE * (value(t) - y), (time[0], time[-1]), [0.7], rtol=1e-9, atol=1e-11, max_step=1e-3
        )
        return flow.y[0, -1]

    one = weights(time, 1)
    linear = follow(lambda t: np.interp(t, time, knots)) - one.fade * 0.7
    held = follow(lambda t: knots[min(np.searchsorted(time, t, "right") - 1, 10)]) - one.fade * 0.7
    assert one.fade == pytest.approx(np.exp(-FILTER_RATE * (time[-1] - time[0])))
    assert one.linear @ knots == pytest.approx(linear, abs=1e-7)
    assert one.held @ knots[:-1] == pytest.approx(held, abs=1e-4)


def test_a_row_is_the_mean_of_blocks_that_begin_later_and_later():
    random = np.random.default_rng(1)
    time, value = np.cumsum(random.uniform(0.005, 0.02, 20)), random.standard_normal(20)
    whole, parts = weights(time, 6), [weights(time[i : i + 15], 1) for i in range(6)]
    linear = [part.linear @ value[i : i + 15] for i, part in enumerate(parts)]
    held = [part.held @ value[i : i + 14] for i, part in enumerate(parts)]
    assert whole.linear @ value == pytest.approx(np.mean(linear))
    assert whole.held @ value[:-1] == pytest.approx(np.mean(held))
    assert whole.of_motion[2] @ value == pytest.approx(
        value[14:].mean() - whole.fade * value[:6].mean() - np.mean(linear)
    )


def test_neighbours_share_the_noise_where_they_overlap():
    """White noise of held forces, in two rows of which one begins where the other's first block ends."""
    time = 0.01 * np.arange(20)
    one = weights(time, 10)
    forces = np.random.default_rng(2).standard_normal((40000, 29))
    first, second = forces[:, :19] @ one.held, forces[:, 10:] @ one.held
    assert np.mean(first * second) == pytest.approx(one.shared * np.mean(first**2), rel=0.05)
    assert one.of_white * 0.01 == pytest.approx(np.mean(first**2), rel=0.05)


def test_neighbours_share_half_of_the_noise_at_most_whatever_the_clock():
    """A row's noise is what it shares with the row before and the one after, and its own: none of them is negative."""
    time = np.array([8.52, 8.59, 8.63, 8.67, 8.69, 8.70, 8.71])
    assert weights(time, 5).shared <= 0.5


def test_a_row_of_the_truth_has_no_residual():
    """Hand-written dynamics, integrated; and slopes by differences."""
    truth, wrenches = integrate((*TRUTH[:-1], 0.0), pushed, 1.3)
    cart = CartModel(Inertia(24.0, (0.28, 0.06), 2.2), effects=(ViscousDrag(linear=3.0, angular=1.2),))
    block = slice(100, 126)
    states, time = truth[block], 0.01 * np.arange(100, 126)
    weighing, exact, none = weights(time, 8), np.tile(1e-14 * np.eye(2), (26, 1, 1)), np.zeros((26, 0))
    pose, nu = states[:, :3].copy(), states[:, 3:].copy()
    moved = Smoothed(time, pose, nu, np.zeros((26, 2)), exact, exact[:3], none, none)

    def row(theta):
        rows = wrench_rows(time[:-1], wrenches[block][:-1], theta)
        known, spread = Gaussian(theta, np.zeros((6, 6))), np.zeros((6, 0))
        return filtered_row(
            cart, known, spread, Block(weighing, moved, rows), unmodelled_noise(cart, FilterNoise(), NONE)
        )

    found = row(cart.parameters)
    size = weighing.held @ wrenches[block][:-1]
    assert np.abs(found.residual).max() < 2e-4 * np.abs(size).max()
    for i, move in enumerate(1e-4 * np.eye(6)):
        by = (row(cart.parameters + move).residual - row(cart.parameters - move).residual) / 2e-4
        assert -by == pytest.approx(found.slopes[:, i], abs=1e-6)


def test_what_is_not_linear_is_noise_and_bias_while_little_is_known():
    """Rolling resistance is load times coefficient: of drawn parameters, what a linear row misses. They depend on each
    other, as where their product is known better than they are."""
    cart = CartModel(Inertia(24.0, (0.28, 0.06), 2.2), effects=(RollingResistance(0.02),))
    random = np.random.default_rng(0)
    velocity, acceleration = np.tile([0.5, 0.2], (11, 1)), np.tile([0.3, 0.1], (11, 1))
    time, zero = 0.015 * np.arange(11), np.zeros((11, 3))
    covariance = np.tile(np.eye(2), (11, 1, 1))
    moved = Smoothed(
        time, zero, velocity, acceleration, covariance, covariance[:3], np.zeros((11, 0)), np.zeros((11, 0))
    )
    rows = wrench_rows(time[:-1], np.zeros((10, 2)), cart.parameters)
    spread = np.diag([4.0, 1.0, 1.0, 0.5, 0.005])
    spread[4, 0] = -0.004
    known, block = Gaussian(cart.parameters, spread @ spread.T), Block(weights(time, 1), moved, rows)
    row = filtered_row(cart, known, spread, block, unmodelled_noise(cart, FilterNoise(), NONE))
    straight = filtered_row(cart, known, np.zeros((5, 0)), block, unmodelled_noise(cart, FilterNoise(), NONE))
    drawn = random.standard_normal((20000, 5)) @ spread.T
    rows = np.tile([0.0, 0.0, 0.0, 0.5, 0.2], (20000, 1)), np.tile([0.3, 0.1], (20000, 1))
    at = cart.inverse(rows[0], rows[1], cart.parameters)
    moved = cart.required_wrench(*rows, cart.parameters + drawn)
    missed = moved - at.wrench - np.einsum("nfp,np->nf", at.by_parameters, drawn)
    gain = 1 - np.exp(-FILTER_RATE * 0.15)
    assert row.curvature == pytest.approx(gain**2 * np.cov(missed.T), rel=0.05, abs=1e-9)
    assert row.curvature[0, 0] == pytest.approx((gain * 4.0 * 9.81) ** 2 * (2 * 0.004**2 + 0.005**2), rel=0.02)
    assert straight.residual - row.residual == pytest.approx(gain * missed.mean(axis=0), rel=0.05, abs=1e-9)
    assert (straight.residual - row.residual)[0] == pytest.approx(-gain * 4.0 * 9.81 * 0.004, rel=0.02)


def drawn_rows(n, random, noise_of_velocity=0.1, scale=1.0, around=lambda: 4.0, force_noise=0.3, is_naive=False):
    """Of a mass of 5 pushed by itself, around what is believed: rises of a velocity that is sensed, and a force."""
    fade = 0.7
    rises, errors = scale * random.standard_normal(n), noise_of_velocity * random.standard_normal(n + 1)
    forces = 5.0 * FILTER_RATE * rises + force_noise * random.standard_normal(n)
    variance, noise = np.array([[noise_of_velocity**2]]), np.array([[force_noise**2]])
    for k in range(n):
        at, rise = around(), FILTER_RATE * (rises[k] + errors[k + 1] - fade * errors[k])
        yield FilteredRow(
            residual=np.array([forces[k] - at * rise]),
            slopes=np.array([[rise, 0.0]]),
            ends=np.array([[-FILTER_RATE * at]]),
            fade=fade,
            noise=noise,
            before=variance,
            after=variance,
            shared=2.0 / 9.0 * noise,
            curvature=np.zeros((1, 1)),
            by_rise=np.full((1, 1, 1), 0.0 if is_naive else 1.0),
            quieter=np.zeros((1, 1)),
            of_wrenches=noise,
            of_delay=np.zeros((2, 1, 1)),
            bent_by_delay=np.zeros(1),
        )


def taught(*arguments, first=4.0):
    """What is believed after drawn rows, each worked out around what was believed before it."""
    found = belief(first)

    def mean():
        return float(found.parameters.mean[0])

    for row in drawn_rows(*arguments[:4], mean, *arguments[4:]):
        found.update(row, np.array([mean()]))
    return found.parameters


def belief(first=4.0):
    return RegressionBelief(
        np.array([0]),
        Gaussian(np.array([first]), np.array([[4.0]])),
        1,
        np.zeros(1),
        MassProducts(NONE, 0.0, np.zeros(0)),
    )


@pytest.mark.long
def test_rows_add_up_to_generalised_least_squares(monkeypatch):
    """Neighbours share an end, and noise: their covariance written out, and inverted at once."""
    monkeypatch.setattr(regression_belief, "ROW_FORGETTING_FACTOR", 1.0)
    rows, found = list(drawn_rows(30, np.random.default_rng(1), is_naive=True)), belief()
    for row in rows:
        found.update(row, np.array([4.0]))
    L = np.zeros((30, 31))
    for k in range(30):
        L[k, k], L[k, k + 1] = 0.7 * 8.0, -8.0
    covariance = 0.09 * np.eye(30) + 0.02 * (np.eye(30, k=1) + np.eye(30, k=-1)) + 0.01 * L @ L.T
    H = np.array([row.slopes[0, 0] for row in rows])
    value = np.array([row.residual[0] + 4.0 * row.slopes[0, 0] for row in rows])
    information = 0.25 + H @ np.linalg.solve(covariance, H)
    assert 1 / found.parameters.covariance[0, 0] == pytest.approx(information, rel=1e-9)
    pull = 0.25 * 4.0 + H @ np.linalg.solve(covariance, value)
    assert found.parameters.mean[0] == pytest.approx(pull / information, rel=1e-9)


@pytest.mark.parametrize("force_noise", [0.003, 0.3, 3.0])
def test_noise_in_the_regressors_does_not_make_light(force_noise):
    """Of a seventh of the motion: light by percents, were it taken as it is."""
    naive, mass = (
        taught(3000, np.random.default_rng(2), 0.15, 1.0, force_noise, is_naive) for is_naive in (True, False)
    )
    assert 5.0 - naive.mean[0] > 0.05
    assert abs(mass.mean[0] - 5.0) < 2.5 * mass.covariance[0, 0] ** 0.5


@pytest.mark.some(4)
@pytest.mark.parametrize("first", [2.5, 5.0, 8.0])
@pytest.mark.parametrize("force_noise", [0.03, 0.3, 3.0])
def test_motion_that_hardly_stands_out_of_its_noise_is_unbiased(force_noise, first):
    """As loud as its noise, from guesses that are far off: over seeds, as far off as is said."""
    found = [taught(60, np.random.default_rng(seed), 0.5, 0.5, force_noise, first=first) for seed in range(40)]
    z = np.array([(mass.mean[0] - 5.0) / mass.covariance[0, 0] ** 0.5 for mass in found])
    assert abs(z.mean()) < 0.9
    assert np.sqrt((z**2).mean()) < 1.5


@pytest.mark.parametrize(("force_noise", "least"), [(0.003, 1.5), (0.3, 1.9)])
def test_noise_alone_teaches_next_to_nothing(force_noise, least):
    """Most of the first deviation, 2, is left, in the median of 20 draws."""
    found = [taught(30, np.random.default_rng(seed), 0.03, 0.0, force_noise) for seed in range(20)]
    assert np.median([mass.covariance[0, 0] ** 0.5 for mass in found]) > least
    assert np.mean([(mass.mean[0] - 4.0) ** 2 / mass.covariance[0, 0] for mass in found]) < 2.5


def test_only_what_is_excited_is_forgotten():
    """Two masses, of which rows ask one: it is never surer than its memory allows, the other stays as sure."""
    found = RegressionBelief(
        np.arange(2),
        Gaussian(np.array([4.0, 4.0]), 4.0 * np.eye(2)),
        1,
        np.zeros(2),
        MassProducts(NONE, 0.0, np.zeros(0)),
    )
    one = next(drawn_rows(1, np.random.default_rng(4)))
    for asked, times in ((1, 50), (0, 4000)):
        slopes = np.zeros((1, 3))
        slopes[0, asked] = 1.0
        row = one._replace(slopes=slopes, residual=np.zeros(1), by_rise=np.zeros((1, 1, 2)))
        found.drop_link()
        before = found.parameters.covariance[1, 1] ** 0.5
        for _ in range(times):
            found.update(row, np.array([4.0, 4.0]))
    own = 0.09 + 1.0 + 0.49
    assert found.parameters.covariance[1, 1] ** 0.5 == pytest.approx(before, rel=1e-6)
    lasting = 1 / (1 - regression_belief.ROW_FORGETTING_FACTOR)
    assert (
        own / (2 * lasting) ** 0.5 > found.parameters.covariance[0, 0] ** 0.5 * own**0.5 > 0.1 * (own / lasting) ** 0.5
    )


# --- runs ----------------------------------------------------------------------------------------------------


def scores(parameters):
    return [(p.value - value) / p.std for p, value in zip(parameters.values(), TRUTH, strict=True)]


def drawn(seed, duration=12.0):
    return simulate(TRUTH, seed, duration, noise=(0.0004, 0.005, 3.0))[0]


@pytest.mark.long
def test_errors_are_as_large_as_they_are_said_to_be():
    z = np.array([scores(learned(drawn(seed, 8.0)).last.parameters) for seed in range(40, 44)])
    assert np.abs(z).max() < 4.0
    assert 0.5 < np.sqrt((z**2).mean()) < 1.5


@pytest.mark.prove
@pytest.mark.parametrize("two", [False, True])
def test_bias_and_coverage_over_20_seeds(two):
    """3 N and 5 mm/s of noise: the mass is unbiased within 0.5 %."""
    logs = [simulate_two_hands(TRUTH, seed) if two else drawn(seed) for seed in range(60, 80)]
    found = [learned(log).last.parameters for log in logs]
    masses = [parameters["mass"].value for parameters in found]
    spread = np.std(masses) / 20**0.5
    assert abs(np.mean(masses) - 24.0) < max(0.005 * 24.0, 2 * spread)
    z = np.array([scores(parameters) for parameters in found])
    assert 0.7 < np.sqrt((z**2).mean()) < 1.3
    assert np.abs(z).max() < 4.5


def test_standstill_teaches_nothing():
    """Noise that moves nothing, with friction and without."""
    for effects in (DRAGS, DRAGS[:1]):
        cart = guess(effects)
        last = learned(at_rest(), cart).last
        assert last.model_parameters == pytest.approx(cart.parameters, abs=1e-9)
        assert not any(p.identifiable for p in last.parameters.values())


def changing(time_of_change, mass, seed):
    """A log of a cart that is loaded on the way, at rest, and then pushed again."""
    before, after = drawn(seed, time_of_change), simulate((mass, *TRUTH[1:]), seed + 100, 6.0, noise=(4e-4, 0.005, 3.0))
    late = after[0]
    return before, replace(late, time=late.time + time_of_change + 1.0)


@pytest.mark.long
@pytest.mark.parametrize("mass", [16.0, 32.0])
def test_a_change_of_load_is_noticed_within_two_seconds(mass):
    before, after = changing(12.0, mass, 5)
    cart = guess()
    estimator = RegressorEstimator(cart, ["hand"], noise=noise_of_log(before, cart))
    first = replay(before, estimator)
    assert {str(e.health) for e in first.estimates} <= {"no_wrench", "ok"}
    second = replay(after, estimator)
    noticed = [e.time for e in second.estimates if e.health == "load_changed"]
    assert noticed
    assert noticed[0] - after.time[0] < 2.0
    found = second.last.parameters["mass"]
    assert abs(found.value - mass) < 0.04 * mass


@pytest.mark.prove
def test_no_false_alarm_in_quiet_runs():
    for seed in range(200, 230):
        healths = {str(e.health) for e in learned(drawn(seed, 30.0)).estimates}
        assert healths <= {"ok", "no_wrench"}


def test_late_wrenches_are_told_from_held_ones():
    """The same push, each wrench recorded a sample late."""
    log = simulate(TRUTH, 6, 12.0, noise=(0.0002, 0.002, 0.2))[0]
    hand = log.arms["hand"]
    late = replace(log, arms={"hand": replace(hand, wrench=np.roll(hand.wrench, 1, axis=0))})
    lateness = []
    for one in (log, late):
        cart = guess()
        estimator = RegressorEstimator(cart, ["hand"], noise=noise_of_log(one, cart))
        replay(one, estimator)
        lateness.append(estimator.lateness)
    assert abs(lateness[0]) < 0.003
    assert lateness[1] - lateness[0] == pytest.approx(0.01, rel=0.2)


def test_what_is_known_stays():
    drag = learned(drawn(3, 3.0), prior=Prior(known=frozenset({"viscous_drag"}))).last.parameters["viscous_drag.linear"]
    assert (drag.value, drag.std, drag.identifiable) == (2.0, 0.0, False)


def test_the_evidence_of_a_load_is_a_ratio_of_likelihoods():
    """Of rows since each moment, stacked: with the load's covariance, or without."""
    random = np.random.default_rng(0)
    root = random.standard_normal((3, 2))
    load, watch, rows = root @ root.T, LoadMonitor(2, 3), []
    for _ in range(5):
        slopes, news, spread = random.standard_normal((2, 3)), random.standard_normal(2), np.diag([0.5, 2.0])
        rows.append((slopes, news, spread))
        asked = np.linalg.solve(spread, slopes).T
        watch.note(
            0.0,
            Innovation(
                1.0, asked @ news, asked @ slopes, np.zeros((3, 3)), *(own := (news, spread, spread)), own, spread
            ),
            root_of(load),
            WrenchNoiseScale(),
        )
    ratios = []
    for first in range(5):
        slopes, news, spreads = (list(part) for part in zip(*rows[first:], strict=True))
        H, r, S = np.vstack(slopes), np.concatenate(news), block_diag(*spreads)
        ratios.append(multivariate_normal.logpdf(r, cov=S + H @ load @ H.T) - multivariate_normal.logpdf(r, cov=S))
    assert watch._evidence(root_of(load)) == pytest.approx(max(ratios), abs=1e-9)
