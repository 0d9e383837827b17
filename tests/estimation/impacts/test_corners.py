"""Corners in a track, beside least squares that are solved for each hypothesis alone."""

from itertools import combinations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from estimation.impacts.corners import Track, windows_around


@settings(max_examples=20, deadline=None)
@given(seed=st.integers(0, 1000), count=st.integers(3, 6))
def test_the_least_that_pairs_of_columns_leave(seed, count):
    """Of all pairs beside a parabola, the best one's sum of squares is that of a least squares fit."""
    random = np.random.default_rng(seed)
    time = np.arange(0.0, 2.0, 0.02) + 0.004 * random.random(100)
    track = Track(time, np.sin(time) + 1e-3 * random.standard_normal(100))
    _, windows = windows_around(track, np.array([1.0]), ())
    columns = random.standard_normal((count, windows.time.shape[1]))
    pairs = list(combinations(range(count), 2))
    here, place = windows.time[0], windows.place[0]
    left = []
    for i, j in pairs:
        base = np.column_stack([np.ones_like(here), here, here**2, columns[i], columns[j]])
        left.append(float(((place - base @ np.linalg.lstsq(base, place, rcond=None)[0]) ** 2).sum()))
    first, second = np.array(pairs).T
    assert windows.least_left(columns, (first, second)) == pytest.approx(min(left), rel=1e-6)
