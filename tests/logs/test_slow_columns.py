"""Tables at 100 Hz in which slow sensors leave blanks: closed forms of what is tracked, and of {b} beside it."""

from __future__ import annotations

import numpy as np
import pytest

from cartgrasp.logs import read_log

N = 401
TIME, RATE, BODY = 0.01 * np.arange(N), 0.3, 0.2 - 0.1j
TURN = np.exp(1j * (0.4 + RATE * TIME))
PLACE, VELOCITY = 0.5 * TURN + 0.1 * TIME, 0.5j * RATE * TURN + 0.1
COLUMNS = ("t", "x", "y", "theta", "vx", "vy", "omega", "px", "fx")
MAP = """\
time: {column: t, unit: s}
clock: pose
pose:
  x: {column: x, unit: m}
  y: {column: y, unit: m}
  theta: {column: theta, unit: rad}
  body: [0.0, 0.0, 0.0]
  velocity: columns
  vx: {column: vx, unit: m/s}
  vy: {column: vy, unit: m/s}
  omega: {column: omega, unit: rad/s}
  frame: world
arms:
  hand:
    contact: {px: {column: px, unit: m}, py: 0.0, pz: 1.0}
    force: on_cart
    measures: [fx]
    fx: {column: fx, unit: N}
    unmeasured: zero
"""
WITH_BODY = MAP.replace("body: [0.0, 0.0, 0.0]", f"body: [{BODY.real}, {BODY.imag}, 0.7]")
SLOW = np.arange(N) % 10 != 0


def table(folder, text, blank, frame="world"):
    """Columns x, y, theta and px are empty where `blank` is."""
    velocity = VELOCITY if frame == "world" else VELOCITY / TURN
    slow = np.where(blank, np.nan, [PLACE.real, PLACE.imag, 0.4 + RATE * TIME, -0.25 - 0.1 * (TIME > 2)])
    full = np.array([velocity.real, velocity.imag, np.full(N, RATE)])
    rows = np.vstack([TIME, slow[:3], full, slow[3], 10 + TIME]).T
    lines = [",".join("" if np.isnan(cell) else repr(cell) for cell in row) for row in rows.tolist()]
    path = folder / "mine.csv"
    path.write_text("\n".join([",".join(COLUMNS), *lines]) + "\n", encoding="utf-8")
    text = text.replace("frame: world", f"frame: {frame}")
    path.with_name("mine.csv.topics.yaml").write_text(text, encoding="utf-8")
    return read_log(path)


def plane(rows):
    return rows[:, 0] + 1j * rows[:, 1]


@pytest.mark.parametrize("frame", ["world", "cart"])
@pytest.mark.parametrize(("text", "body"), [(MAP, 0.0), (WITH_BODY, BODY)])
def test_velocities_between_slow_poses_are_kept(tmp_path, text, body, frame):
    """Nine of ten had been lost."""
    log = table(tmp_path, text, SLOW, frame)
    assert np.array_equal(np.isnan(log.pose).all(axis=1), SLOW)
    np.testing.assert_allclose(plane(log.velocity), VELOCITY + 1j * RATE * body * TURN, atol=1e-12)
    np.testing.assert_allclose(log.velocity[:, 2], RATE)


@pytest.mark.parametrize(
    ("frame", "text", "kept"), [("world", MAP, True), ("world", WITH_BODY, False), ("cart", MAP, False)]
)
def test_what_needs_no_heading_outlasts_the_poses(tmp_path, frame, text, kept):
    lost = (TIME > 1) & (TIME < 2)
    log = table(tmp_path, text, lost, frame)
    assert np.isfinite(log.velocity).all(axis=1)[lost].tolist() == [kept] * int(lost.sum())
    assert np.isfinite(log.velocity[~lost]).all()


@pytest.mark.parametrize("clock", ["50", "100", "hand"])
def test_a_blank_is_no_sample_to_another_clock(tmp_path, clock):
    """Where stamps were equal to the last bit blanks had been taken, so that poses came and went."""
    log = table(tmp_path, WITH_BODY.replace("clock: pose", f"clock: {clock}"), SLOW)
    turn = np.exp(1j * (0.4 + RATE * log.time))
    between = 0.7 * (0.05 * RATE) ** 2  # what a straight line leaves out of a curve, and more
    np.testing.assert_allclose(plane(log.pose), 0.5 * turn + 0.1 * log.time + BODY * turn, atol=between)
    np.testing.assert_allclose(log.pose[:, 2], 0.4 + RATE * log.time + 0.7)
    assert np.isfinite(log.velocity).all()


@pytest.mark.parametrize("clock", ["pose", "50"])
def test_a_contact_is_held_over_blanks(tmp_path, clock):
    log = table(tmp_path, MAP.replace("clock: pose", f"clock: {clock}"), SLOW)
    regrasp = 2.1 - 1e-6  # the first row after 2 s that tells
    np.testing.assert_allclose(log.arms["hand"].contact[:, 0], np.where(log.time > regrasp, -0.35, -0.25))


def test_columns_that_are_blank_throughout_are_missing(tmp_path):
    for clock in ("pose", "50"):
        log = table(tmp_path, MAP.replace("clock: pose", f"clock: {clock}"), np.ones(N, dtype=bool))
        assert np.isnan(log.pose).all()
        assert np.isfinite(log.velocity).all()
