"""Offsets that turn with a wheel: found with amplitude and period, and not told of hands."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cartgrasp.logs import ArmLog
from estimation.sensor_check.wrench.wave import waves

from .sensor_logs import NOISE, QUIET, sealed, two_hands

TRACK = Path(__file__).parents[3] / "shared" / "data" / "real" / "sensor_track" / "turning_wheel.csv"


def rolled(seed):
    """Way (n,) of the plant of `two_hands`."""
    quiet = two_hands(seed, QUIET)
    theta = quiet.pose[:, 2]
    u = np.cos(theta) * quiet.velocity[:, 0] + np.sin(theta) * quiet.velocity[:, 1]
    return np.concatenate([[0.0], np.cumsum((u[1:] + u[:-1]) / 2 * 0.01)])


def with_wave(log, way, amplitude, period, component):
    arm = log.arms["left"]
    wrench = arm.wrench.copy()
    wrench[:, component] += amplitude * np.cos(2 * np.pi * way / period + 0.7)
    return replace(log, arms={**log.arms, "left": ArmLog(arm.contact, wrench)})


@settings(max_examples=12)
@given(st.integers(0, 3), st.floats(4.0, 8.0), st.floats(0.35, 1.5), st.sampled_from([0, 1]))
def test_a_wave_is_found_with_its_period(seed, amplitude, period, component):
    """Beside noise of 3 N a row; wave numbers as exactly as the way can tell them apart."""
    way = rolled(seed)
    told = waves(with_wave(two_hands(seed, NOISE), way, amplitude, period, component))
    assert [(one.kind, one.where) for one in told] == [("offset", "left")]
    assert told[0].probability > 0.9
    assert 1 / told[0].factor == pytest.approx(1 / period, abs=0.5 / np.ptp(way))
    said = float(told[0].words.split("wave of ")[1].split(" ")[0])
    assert 0.5 * amplitude < said < 1.35 * amplitude


@pytest.mark.parametrize("seed", range(4))
def test_nothing_is_told_of_hands(seed):
    assert waves(two_hands(seed)) == ()


@pytest.mark.parametrize("case", ["nothing", "load_slosh", "force_misalignment", "external_push"])
@pytest.mark.parametrize("seed", range(3))
def test_nothing_is_told_of_hidden_effects(case, seed):
    assert all(one.probability < 0.5 for one in waves(sealed(case, seed)[0]))


@settings(max_examples=10)
@given(st.floats(3.0, 15.0), st.floats(0.3, 1.5))
def test_strokes_in_time_are_no_wave_of_the_way(amplitude, rate):
    log = two_hands(0)
    time = log.time * (2 * np.pi * rate)
    arm = log.arms["left"]
    wrench = arm.wrench + amplitude * np.sin(time)[:, None] * np.array([1, 1, 0, 0, 0, 0])
    assert waves(replace(log, arms={**log.arms, "left": ArmLog(arm.contact, wrench)})) == ()


def test_levels_at_rest_are_no_wave():
    """A sensor whose zero steps while the cart stands, here and there, and no wheel turns."""
    log = two_hands(0)
    arm, still = log.arms["left"], np.arange(len(log)) // 800 % 2 == 0
    pose = np.where(still[:, None], 0.3 * (np.arange(len(log)) // 800)[:, None] * [1.0, 0.0, 0.0], log.pose * [1, 0, 0])
    steps = 60.0 * np.cos(2 * np.pi * pose[:, 0] / 0.4) * still
    wrench = arm.wrench + steps[:, None] * np.array([1, 0, 0, 0, 0, 0])
    rest = replace(log, pose=pose, velocity=None, arms={"left": ArmLog(arm.contact, wrench)})
    assert all(one.probability < 0.5 for one in waves(rest))


@pytest.mark.skipif(not TRACK.exists(), reason="the measured sensor track is not here")
def test_a_measured_track_of_a_turning_sensor_is_told():
    """What an instrumented wheel of 0.3086 m says while it turns by itself, put on a cart that rolls with it."""
    table = np.genfromtxt(TRACK, delimiter=",", names=True)
    angle = np.radians(table["angle_deg"])
    way = 0.3086 * np.abs(np.unwrap(angle))
    time = table["t"]
    n = len(time)
    arm = np.column_stack([table[c] for c in ("fx", "fy", "fz", "mx", "my", "mz")])
    log = two_hands(0)
    pose = np.column_stack([way, 0 * way, 0 * way])
    found = waves(replace(log, time=time, pose=pose, velocity=None, arms={"wheel": ArmLog(np.zeros((n, 3)), arm)}))
    assert [one.kind for one in found] == ["offset"]
    assert found[0].probability > 0.9
    assert found[0].factor == pytest.approx(2 * np.pi * 0.3086, rel=0.05)
