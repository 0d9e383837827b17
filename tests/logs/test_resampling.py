"""Resampling bridges no gap and counts no sample twice; the smoothing spline is scipy's, at the stated noise."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.interpolate import CubicSpline, make_smoothing_spline

from cartgrasp.logs.mapped.resampling import averaged, held, interpolated, stretches
from cartgrasp.logs.mapped.smoothing_spline import SplineSystem, spline_at_noise

GAP = 0.25


@st.composite
def clocks(draw, least=1):
    steps = draw(st.lists(st.integers(1, 500), min_size=least, max_size=40))
    return draw(st.integers(-3000, 3000)) * 1e-3 + np.cumsum(steps) * 1e-3


@given(clocks(), clocks())
def test_interpolated_between_near_neighbours_only(time, at):
    rows = np.column_stack([2 * time - 1, np.sin(time)])
    found = interpolated(time, rows, at, GAP)
    assert found.taken + found.interpolated + found.masked == len(at)
    for t, row in zip(at, found.rows, strict=True):
        before, after = time[time <= t], time[time >= t]
        there = len(before) > 0 and len(after) > 0 and after[0] - before[-1] <= GAP
        assert np.isfinite(row).all() == there
        if there:
            assert row[0] == pytest.approx(2 * t - 1, abs=1e-12)
            assert row[1] == pytest.approx(np.interp(t, time, rows[:, 1]), abs=1e-12)


@given(clocks(), clocks())
def test_averaged_counts_no_sample_twice(time, at):
    """With a column for each sample, 1 where it is that one, rows hold the weights; only rows between samples share."""
    found = averaged(time, np.eye(len(time)), at, GAP)
    there = np.isfinite(found.rows).all(axis=1)
    weights = found.rows[there]
    assert weights.sum(axis=1) == pytest.approx(np.ones(len(weights)))
    assert there.sum() == found.taken + found.interpolated == len(at) - found.masked
    again = np.maximum((weights > 0).sum(axis=0) - 1, 0).sum()
    assert again <= 2 * found.interpolated
    for row, t in zip(weights, at[there], strict=True):
        assert (np.abs(time[row > 0] - t) <= GAP).all()


@given(clocks(), clocks())
def test_held_is_the_last_one(time, at):
    found = held(time, time[:, None], at, GAP)
    for t, (row,) in zip(at, found.rows, strict=True):
        before = time[time <= t]
        if len(before) and t - before[-1] <= GAP:
            assert row == before[-1]
        else:
            assert np.isnan(row)


@given(clocks())
def test_stretches_have_no_gap(time):
    parts = stretches(time, GAP)
    assert np.concatenate([time[part] for part in parts]).tolist() == time.tolist()
    assert all(len(time[part]) == 1 or np.diff(time[part]).max() <= GAP for part in parts)
    joints = [time[b.start] - time[a.stop - 1] for a, b in pairwise(parts)]
    assert all(joint > GAP for joint in joints)


def samples(n=400, seed=0):
    rng = np.random.default_rng(seed)
    time = np.cumsum(rng.uniform(0.5, 1.5, n)) * 0.02
    return time, np.sin(time) + 0.3 * np.cos(3 * time), np.cos(time) - 0.9 * np.sin(3 * time)


@pytest.mark.parametrize("decade", [-3.0, 0.0, 2.0, 5.0, 8.0])
def test_the_spline_is_scipys(decade):
    time, values, _ = samples()
    values = values + np.random.default_rng(1).normal(0, 0.01, len(time))
    knots = time / 0.02
    value = SplineSystem(knots, values).smoothed(10.0**decade)
    slope = CubicSpline(knots, value, bc_type="natural")(knots, 1)
    other = make_smoothing_spline(knots, values, lam=10.0**decade)
    round_off = 1e-11 + 2.2e-16 * 16 * 10.0**decade  # times the system's condition: 16 is the largest of QᵀQ
    assert value == pytest.approx(other(knots), abs=round_off)
    assert slope == pytest.approx(other.derivative()(knots), abs=round_off)


@pytest.mark.parametrize("noise", [1e-4, 1e-3, 1e-2])
def test_the_stated_noise_is_near_the_best(noise):
    """No smoothing that one could choose, knowing the truth, gives half the error."""
    time, values, slope = samples()
    noisy = values + np.random.default_rng(2).normal(0, noise, len(time))
    step = (time[-1] - time[0]) / (len(time) - 1)
    system = SplineSystem((time - time[0]) / step, noisy)
    smoothed = [
        CubicSpline(time, system.smoothed(10.0**decade), bc_type="natural") for decade in np.arange(-4, 10, 0.25)
    ]
    errors = [np.std(spline(time, 1) - slope) for spline in smoothed]
    found = np.std(spline_at_noise(time, noisy, noise)(time, 1) - slope)
    assert found < 2 * min(errors)
    assert spline_at_noise(time, values, 1e-9)(time[5:-5], 1) == pytest.approx(slope[5:-5], abs=2e-3)
