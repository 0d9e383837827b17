"""The score against Gaussians that are written out."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import multivariate_normal

from estimation.weak_form.score import (
    MIN_PIECE_DURATION,
    MIN_STRETCH_DURATION,
    N_SCORE_FOLDS,
    Folds,
    log_evidence,
    scored,
)

ROWS, COUNT = 40, 3
LOG_2PI = np.log(2 * np.pi)


def problem(seed, rows=ROWS):
    """Whitened columns (k, 2, q + 1), the residual last; prior standard deviations; scales of both balances."""
    random = np.random.default_rng(seed)
    columns = random.standard_normal((rows, 2, COUNT + 1)) * [1.0, 3.0, 0.2, 2.0]
    return columns, random.uniform(0.1, 3.0, COUNT), random.uniform(0.5, 2.0, 2)


def covariance_of(columns, prior, scale):
    """Of all residuals (2 k, 2 k), balance by balance."""
    base = columns[..., :-1].swapaxes(0, 1).reshape(-1, COUNT)
    return np.diag(np.repeat(scale**2, len(columns))) + (base * prior**2) @ base.T


def residual_of(columns):
    return columns[..., -1].T.ravel()


@given(st.integers(0, 1000))
def test_the_evidence_is_a_gaussians_density(seed):
    columns, prior, scale = problem(seed)
    sums = np.einsum("kci,kcj->cij", columns, columns)
    found = float(log_evidence(sums, prior, scale, np.full(2, float(ROWS))))
    expected = multivariate_normal(cov=covariance_of(columns, prior, scale)).logpdf(residual_of(columns))
    assert found == pytest.approx(expected + ROWS * LOG_2PI, rel=1e-9)


@settings(max_examples=10, deadline=None)
@given(st.integers(0, 1000))
def test_each_fold_is_a_conditional_density(seed):
    """Of its rows given all others: mean and covariance by the formulae of a partitioned Gaussian."""
    rows = 100
    columns, prior, _ = problem(seed, rows)
    time = 0.1 * np.arange(rows)
    folds = Folds.of(time, 0.1)
    found = scored(folds.sums(columns), folds.counted(np.ones((rows, 2))), prior, folds, np.ones(2))
    covariance, residual = covariance_of(columns, prior, found.scale), residual_of(columns)
    for told, of_block in ((found.pieces, folds.pieces), (found.stretches, folds.stretches)):
        kinds = np.unique(of_block)
        assert len(told) == len(kinds)
        for density, fold in zip(told, kinds, strict=True):
            out = np.tile(of_block[folds.block] == fold, 2)
            gain = np.linalg.solve(covariance[np.ix_(~out, ~out)], covariance[np.ix_(~out, out)]).T
            mean = gain @ residual[~out]
            rest = covariance[np.ix_(out, out)] - gain @ covariance[np.ix_(~out, out)]
            expected = multivariate_normal(mean, rest).logpdf(residual[out])
            assert density == pytest.approx(expected + 0.5 * out.sum() * LOG_2PI, rel=1e-7, abs=1e-7)


def test_the_fit_is_the_posterior_and_the_scale_that_of_the_noise():
    random, true = np.random.default_rng(4), np.array([1.0, -0.5, 0.3])
    columns = random.standard_normal((4000, 2, 4))
    noise = random.standard_normal((4000, 2)) * [0.5, 3.0]
    columns[..., -1] = columns[..., :3] @ true + noise
    folds = Folds.of(0.1 * np.arange(4000), 0.1)
    found = scored(folds.sums(columns), folds.counted(np.ones((4000, 2))), np.full(3, 10.0), folds, np.ones(2))
    assert found.scale == pytest.approx([0.5, 3.0], rel=0.04)
    off = found.fit - true
    assert off @ np.linalg.solve(found.covariance, off) < 16.3  # of chi² with 3 degrees, in 999 of 1000
    weighted = (columns / found.scale[:, None]).reshape(-1, 4)
    precision = weighted[:, :3].T @ weighted[:, :3] + np.eye(3) / 100
    assert found.covariance == pytest.approx(np.linalg.inv(precision))
    assert found.fit == pytest.approx(np.linalg.solve(precision, weighted[:, :3].T @ weighted[:, 3]))


@given(duration=st.floats(5.0, 300.0), step=st.floats(0.05, 1.6))
def test_pieces_are_dealt_in_turn_and_stretches_hang_together(duration, step):
    time = 3.0 + np.arange(0.0, duration, step)
    folds = Folds.of(time, step)
    assert folds.counted(np.ones((len(time), 1))).sum() == len(time)
    piece, stretch = folds.pieces[folds.block], folds.stretches[folds.block]
    assert set(piece) <= set(range(N_SCORE_FOLDS))
    assert (np.diff(folds.block) >= 0).all()
    assert (np.diff(stretch) >= 0).all()
    for block in np.unique(folds.block):
        assert np.ptp(time[folds.block == block]) <= max(MIN_PIECE_DURATION, 2 * step)
    longest = max(MIN_STRETCH_DURATION, duration / 20) + max(MIN_PIECE_DURATION, 2 * step)
    assert all(np.ptp(time[stretch == s]) <= longest + 1e-9 for s in np.unique(stretch))


def test_folds_of_several_logs_share_pieces_and_no_stretch():
    one, other = Folds.of(0.1 * np.arange(100), 0.1), Folds.of(0.1 * np.arange(80), 0.1)
    both = Folds.joined([one, other])
    assert len(both.block) == 180
    first, second = np.split(both.stretches[both.block], [100])
    assert not set(first) & set(second)
    assert (both.pieces[both.block][:100] == one.pieces[one.block]).all()
    assert (both.pieces[both.block][100:] == other.pieces[other.block]).all()


def test_rows_that_do_not_count_change_neither_scale_nor_density():
    """A quarter of the rows weighed by nothing, against the problem without them."""
    columns, prior, _ = problem(1, 400)
    counts = np.ones((400, 2))
    counts[100:200] = 0.0
    time, left = 0.1 * np.arange(400), np.r_[0:100, 200:400]
    folds = Folds.of(time, 0.1)
    found = scored(folds.sums(columns * counts[..., None] ** 0.5), folds.counted(counts), prior, folds, np.ones(2))
    less = Folds(folds.block[left], folds.pieces, folds.stretches)
    other = scored(less.sums(columns[left]), less.counted(np.ones((300, 2))), prior, less, np.ones(2))
    assert found.scale == pytest.approx(other.scale)
    assert found.pieces == pytest.approx(other.pieces)
