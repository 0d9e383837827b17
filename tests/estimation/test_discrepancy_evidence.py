"""Bayes factors against Gaussian densities written out, and gates against masks tried one by one."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import multivariate_normal

from cartgrasp.effects import ExternalPush, FloorPatch, FloorSlope, PayloadChange, RollingResistance
from estimation.discrepancy.dictionary import Dictionary, Grid, Trial
from estimation.discrepancy.evidence import LENGTHS, Base, findings

SEEDS = st.integers(0, 2**32 - 1)
PRIOR = np.array([0.5, 2.0, 1.0])
"""Standard deviations of a base of three parameters."""


def drawn(seed, n_blocks, n_columns, rows=6):
    """White residuals (blocks, rows), base columns and trial columns."""
    random = np.random.default_rng(seed)
    base = random.standard_normal((n_blocks, rows, 3))
    columns = random.standard_normal((n_blocks, rows, n_columns))
    residual = random.standard_normal((n_blocks, rows)) + columns[..., 0]
    return base, columns, residual


def dictionary(base, columns, residual, trials, grid=None):
    sides = np.concatenate([base, columns, residual[..., None]], axis=2)
    gram = np.swapaxes(sides, 1, 2) @ sides
    n, places = len(gram), gram.sum(axis=0)[3:-1]
    return Dictionary(tuple(trials), grid, gram, places, np.arange(n) * 0.25, np.zeros(n, dtype=int), 3)


def density(residual, base, columns, std, excess=1.0):
    covariance = excess * np.eye(residual.size) + base.reshape(-1, 3) @ np.diag(PRIOR**2) @ base.reshape(-1, 3).T
    if columns is not None:
        wide = columns.reshape(residual.size, -1)
        covariance += wide @ np.diag(std**2) @ wide.T
    return multivariate_normal(np.zeros(residual.size), covariance).logpdf(residual.ravel())


def best(trials, base, columns, residual, excess=1.0, grid=None):
    belief = Base(np.diag(PRIOR**-2), np.zeros(3), excess)
    return findings(dictionary(base, columns, residual, trials, grid), belief)[0]


@settings(deadline=None, max_examples=25)
@given(SEEDS, st.floats(0.5, 20.0))
def test_a_bayes_factor_is_a_ratio_of_densities(seed, excess):
    base, columns, residual = drawn(seed, 5, 2)
    std = np.array([0.7, 1.3])
    trial = Trial(FloorSlope(), np.array([3, 4]), np.array([0, 1]), std)
    found = best([trial], base, columns, residual, excess)
    expected = density(residual, base, columns, std, excess) - density(residual, base, None, std, excess)
    assert found.log_factor == pytest.approx(expected, abs=1e-8)


@settings(deadline=None, max_examples=25)
@given(SEEDS)
def test_what_has_one_sign_only_has_half_the_prior(seed):
    """By quadrature over the amplitudes that it may have."""
    base, columns, residual = drawn(seed, 4, 1)
    std = np.array([0.6])
    found = best([Trial(RollingResistance(), np.array([3]), np.array([0]), std)], base, columns, residual)
    values = np.linspace(0, 6, 1201)
    free = np.array([density(residual - a * columns[..., 0], base, None, std) for a in values])
    prior = 2 * np.exp(-0.5 * (values / std) ** 2) / (std * np.sqrt(2 * np.pi))
    top = free.max()
    integral = top + np.log(np.trapezoid(np.exp(free - top) * prior, values))
    assert found.log_factor == pytest.approx(integral - density(residual, base, None, std), abs=1e-4)


@settings(deadline=None, max_examples=15)
@given(SEEDS)
def test_from_a_time_on_and_for_a_while_are_masks(seed):
    base, columns, residual = drawn(seed, 14, 1)
    std = np.array([1.0])
    change = best([Trial(PayloadChange(mass=0.0), np.array([3]), np.array([1]), std)], base, columns, residual)
    pushed = best([Trial(ExternalPush(), np.array([3]), np.array([2]), std)], base, columns, residual)
    nothing = density(residual, base, None, std)

    def factor(first, last):
        mask = ((np.arange(14) >= first) & (np.arange(14) < last))[:, None, None]
        return density(residual, base, columns * mask, std) - nothing

    starts = {first: factor(first, 14) for first in range(4, 10)}
    assert change.effect.time == pytest.approx(0.25 * max(starts, key=starts.get))
    assert change.log_factor == pytest.approx(mean_of_exp(starts.values()), abs=1e-6)
    spans = {(i, i + k): factor(i, i + k) for k in LENGTHS for i in range(14 - k + 1)}
    first, last = max(spans, key=spans.get)
    assert (pushed.effect.start, pushed.effect.duration) == pytest.approx((0.25 * first, 0.25 * (last - first)))
    assert pushed.log_factor == pytest.approx(mean_of_exp(spans.values()), abs=1e-6)


@settings(deadline=None, max_examples=10)
@given(SEEDS)
def test_a_place_is_a_box_of_cells(seed):
    base, columns, residual = drawn(seed, 3, 6)
    std = np.array([0.8])
    grid = Grid(np.array([0.0, 1.0, 2.0, 3.0]), np.array([0.0, 0.5, 1.0]))
    cells = [(i, j) for i in range(3) for j in range(2)]
    trials = [Trial(FloorPatch(), np.array([k]), np.array([4]), std, cell) for k, cell in enumerate(cells)]
    found = best(trials, base, columns, residual, grid=grid)
    nothing, factors = density(residual, base, None, std), {}
    for a in range(3):
        for b in range(a + 1, 4):
            for c in range(2):
                for d in range(c + 1, 3):
                    inside = [k for k, (i, j) in enumerate(cells) if a <= i < b and c <= j < d]
                    column = columns[..., inside].sum(axis=2, keepdims=True)
                    signed = signed_factor(residual, base, column, std, nothing)
                    factors[grid.x[a], grid.x[b], grid.y[c], grid.y[d]] = signed
    assert tuple(found.effect.values[:4]) == pytest.approx(max(factors, key=factors.get))
    assert found.log_factor == pytest.approx(mean_of_exp(factors.values()), abs=1e-6)


def signed_factor(residual, base, column, std, nothing):
    """For an amplitude that can't be below 0, from its posterior."""
    covariance = np.eye(residual.size) + base.reshape(-1, 3) @ np.diag(PRIOR**2) @ base.reshape(-1, 3).T
    weighed = np.linalg.solve(covariance, column.ravel())
    variance = 1 / (weighed @ column.ravel() + std[0] ** -2)
    mean = variance * (weighed @ residual.ravel())
    from scipy.stats import norm

    return density(residual, base, column, std) - nothing + np.log(2) + norm.logcdf(mean / variance**0.5)


def mean_of_exp(values):
    values = np.array(list(values))
    return values.max() + np.log(np.exp(values - values.max()).mean())


@settings(deadline=None, max_examples=15)
@given(SEEDS, st.floats(20.0, 50.0))
def test_what_is_far_larger_than_was_believed_drifts_no_more_for_it(seed, size):
    """Four quarters that say the same, and little against what was believed before."""
    base, columns, _ = drawn(seed, 5, 1)
    columns /= np.sqrt((columns**2).sum())
    base, columns = (np.tile(part, (4, 1, 1)) for part in (base, columns))
    trial = Trial(FloorSlope(), np.array([3]), np.array([0]), np.array([1.0]))
    assert best([trial], base, columns, size * columns[..., 0]).drift < 1e-6


def test_what_grows_is_told_from_what_stays():
    """An amplitude that doubles from the first half of a log to the second changes when a part is left out."""
    random = np.random.default_rng(5)
    base, columns = random.standard_normal((80, 6, 3)), 4 * random.standard_normal((80, 6, 1))
    noise = 0.5 * random.standard_normal((80, 6))
    trial = Trial(FloorSlope(), np.array([3]), np.array([0]), np.array([3.0]))
    steady = best([trial], base, columns, noise + columns[..., 0])
    grows = np.where(np.arange(80) < 40, 0.0, 2.0)[:, None]
    growing = best([trial], base, columns, noise + grows * columns[..., 0])
    assert steady.change < 0.1
    assert growing.change > 0.25
