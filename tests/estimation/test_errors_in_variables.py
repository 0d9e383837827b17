"""A slope from regressors with errors, by the corrected score, beside what is known of it in closed form."""

import numpy as np
import pytest
from hypothesis import given

from estimation.batch.linearisation import Evidence
from tests.core.drawn import numbers

SLOPE, ERROR, NOISE, ROWS, BLOCKS = 2.0, 0.6, 0.5, 50, 60


def evidence(seed, spoiled=()):
    """Around a slope of 0.5, of `y = 2 x + noise`, with x seen with errors of 0.6 of its size; of `spoiled` stretches
    it is told that all of them were errors, five times."""
    random = np.random.default_rng(seed)
    true = random.standard_normal((BLOCKS, ROWS))
    seen = true + ERROR * random.standard_normal(true.shape)
    left = SLOPE * true + NOISE * random.standard_normal(true.shape) - 0.5 * seen
    information, pull = (seen**2).sum(axis=1), (seen * left).sum(axis=1)
    noise = np.full(BLOCKS, ROWS * ERROR**2)
    noise[list(spoiled)] = 5 * information[list(spoiled)]
    return Evidence(information[:, None, None], pull[:, None], noise[:, None, None], 0.5 * noise[:, None])


def slope(found):
    part = found.part(np.array([0]))
    return 0.5 + float(part.pulls.sum() / part.blocks.sum()), float(part.blocks.sum())


def test_the_slope_is_not_too_low():
    found = [slope(evidence(seed))[0] for seed in range(40)]
    naive = [0.5 + evidence(seed).pulls.sum() / evidence(seed).blocks.sum() for seed in range(40)]
    assert np.mean(naive) == pytest.approx(SLOPE / (1 + ERROR**2), rel=0.01)
    assert np.mean(found) == pytest.approx(SLOPE, rel=0.005)


def test_what_it_tells_is_that_of_the_score():
    """`(I - N)² / I`, I with errors."""
    whole = BLOCKS * ROWS
    assert slope(evidence(0))[1] == pytest.approx(whole / (1 + ERROR**2), rel=0.05)


@pytest.mark.parametrize("spoiled", [1, 4])
def test_a_stretch_has_no_more_errors_than_information(spoiled):
    """From four stretches of sixty that went astray nothing is learned, and no more is lost."""
    found, told = slope(evidence(3, range(spoiled)))
    clean, known = slope(evidence(3))
    assert told == pytest.approx(known * (1 - spoiled / BLOCKS), rel=0.02)
    assert found == pytest.approx(clean, rel=0.01)


def test_without_errors_nothing_is_corrected():
    found = evidence(1)
    found = Evidence(found.blocks, found.pulls, 0.0 * found.noise, 0.0 * found.drag)
    part = found.part(np.array([0]))
    assert part.blocks == pytest.approx(found.blocks, rel=1e-6)
    assert part.pulls == pytest.approx(found.pulls, rel=1e-6)


@given(shared=numbers(-0.9, 0.9), left=numbers(-0.2, -0.01), pull=numbers(-1, 1))
def test_what_only_a_stretch_taught_that_went_astray_is_not_known(shared, left, pull):
    """A push in it, whose end the stretch behind it takes some of."""
    whole = evidence(2, [7])
    blocks, noise = np.zeros((BLOCKS, 2, 2)), np.zeros((BLOCKS, 2, 2))
    blocks[:, :1, :1], noise[:, :1, :1] = whole.blocks, whole.noise
    blocks[7, 1, 1], blocks[8, 1, 1] = 1.0, left
    blocks[8, 0, 1] = blocks[8, 1, 0] = shared
    pulls, drag = (np.column_stack([own[:, 0], np.zeros(BLOCKS)]) for own in (whole.pulls, whole.drag))
    pulls[8, 1] = pull
    part = Evidence(blocks, pulls, noise, drag).part(np.array([0, 1]))
    known, told = part.blocks.sum(axis=0), part.pulls.sum(axis=0)
    assert np.linalg.eigvalsh(known).min() > -1e-9
    assert abs(known[1, 1]) < 1e-3
    alone = whole.part(np.array([0]))
    assert told[0] / known[0, 0] == pytest.approx(float(alone.pulls.sum() / alone.blocks.sum()), rel=1e-3)
