"""Steps of the filters' kernels against matrix algebra, matrix exponentials, and the batch solution."""

import numpy as np
import pytest
import scipy.linalg
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from cartgrasp.effects import CasterRealignment, RollingResistance, ViscousDrag
from cartgrasp.inertia import Inertia
from cartgrasp.model import CartModel
from cartgrasp.motion import Measurement
from cartgrasp.wheels import Wheel
from estimation import FilterNoise, Prior
from estimation.online.kernels import correction
from estimation.online.kernels.tracked_motion import MIN_PATH_STD
from estimation.online.measured_motion import MeasuredMotion
from estimation.online.regressor.motion_tracker import MotionTracker
from estimation.online.schmidt_filter import SchmidtFilter
from tests.kernels_called import called

numbers = st.floats(-3, 3, allow_nan=False, allow_infinity=False)
seeds = st.integers(0, 2**32 - 1)
ROOM = 200


eliminated = called(correction.eliminate)


def covariance_of(root):
    return root @ root.T + 0.01 * np.eye(len(root))


@given(hnp.arrays(float, (5, 5), elements=numbers), hnp.arrays(float, (5, 3), elements=numbers))
def test_elimination_solves(root, right):
    matrix = covariance_of(root)[::-1].copy()  # no large numbers on the diagonal: pivots are needed
    expected = np.linalg.solve(matrix, right)
    solved = right.copy()
    eliminated(matrix.copy(), solved)
    np.testing.assert_allclose(matrix @ solved, right, atol=1e-7 * (1 + np.abs(expected).max()))


@pytest.mark.long
@given(seeds, st.integers(1, 3))
def test_a_correction_is_conditioning_that_leaves_the_parameters(seed, m):
    """The gain that is best for all that is uncertain, and the covariance of whatever gain: both by whole matrices."""
    random = np.random.default_rng(seed)
    n, f = 6, 3
    own, beside = (covariance_of(random.standard_normal((k, k))) for k in (n, f))
    R, slopes, mean = covariance_of(random.standard_normal((m, m))), random.standard_normal((n, f)), np.zeros(n)
    first, residual = int(random.integers(n - m)), random.standard_normal(m)
    H = np.eye(n)[first : first + m]
    whole = own + slopes @ beside @ slopes.T
    S = H @ whole @ H.T + R
    gain = np.linalg.solve(S, H @ whole).T
    keep = np.eye(n) - gain @ H
    got = correction.Believed(mean.copy(), own.copy(), slopes.copy(), beside)
    nis = called(correction.correct)(got, (first, m), residual, R, np.empty(ROOM))
    assert nis == pytest.approx(residual @ np.linalg.solve(S, residual), rel=1e-6)
    np.testing.assert_allclose(got.mean, gain @ residual, rtol=1e-6, atol=1e-8)
    np.testing.assert_allclose(got.own, keep @ own @ keep.T + gain @ R @ gain.T, rtol=1e-6, atol=1e-7)
    np.testing.assert_allclose(got.slopes, keep @ slopes, rtol=1e-6, atol=1e-8)


@pytest.mark.long
@given(seeds, st.sets(st.integers(0, 2), max_size=2))
def test_numbers_that_are_missing_say_nothing(seed, missing):
    """As if there were no such rows."""
    random = np.random.default_rng(seed)
    own, pose, variance = covariance_of(random.standard_normal((5, 5))), random.normal(0, 0.3, 3), np.full(3, 0.01)
    seen = sorted({0, 1, 2} - missing)
    H, R = np.eye(5)[seen], 0.01 * np.eye(len(seen))
    S = H @ own @ H.T + R
    gain = np.linalg.solve(S, H @ own).T
    got = correction.Believed(np.zeros(5), own.copy(), np.zeros((5, 0)), np.zeros((0, 0)))
    told = np.where(np.isin(range(3), seen), pose, np.nan)
    nis = called(correction.take_pose)(got, told, variance, np.empty(ROOM))
    assert nis == pytest.approx(pose[seen] @ np.linalg.solve(S, pose[seen]), rel=1e-6)
    np.testing.assert_allclose(got.mean, gain @ pose[seen], rtol=1e-6, atol=1e-8)
    np.testing.assert_allclose(got.own, own - gain @ H @ own, rtol=1e-6, atol=1e-7)


def test_an_outlier_pulls_but_can_not_tear():
    got = correction.Believed(np.zeros(3), np.eye(3), np.zeros((3, 1)), np.zeros((1, 1)))
    nis = called(correction.correct)(got, (0, 1), np.array([1e4]), np.array([[0.01]]), np.empty(ROOM))
    assert nis == pytest.approx(1e8 / 1.01, rel=1e-6)
    assert 0 < got.mean[0] < 1e4
    assert got.own[0, 0] > 0.9, "it teaches nearly nothing"


CART = CartModel(
    Inertia(24.0, (0.3, 0.05), 2.0),
    effects=(ViscousDrag(3.0, 1.2), RollingResistance(0.02), CasterRealignment(0.05)),
    wheels=(Wheel("fixed", 0.0, 0.3), Wheel("fixed", 0.0, -0.3), Wheel("caster", 0.7, 0.0, 0.05)),
)
QUIET = FilterNoise(disturbance=0.0, slip=0.0, swivel=0.0)


def pushed(motion, wrench, covariance):
    """From now on."""
    motion.advance(motion.time, felt=np.concatenate([[motion.time], wrench, np.ravel(covariance)]))


def started(noise=QUIET, free=None, cart=CART):
    motion = SchmidtFilter(cart, noise, np.arange(len(cart.parameters)) if free is None else free)
    motion.start(0.0, np.array([0.2, -0.1, 0.4]))
    motion.now.mean[cart.velocity_slice] = 0.6, 0.3
    motion.now.own[:] = 0.0
    return motion


def test_the_mean_moves_as_the_model_does():
    """Against fourth-order steps a hundredth as long."""
    motion = started()
    pushed(motion, [30.0, 4.0], np.zeros((2, 2)))
    state = motion.belief.mean
    for k in range(10):
        pushed(motion, [30.0, 4.0], np.zeros((2, 2)))
        motion.advance(0.01 * (k + 1))
    expected = CART.dynamics.advanced(
        (state, 0.0, CART.parameters), CART.planar_wrench(np.array([30.0, 4.0])), 1e-4, 1000
    )
    np.testing.assert_allclose(motion.belief.mean[:5], expected[:5], atol=5e-6)
    assert motion.belief.mean[5] == pytest.approx(expected[5], abs=5e-4), "of second order, with 0.06 of a rate a step"


def test_slopes_by_the_parameters_are_differences():
    """Of the motion that other parameters would have made; partials that change within a step leave a per cent or two
    (and more of a caster's heading)."""

    def moved(theta):
        motion = started()
        motion.now.theta[:] = theta
        for k in range(20):
            pushed(motion, [30.0 - k, 4.0], np.zeros((2, 2)))
            motion.advance(0.01 * (k + 1))
        return motion

    motion = moved(CART.parameters)
    for i in Prior().free(CART):
        step = 1e-4 * max(abs(CART.parameters[i]), 0.01) * np.eye(len(CART.parameters))[i]
        difference = (moved(CART.parameters + step).now.mean - moved(CART.parameters - step).now.mean) / (
            2 * step.sum()
        )
        error = motion.now.slopes[:5, i] - difference[:5]
        assert np.linalg.norm(error) < 0.02 * np.linalg.norm(difference[:5])


@given(seeds, st.sampled_from([0.0, np.pi - 0.3]))
def test_effects_without_kernels_go_the_same_way(seed, turned):
    """The rate from within a kernel, or from the model; of a caster that is poised until it topples, too."""
    random = np.random.default_rng(seed)
    motions = started(FilterNoise()), started(FilterNoise())
    assert motions[0]._in_kernels
    motions[1]._in_kernels = False
    for motion in motions:
        motion.now.mean[5] = turned
    for k in range(20):
        wrench, pose, velocity = random.normal(0, [10.0, 3.0]), random.normal(0, 0.1, 3), random.normal(0, 0.1, 3)
        for motion in motions:
            if k % 13:
                pushed(motion, wrench, np.diag([3.0, 1.0]))
            seen = {"pose": pose} if k % 3 == 0 else {"velocity": velocity}
            motion.advance(0.013 * (k + 1) + 0.2 * (k // 10), MeasuredMotion().of(Measurement(0.0, **seen)))
    for found, expected in zip(motions[0].now[:-1], motions[1].now[:-1], strict=True):  # without the room
        np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-12)


def test_wrench_noise_spreads_as_many_runs_do():
    """Standard deviations of the motion against 400 runs of the model under wrenches with that noise."""
    cart = CART.without_effect("rolling_resistance").without_effect("caster_realignment")
    noise, random = np.diag([3.0, 0.5]) ** 2, np.random.default_rng(0)
    motion = started(cart=cart)
    for k in range(30):
        pushed(motion, [30.0, 2.0], noise)
        motion.now.pushed[1] = motion.time - 0.01
        motion.advance(0.01 * (k + 1))
    states, theta = np.tile(started(cart=cart).belief.mean, (400, 1)), np.tile(cart.parameters, (400, 1))
    for _ in range(30):
        given = np.array([30.0, 2.0]) + random.standard_normal((400, 2)) @ np.sqrt(noise)
        push = cart.planar_wrench(given)
        states = cart.dynamics.advanced((states, np.zeros(400), theta), push, 0.01, 1)
    np.testing.assert_allclose(np.diag(motion.belief.covariance) ** 0.5, states.std(axis=0), rtol=0.12)


def test_a_stiff_decay_stays_a_decay():
    cart = CartModel(Inertia(1.0, (0.3, 0.0), 0.2), effects=(ViscousDrag(5000.0, 5000.0),))
    motion = started(cart=cart)
    before = np.abs(motion.belief.mean[3:5])
    for k in range(50):
        motion.advance(0.01 * (k + 1))
        after = np.abs(motion.belief.mean[3:5])
        assert (after <= before).all()
        before = after


def test_densities_add_up_as_van_loan_says():
    """A linear cart: the covariance after many steps against the integral of exponentials."""
    cart = CartModel(Inertia(10.0, (0.0, 0.0), 1.0), effects=(ViscousDrag(3.0, 1.2),))
    noise = FilterNoise(disturbance=0.4, slip=0.0)
    motion = SchmidtFilter(cart, noise, np.arange(0))
    motion.start(0.0, np.zeros(3))
    motion.now.own[:] = 0.0
    for k in range(100):
        pushed(motion, [0.0, 0.0], np.zeros((2, 2)))
        motion.advance(0.01 * (k + 1))
    F, Q = np.zeros((2, 2)), np.diag([0.0, (0.4 / 10) ** 2])
    F[0, 1], F[1, 1] = 1.0, -0.3
    block = scipy.linalg.expm(np.block([[-F, Q], [np.zeros((2, 2)), F.T]]))
    expected = block[2:, 2:].T @ block[:2, 2:]
    found = motion.belief.covariance[np.ix_([0, 3], [0, 3])]
    np.testing.assert_allclose(found, expected, rtol=1e-3)


UNFELT = np.zeros(0), np.zeros((2, 2)), np.zeros(2 * 4 + 4 + 4)  # no wrenches, of a cart with four parameters


def smoothed(tracker, weights, moments=7):
    """By so many moments at once."""
    smoothing = tracker.smoothing(weights)
    while smoothing.left:
        smoothing = tracker.smoothed_on(smoothing, moments)
    return smoothing.smoothed


def test_tracking_and_smoothing_are_the_batch_solution():
    """Straight ahead all is linear: least squares over all states at once give the same means and covariances."""
    random = np.random.default_rng(1)
    cart, noise = CartModel(Inertia(10.0, (0.0, 0.0), 1.0)), FilterNoise(position=0.001, heading=1e-9, slip=0.0)
    tracker = MotionTracker(cart, noise)
    tracker.start(0.0, np.zeros(3))
    x = np.cumsum(np.full(30, 0.005)) + 0.001 * random.standard_normal(30)
    for k in range(30):
        tracker.record(0.01 * (k + 1), np.array([x[k], 0.0, 0.0, np.nan, np.nan, np.nan]), *UNFELT)
    weights = np.concatenate([random.standard_normal((2, 20)), np.zeros((2, 3))], axis=1)
    found = smoothed(tracker, weights), smoothed(tracker, np.zeros((1, 31)))
    n, h, jerk = 31, 0.01, 9.0
    block = np.array([[h**5 / 20, h**4 / 8, h**3 / 6], [h**4 / 8, h**3 / 3, h**2 / 2], [h**3 / 6, h**2 / 2, h]]) * jerk
    block[0, 0] += MIN_PATH_STD**2
    forth = np.array([[1, h, h * h / 2], [0, 1, h], [0, 0, 1]])
    information, pull = np.zeros((3 * n, 3 * n)), np.zeros(3 * n)
    information[:3, :3] = np.diag(1 / (np.array([0.001**2, 1.0, 9.0]) + 1e-10))
    for k in range(30):
        row = np.zeros((3, 3 * n))
        row[:, 3 * k : 3 * k + 3], row[:, 3 * k + 3 : 3 * k + 6] = -forth, np.eye(3)
        information += row.T @ np.linalg.solve(block, row)
        i = 3 * (k + 1)
        information[i, i] += 1 / (0.001**2 + correction.MIN_ROW_VARIANCE)
        pull[i] += x[k] / (0.001**2 + correction.MIN_ROW_VARIANCE)
    covariance = np.linalg.inv(information)
    mean = (covariance @ pull).reshape(n, 3)
    np.testing.assert_allclose(found[1].pose[:, 0], mean[:, 0], atol=1e-6)
    np.testing.assert_allclose(found[1].velocity[:, 0], mean[:, 1], atol=1e-5)
    np.testing.assert_allclose(found[1].acceleration[:, 0], mean[:, 2], atol=1e-3)
    np.testing.assert_allclose(np.sqrt(found[1].covariance[:, 0, 0]), np.sqrt(np.diag(covariance)[1::3]), rtol=1e-3)
    for sums, weight in zip(found[0].of_sums, weights, strict=True):
        spread = weight @ covariance[1:69:3, 1:69:3] @ weight
        np.testing.assert_allclose(sums[0, 0], spread, rtol=1e-3)


def test_a_tracker_makes_room_and_forgets():
    tracker = MotionTracker(CartModel(Inertia(10.0, (0.0, 0.0), 1.0)), FilterNoise())
    tracker.start(0.0, np.zeros(3))
    for k in range(200):
        tracker.record(0.01 * (k + 1), np.array([0.005 * (k + 1), 0.0, 0.0, 0.5, 0.0, 0.0]), *UNFELT)
    whole = smoothed(tracker, np.zeros((1, 201)), 60)
    tracker.drop(150)
    kept = smoothed(tracker, np.zeros((1, 51)))
    assert len(kept.time) == 51
    np.testing.assert_allclose(kept.pose, whole.pose[150:], atol=1e-12)
    np.testing.assert_allclose(kept.covariance, whole.covariance[150:], atol=1e-15)
