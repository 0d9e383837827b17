"""Splines: what they reproduce, which penalty they take, and what outliers do."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from estimation.weak_form.splines import Samples, SplineBasis, SplineFit

TIME = 0.01 * np.arange(1001)
BASIS = SplineBasis.over(0.0, 10.0, 0.05)


def sampled(value, std, seed):
    return Samples(TIME, value + std * np.random.default_rng(seed).standard_normal(len(TIME)), std, 0)


@settings(max_examples=20, deadline=None)
@given(coefficients=st.lists(st.floats(-2, 2), min_size=5, max_size=5), with_rate=st.booleans())
def test_polynomials_of_degree_four_come_back(coefficients, with_rate):
    """With their derivatives: unbiased, a penalty of 1e-9 of the data bends them by no more than that."""
    polynomial = np.polynomial.Polynomial(coefficients, domain=[0, 10], window=[-1, 1])
    samples = [Samples(TIME, polynomial(TIME), 1e-3, 0)]
    if with_rate:
        samples.append(Samples(TIME, polynomial.deriv()(TIME), 1e-2, 1))
    fit = SplineFit(BASIS, samples)
    for order, tolerance in ((0, 1e-8), (1, 1e-6), (2, 1e-4)):
        expected = polynomial.deriv(order)(TIME) if order else polynomial(TIME)
        assert BASIS.design(TIME, order) @ fit.unbiased == pytest.approx(expected, abs=tolerance)


def test_slopes_of_the_basis_are_differences_of_it():
    inside = np.linspace(0.3, 9.7, 200)
    for order in (1, 2):
        lower = BASIS.design(inside + 1e-5, order - 1) - BASIS.design(inside - 1e-5, order - 1)
        assert BASIS.design(inside, order).toarray() == pytest.approx(lower.toarray() / 2e-5, abs=2e-4 / 0.05**order)


def test_what_has_nothing_but_noise_is_smoothed_to_a_parabola():
    """Ten seconds of white noise about a constant acceleration: the smooth fit is off by what a parabola's three
    coefficients are, sqrt(3 / n) of the noise, up to a few more that chance makes likely."""
    std = 0.02
    true = 1.0 + 0.3 * TIME - 0.1 * TIME**2
    fits = [SplineFit(BASIS, [sampled(true, std, seed)]) for seed in range(5)]
    at = BASIS.design(TIME)
    off = [np.sqrt(np.mean((at @ fit.smooth - true) ** 2)) for fit in fits]
    assert np.mean(off) < 1.6 * std * (3 / len(TIME)) ** 0.5
    rough = [np.sqrt(np.mean((at @ fit.unbiased - true) ** 2)) for fit in fits]
    assert np.mean(rough) == pytest.approx(std * (BASIS.count / len(TIME)) ** 0.5, rel=0.15)


@pytest.mark.parametrize("std", [1e-3, 1e-2])
def test_the_penalty_follows_signal_and_noise(std):
    """A sine is kept, and errors of the fit and its rate are as large as `smooth_std` says."""
    true, rate = 0.3 * np.sin(2 * TIME), 0.6 * np.cos(2 * TIME)
    fits = [SplineFit(BASIS, [sampled(true, std, seed)]) for seed in range(20)]
    middle = slice(300, 701, 20)
    for order, expected in ((0, true), (1, rate)):
        at = BASIS.design(TIME[middle], order)
        off = np.array([at @ fit.smooth - expected[middle] for fit in fits])
        told = np.mean([fit.smooth_std(5.0, order) for fit in fits])
        assert 0.6 < np.sqrt(np.mean(off**2)) / told < 1.3


def test_outliers_count_for_little():
    """One sample in fifty is off by 50 deviations: the fit errs no more than half as much again."""
    true, std = 0.3 * np.sin(2 * TIME), 1e-3
    clean = sampled(true, std, 0)
    value = clean.value.copy()
    value[25::50] += 50 * std
    spoiled = SplineFit(BASIS, [Samples(TIME, value, std, 0)])
    at = BASIS.design(TIME)
    off = np.sqrt(np.mean((at @ spoiled.smooth - true) ** 2))
    assert off < 1.5 * np.sqrt(np.mean((at @ SplineFit(BASIS, [clean]).smooth - true) ** 2))


def test_gaps_are_bridged():
    """Without samples for half a second, what a parabola does goes on."""
    true = 0.2 * TIME - 0.05 * TIME**2
    kept = (TIME < 4.0) | (TIME > 4.5)
    fit = SplineFit(BASIS, [Samples(TIME[kept], true[kept], 1e-4, 0)])
    assert BASIS.design(TIME) @ fit.unbiased == pytest.approx(true, abs=1e-6)
    assert BASIS.design(TIME) @ fit.smooth == pytest.approx(true, abs=1e-6)


@pytest.mark.parametrize("std", [1e-3, 1e-2, 0.1, 1.0])
def test_what_stands_still_stays_where_coarse_places_say(std):
    """As a ranger shows it, in steps that hide all noise. Rates of nought, up to 10**8 times as heavy, say nothing of
    where it is, and the penalty that is likeliest is as stiff as can be."""
    time = 0.01 * np.arange(3201)
    basis = SplineBasis.over(0.0, 32.0, 0.05)
    place, rate = Samples(time, np.full(3201, 0.7), std, 0), Samples(time, np.zeros(3201), 1e-4, 1)
    fit = SplineFit(basis, [place, rate])
    for found in (fit.smooth, fit.unbiased):
        assert basis.design(time) @ found == pytest.approx(0.7, abs=0.01 * std)


@pytest.mark.some(3)
@pytest.mark.long
@pytest.mark.parametrize("with_rate", [False, True])
@pytest.mark.parametrize("gap", [60.0, 600.0, 6000.0])
def test_a_gap_is_as_two_logs(gap, with_rate):
    """In the middle of each half, five seconds from all ends, the fit is the half's own, and errs as it does."""
    std, value, rate = 1e-3, [], []
    times = TIME, TIME + 10.0 + gap
    for seed, time in enumerate(times):
        random = np.random.default_rng(seed)
        value.append(Samples(time, 0.3 * np.sin(2 * time) + std * random.standard_normal(len(time)), std, 0))
        rate.append(Samples(time, 0.6 * np.cos(2 * time) + std * random.standard_normal(len(time)), std, 1))
    kinds = (value, rate) if with_rate else (value,)
    whole = SplineBasis.over(0.0, 20.0 + gap, 0.05)
    both = SplineFit(whole, [_joined(kind) for kind in kinds])
    for i, time in enumerate(times):
        alone = SplineBasis.over(time[0], time[-1], 0.05)
        own, middle = SplineFit(alone, [kind[i] for kind in kinds]), time[500:501]
        for found, expected in ((both.smooth, own.smooth), (both.unbiased, own.unbiased)):
            assert whole.design(middle) @ found == pytest.approx(alone.design(middle) @ expected, abs=0.5 * std)
    seen = whole.design(np.concatenate(times)) @ both.smooth
    assert np.sqrt(np.mean((seen - 0.3 * np.sin(2 * np.concatenate(times))) ** 2)) < 0.4 * std


def _joined(parts):
    one = parts[0]
    time, value = (np.concatenate([getattr(part, name) for part in parts]) for name in ("time", "value"))
    return Samples(time, value, one.std, one.derivative)
