"""Wrenches that are recorded late, online: as if they had come in time, and that much later."""

from dataclasses import replace

import numpy as np
import pytest

from cartgrasp.effects import RollingResistance, TimeDelay, ViscousDrag
from cartgrasp.inertia import Inertia
from cartgrasp.model import CartModel
from cartgrasp.motion import Measurement
from cartgrasp.studies.shopping_cart import scenario
from estimation import CartFilter, DisturbedFilter, FilterNoise

from ..runs import simulate_two_hands

NOISE = FilterNoise(0.0005, 0.0005, 0.005, 0.005, 3.0, 0.15)
HANDS = ("left", "right")
LATE = {"left": 7, "right": 3}
"""Samples."""
TRUTH = (24.0, 0.28, 0.06, 2.2, 3.0, 1.2, 0.0)
GUESS = CartModel(Inertia(20.0, (0.3, 0.0), 1.8), effects=(ViscousDrag(linear=3.0, angular=1.2),))


def in_time(noise=NOISE):
    sigmas = noise.position, noise.linear_velocity, noise.force
    return list(simulate_two_hands(TRUTH, 0, 8.0, sigmas).measurements())


def recorded(samples, late):
    """As sensors record them that are so many samples late, by arm."""
    for k, sample in enumerate(samples):
        felt = {arm: samples[k - n].wrenches[arm] if k >= n else np.zeros(6) for arm, n in late.items()}
        yield replace(sample, wrenches=felt)


def knowing(late):
    cart = GUESS
    for arm, n in late.items():
        cart = cart.with_effect(TimeDelay(0.01 * n, label=arm))
    return cart


@pytest.mark.parametrize("noise", [NOISE, replace(NOISE, force=0.02, moment=0.001)], ids=["noisy", "exact"])
def test_parameters_are_as_if_in_time_and_that_much_behind(noise):
    samples = in_time(noise)
    plain, late = CartFilter(GUESS, HANDS, noise=noise), CartFilter(knowing(LATE), HANDS, noise=noise)
    expected = [plain.update(sample).model_parameters for sample in samples]
    for k, sample in enumerate(recorded(samples, LATE)):
        found = late.update(sample)
        if k > 20:  # from when on the first wrench of both hands is known
            np.testing.assert_allclose(found.model_parameters[:6], expected[k - 7], rtol=0.02, atol=0.02)
    assert np.abs(expected[-1] - GUESS.parameters).max() > 1.0


def test_the_motion_is_not_behind():
    """Against the truth, to within what the filter says of it."""
    log, late = simulate_two_hands(TRUTH, 1, 8.0), {"left": 5, "right": 5}
    samples = list(log.measurements())
    estimator = CartFilter(knowing(late), HANDS, noise=NOISE)
    squares = []
    for sample in recorded(samples, late):
        estimate = estimator.update(sample)
        assert estimate.time == sample.time
        if sample.time > 1.0:
            off = sample.pose - estimate.motion.pose_sb
            squares.append(off**2 / (np.diagonal(estimator.belief.covariance)[:3] + 0.0005**2))
    assert np.mean(squares) < 1.3


def test_late_and_missing_samples_go_on():
    samples, estimator = list(recorded(in_time(), LATE)), CartFilter(knowing(LATE), HANDS, noise=NOISE)
    for k, sample in enumerate(samples[:600]):
        told = Measurement(sample.time, wrenches=sample.wrenches) if k % 50 == 0 else sample
        estimate = estimator.update(samples[k - 9] if k % 40 == 39 else told)
    assert estimate.health == "ok"
    assert estimate.parameters["mass"].value == pytest.approx(24.0, abs=4 * estimate.parameters["mass"].std)


@pytest.mark.long
@pytest.mark.some(1)
@pytest.mark.parametrize("delay", [0.055, 0.12])
def test_a_closed_loop_learns_the_mass(delay):
    """Of sensors that are late, and a filter that is told so, or learns it."""
    effects = ViscousDrag(linear=2.0, angular=0.4), RollingResistance(coefficient=0.015)
    truth = CartModel(Inertia(29.7, (0.36, 0.05), 2.6), effects=(*effects, TimeDelay(delay)))
    guess = CartModel(Inertia(20.0, (0.3, 0.0), 2.0), effects=effects)
    made = scenario(quick=True, plant="model")
    no_casters = replace(made.noise, disturbance=0.1, lever=0.3)
    made = replace(made, truth=truth, duration=8.0, contacts="fixed", noise=no_casters)
    for believed in (guess.with_effect(TimeDelay(delay)), guess):
        mass = replace(made, guess=believed).run().parameters["mass"]
        assert abs(mass.value[-1] - 29.7) < 3 * mass.std[-1]
        assert mass.std[-1] < 0.6


def test_arms_may_come_in_samples_of_their_own():
    """The other arm's sample had been the nearest one, and the arm's own left out: nothing was ever learned."""
    late, told = {"left": 5, "right": 5}, []
    for is_split in (False, True):
        estimator = CartFilter(knowing(late), HANDS, noise=NOISE)
        for sample in list(recorded(in_time(), late))[:400]:
            if is_split:
                estimator.update(replace(sample, wrenches={"left": sample.wrenches["left"]}))
                estimator.update(Measurement(sample.time, wrenches={"right": sample.wrenches["right"]}))
            else:
                estimator.update(sample)
        told.append(estimator.estimate)
    together, split = told
    assert split.health == together.health == "ok"
    assert split.parameters["mass"].value == pytest.approx(together.parameters["mass"].value, rel=1e-6)


def test_late_wrenches_are_no_push():
    """The observers had taken them as of now: a disturbance acted in an eighth of the samples, and less was learned."""
    samples, late = in_time()[:400], {"left": 12, "right": 12}
    plain, behind = DisturbedFilter(GUESS, HANDS, noise=NOISE), DisturbedFilter(knowing(late), HANDS, noise=NOISE)
    told = [
        (plain.update(sample), behind.update(other))
        for sample, other in zip(samples, recorded(samples, late), strict=True)
    ]
    assert not any(one.disturbance is not None and one.disturbance.acts for pair in told for one in pair)
    now, then = told[-1][1], told[-13][0]
    assert now.time == told[-1][0].time
    assert now.parameters["mass"].value == pytest.approx(
        then.parameters["mass"].value, abs=0.1 * then.parameters["mass"].std
    )
    speeds = np.array([[pair[0].motion.velocity, pair[1].motion.velocity] for pair in told[100:]])
    assert np.abs(speeds[:, 0] - speeds[:, 1]).max() < 0.05
