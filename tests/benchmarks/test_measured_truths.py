"""What is declared of the measured logs, beside least squares on their smoothed signals and parabolas of flights."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from scipy.signal import savgol_filter

from benchmarks.measured import truths
from cartgrasp.logs import read_log

from .measured_logs import DATA, needs_data

GRAVITY = 9.81


def smoothed(path, window):
    """Speed, acceleration and force forward (n,) of a log, smoothed over so many s."""
    log = read_log(DATA / path)
    step = float(np.median(np.diff(log.time)))
    rows = round(window / step / 2) * 2 + 1
    (arm,) = log.arms.values()
    u, a = (savgol_filter(log.pose[:, 0], rows, 3, deriv=k, delta=step) for k in (1, 2))
    return u, a, savgol_filter(arm.wrench[:, 0], rows, 1)


def masses_both_ways(u, a, force):
    """Of force on acceleration, which noise pulls down, and of acceleration on force, which it pulls up; and the
    constant of the first."""
    rest = np.column_stack([np.ones_like(u), u])

    def without(column):
        return column - rest @ np.linalg.lstsq(rest, column, rcond=None)[0]

    x, y = without(a), without(force)
    constant = np.linalg.lstsq(np.column_stack([a, rest]), force, rcond=None)[0][1]
    return x @ y / (x @ x), y @ y / (x @ y), constant


@needs_data
@pytest.mark.parametrize(
    ("path", "truth", "slowest"),
    [
        ("real/wheelchair/push.csv", truths.WHEELCHAIR, 0.2),
        ("real/car/drive_and_coast.csv", truths.CAR, 1.0),
    ],
)
def test_least_squares_both_ways_bracket_a_mass_that_is_declared(path, truth, slowest):
    u, a, force = smoothed(path, 0.5)
    rolls = u > slowest
    low, high, constant = masses_both_ways(u[rolls], a[rolls], force[rolls])
    assert low < truth.mass.high
    assert high > truth.mass.low
    if "rolling force" in truth.values:
        assert truth.values["rolling force"].holds(constant)


def flights(path):
    """Means of the accelerations up and down (m/s²) of flights between bounces, and where the cart turned back (m)."""
    time, x = np.loadtxt(DATA / path, delimiter=",", skiprows=1)[:, :2].T
    smooth = savgol_filter(x, 31, 2)
    near = [i for i in range(60, len(x) - 60) if smooth[i] == smooth[i - 60 : i + 61].max() and x[i] > 1.1]
    bounces = [i for i, before in zip(near[1:], near[:-1], strict=True) if i - before > 150]
    means = []
    for start, stop in pairwise(bounces[:4]):
        t, y = time[start + 12 : stop - 12], x[start + 12 : stop - 12]
        top = np.argmin(np.polyval(np.polyfit(t, y, 2), t))
        halves = (slice(None, top), slice(top, None))
        means.append(np.mean([2 * np.polyfit(t[part], y[part], 2)[0] for part in halves]))
    return np.array(means), x[bounces[:4]]


@needs_data
@pytest.mark.parametrize(
    ("name", "truth"),
    [("good_cart", truths.GOOD_CART), ("magnetic_bumper", truths.MAGNETIC_BUMPER), ("sail", truths.SAIL)],
)
def test_flights_up_and_down_have_the_slope_and_the_bumper_that_are_declared(name, truth):
    """Drag adds upward and takes away downward, so the mean is the slope's. A parabola through a second of centimetres
    has the acceleration to 0.02 m/s²."""
    means, places = flights(f"real/incline/{name}.csv")
    assert len(means) == 3
    slope = np.degrees(np.arcsin(means.mean() / GRAVITY))
    assert truth.values["slope"].holds(float(slope))
    assert all(truth.values["end stop"].holds(float(place)) for place in places)


@needs_data
def test_where_nothing_moves_the_ranger_shows_one_place():
    x = np.loadtxt(DATA / "real/incline/still.csv", delimiter=",", skiprows=1)[:, 1]
    assert np.ptp(x) == 0.0
