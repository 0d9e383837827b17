"""Usual steps against times that are written down."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from estimation.log_noise.sample_step import STEPS_TOGETHER, usual_step


@given(st.floats(1e-3, 0.2), st.integers(1, 6), st.floats(1e-3, 0.02), st.integers(0, 3))
def test_rows_that_come_together_are_as_many_as_there_are(period, sensors, share, gaps):
    """Rows of several sensors, a share of a period apart at most, with pauses of ten seconds among them."""
    ticks = period * np.arange(400) + 10.0 * np.searchsorted([100, 200, 300][:gaps], np.arange(400), side="right")
    time = (ticks[:, None] + share * period * np.arange(sensors) / sensors).ravel()
    assert usual_step(time) == pytest.approx(period / sensors, rel=0.2)
    if STEPS_TOGETHER % sensors == 0:
        assert usual_step(time) == pytest.approx(period / sensors, rel=1e-6)


def test_few_times_have_a_step_too():
    assert usual_step(np.array([1.0, 1.5])) == 0.5
    assert usual_step(np.array([1.0])) == usual_step(np.zeros(0)) == 0.0
