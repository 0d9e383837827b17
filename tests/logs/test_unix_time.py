"""Stamps in unix time are rounded to a quarter of a microsecond, which decides nothing: logs are as those from zero."""

from __future__ import annotations

import numpy as np
import pytest

import cartgrasp as cg
from cartgrasp.effects import TimeDelay
from cartgrasp.errors import FileError
from cartgrasp.logs import ArmLog, RunLog, read_log
from cartgrasp.logs.alignment import aligned

STARTS = (0.0, 1.0e9, 1.7e9, 1732000000.123)
MAP = """\
time: {column: t, unit: s}
clock: 50
pose:
  x: {column: x, unit: m}
  y: 0.0
  theta: 0.0
arms: {}
"""


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


def poses_of(folder, time, text=MAP):
    """A table of poses x = t - start, read through a map."""
    first, *_ = told = time.tolist()
    rows = [f"{one!r},{one - first!r}" for one in told]
    path = folder / "mine.csv"
    path.write_text("\n".join(["t,x", *rows]) + "\n", encoding="utf-8")
    path.with_name("mine.csv.topics.yaml").write_text(text, encoding="utf-8")
    return read_log(path)


@pytest.mark.parametrize("jitter", [0.0, 1e-7, 2e-3])
@pytest.mark.parametrize("start", STARTS)
def test_jitter_makes_no_gap_and_a_missing_sample_does(tmp_path, start, jitter):
    """At 10 Hz, with max_gap 0.1: half of all steps had been gaps, or the table was refused."""
    time = start + 0.1 * np.arange(100) + np.random.default_rng(3).uniform(-jitter, jitter, 100)
    assert np.isfinite(poses_of(tmp_path, time).pose).all()
    log = poses_of(tmp_path, np.delete(time, 50))
    lost = (log.time > time[49]) & (log.time < time[51])
    assert np.array_equal(np.isnan(log.pose).all(axis=1), lost)


def test_steps_beyond_the_longest_gap_are_refused(tmp_path):
    with pytest.raises(FileError, match=r"max_gap: pose has a sample every 0\.101 s"):
        poses_of(tmp_path, 1.7e9 + 0.101 * np.arange(100))
