"""Fits beside a known motion, against a truth that jumps, and their noise against that of many draws."""

import numpy as np
import pytest

from estimation.weak_form.splines import PoseFits, Samples, SplineBasis, SplineFit

TIME = 0.01 * np.arange(1001)
BASIS = SplineBasis.over(0.0, 10.0, 0.05)
POSE_STD, RATE_STD = 5e-4, 5e-3
ACCELERATION = np.sign(np.sin(2 * np.pi * 1.7 * TIME + 0.3))
RATE = np.cumsum(ACCELERATION) * 0.01
POSE = 0.01 * (np.cumsum(RATE) - (RATE + RATE[0]) / 2)
"""Of one coordinate, whose acceleration jumps from 1 to -1 and back. Trapezoids of the rate are the pose."""


def fits(seed):
    """Of three coordinates alike, with noise of their own."""
    random, found = np.random.default_rng(seed), []
    for _ in range(3):
        pose = Samples(TIME, POSE + POSE_STD * random.standard_normal(len(TIME)), POSE_STD, 0)
        rate = Samples(TIME, RATE + RATE_STD * random.standard_normal(len(TIME)), RATE_STD, 1)
        found.append(SplineFit(BASIS, [pose, rate]))
    return PoseFits(tuple(found), TIME, BASIS.design(TIME), BASIS.design(TIME, 1))


def rms(error):
    return float(np.sqrt(np.mean(error**2)))


@pytest.mark.parametrize("drift", [0.0, 0.02, 0.4])
def test_what_jumps_is_kept_where_it_is_known(drift):
    """A known motion that is off by a constant acceleration, of 20 m in the end, is as good: that is smooth."""
    own, known = fits(0), np.tile((RATE - drift * TIME)[:, None], 3)
    pose, rate, penalties = own.beside(known)
    smooth = [BASIS.design(TIME, order) @ fit.smooth for fit in own.fits for order in (0, 1)]
    assert rms(rate - RATE[:, None]) < 0.1 * rms(np.array(smooth[1::2]) - RATE)
    assert rms(pose - POSE[:, None]) < 0.5 * rms(np.array(smooth[::2]) - POSE)
    assert (penalties > 0.0).all()


def test_what_is_not_known_is_followed_as_without():
    own = fits(1)
    pose, rate, _ = own.beside(np.zeros((len(TIME), 3)))
    for k, fit in enumerate(own.fits):
        smooth = fit.basis.design(TIME, 1) @ fit.smooth
        assert rms(rate[:, k] - RATE) == pytest.approx(rms(smooth - RATE), rel=0.02)
        assert rms(pose[:, k] - POSE) < 3 * POSE_STD


@pytest.mark.parametrize("wrong", [0.0, 0.02, 0.4])
def test_noise_is_what_draws_of_it_do(wrong):
    """Errors against the truth over many draws, with errors of what is known beside: white of an acceleration."""
    true, told = [], []
    for seed in range(12):
        random, own = np.random.default_rng(100 + seed), fits(seed)
        errors = np.cumsum(wrong * random.standard_normal((len(TIME), 3)), axis=0)
        pose, rate, penalties = own.beside(RATE[:, None] + errors)
        true.append([pose - POSE[:, None], rate - RATE[:, None]])
        fresh = np.cumsum(wrong * random.standard_normal((len(TIME), 3)), axis=0)
        told.append(own.noise_beside(fresh, penalties, random))
    for order in (0, 1):
        assert rms(np.array(told)[:, order]) == pytest.approx(rms(np.array(true)[:, order]), rel=0.25)
