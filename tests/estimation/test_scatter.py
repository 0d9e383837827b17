"""Means of residuals over stretches, against noise whose size is known."""

from types import SimpleNamespace

import numpy as np
import pytest

from estimation.batch.linearisation import Linearisation
from estimation.discrepancy.scatter import Scatter, noise_excess

STEP, ROWS = 0.02 + 1e-9, 3000
"""s, a little more than a 25th of a stretch, so that rounding moves no row to another one."""
STD = np.array([2.0, 0.5])
JOLT = slice(1200, 1250)


def white(told):
    """Rows with noise as it is believed; `told` is what those across a jolt tell, beside the others."""
    time = STEP * np.arange(ROWS)
    weight, residual = np.ones(ROWS), STD * np.random.default_rng(3).standard_normal((ROWS, 2))
    weight[JOLT], residual[JOLT] = told, 4e3
    every = weight[:, None, None] * np.diag(STD**-2.0)
    line = SimpleNamespace(time=time, residual=residual, whitened=lambda columns: every @ columns)
    line.ends = lambda duration: Linearisation.ends(line, duration)
    return [(None, line, 0.0)]


@pytest.mark.parametrize("told", [1e-6, 0.0, -1e-9])
def test_a_stretch_that_tells_nothing_is_in_no_scatter_and_no_noise(told):
    logs = white(told)
    assert noise_excess(logs) == pytest.approx(1.0, abs=0.25)
    found = Scatter.of(logs, 1.0)
    assert len(found.mean) == 120 - 2
    assert not ((found.start > 23.9) & (found.start < 24.6)).any()
    assert (np.linalg.eigvalsh(found.information) > 0).all()
    assert found.misfit.mean() == pytest.approx(2.0, abs=0.3)


def test_a_stretch_with_fewer_rows_counts():
    assert len(Scatter.of(white(0.2), 1.0).mean) == 120
