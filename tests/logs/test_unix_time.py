"""Stamps in unix time are rounded to a quarter of a microsecond, which decides nothing: logs are as those from zero."""

from __future__ import annotations

import numpy as np
import pytest

import cartgrasp as cg
from cartgrasp.effects import TimeDelay
from cartgrasp.logs import ArmLog, RunLog
from cartgrasp.logs.alignment import aligned

STARTS = (0.0, 1.0e9, 1.7e9, 1732000000.123)


def even(start, rate, n=1200):
    """A log whose hand's fx counts the rows."""
    wrench = np.zeros((n, 6))
    wrench[:, 0] = np.arange(n)
    return RunLog(start + np.arange(n) / rate, np.zeros((n, 3)), None, {"hand": ArmLog(np.zeros((n, 3)), wrench)})


@pytest.mark.parametrize(("rate", "size"), [(499, 1), (500, 2), (750, 3), (1000, 4), (2000, 8), (4000, 16)])
@pytest.mark.parametrize("start", STARTS)
def test_thinning(start, rate, size):
    """Of 500 Hz nothing had been thinned, and one row of three had been kept of 1 kHz."""
    assert len(even(start, rate).thinned()) == 1200 // size


@pytest.mark.parametrize("steps", [0.5, 1.5, 3.5])
@pytest.mark.parametrize("rate", [100, 250, 500, 1000])
@pytest.mark.parametrize("start", STARTS)
def test_of_samples_that_are_equally_near_the_earlier_is_taken(start, rate, steps):
    """One had been taken twice now and then, and another not at all."""
    cart = cg.CartModel(cg.Inertia(24.0, (0.3, 0.0), 2.0), effects=(TimeDelay(label="hand", delay=steps / rate),))
    taken = aligned(even(start, rate), cart).arms["hand"].wrench[:1190, 0]
    np.testing.assert_array_equal(taken, np.arange(1190) + int(steps))
