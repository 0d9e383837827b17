"""A track of a wheel that nobody touches: split into what goes with its angle and what goes with time, and added."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.measured.sensor_track import COLUMNS, SECTORS, read_sensor_track, split, travelled, with_sensor_track
from cartgrasp.errors import LogError
from cartgrasp.logs import ArmLog, RunLog

from .measured_logs import DATA, needs_data, parabola

OFFSET, WAVE, NOISE = np.array([-0.6, -6.5, 0.9, 0.2, 0.0, -0.1]), np.array([5.7, 5.7, 1.0, 0.1, 0.1, 0.2]), 0.7
TRACK = DATA / "real" / "sensor_track" / "turning_wheel.csv"


def waves(angle):
    return OFFSET + WAVE * np.sin(angle[:, None] + np.arange(6))


def turning(turns=13.0, n=6500, seed=0):
    """Times, angles that wrap, and wrenches with noise."""
    time = np.arange(n) / 240 + 3.0
    angle = 0.5 + turns * 2 * np.pi * np.arange(n) / n
    noise = NOISE * np.random.default_rng(seed).standard_normal((n, 6))
    return time, angle % (2 * np.pi), waves(angle) + noise, noise


def still(duration, rate=100.0):
    """A log in which nothing moves and nobody pushes."""
    time = np.arange(0.0, duration, 1 / rate)
    zero = np.zeros((len(time), 6))
    return RunLog(time, zero[:, :3], None, {"left": ArmLog(zero[:, :3], zero)}, "still")


def rolling(speed, duration, heading=0.0):
    log = still(duration)
    way = speed * log.time
    pose = np.column_stack([way * np.cos(heading), way * np.sin(heading), np.full(len(way), heading)])
    return RunLog(log.time, pose, None, log.arms, "rolling")


def test_a_track_is_split_into_a_wave_and_the_rest():
    """A sector of 180 rows has the mean of its wave within 4 of 0.7 / √180, and up to 0.13 % of it is smoothed away;
    the straight lines between sectors lose as much again."""
    time, angle, wrench, noise = turning()
    track = split(time, angle, wrench)
    middles = (np.arange(SECTORS) + 0.5) * 2 * np.pi / SECTORS
    tolerance = 4 * NOISE / np.sqrt(len(time) / SECTORS) + 0.006 * WAVE.max()
    np.testing.assert_allclose(track.wave, waves(middles), atol=tolerance)
    np.testing.assert_allclose(track.at_angles(angle), waves(angle), atol=tolerance)
    np.testing.assert_allclose(track.rest, noise, atol=tolerance)
    np.testing.assert_allclose(track.at_angles(angle) + track.at_times(time - time[0]), wrench, atol=1e-12)


def test_where_a_track_ends_it_runs_back():
    time, angle, wrench, _ = turning()
    track = split(time, angle, wrench)
    end = track.time[-1]
    np.testing.assert_array_equal(track.at_times(track.time), track.rest)
    np.testing.assert_array_equal(track.at_times(end + track.time[:-1]), track.rest[::-1][:-1])
    np.testing.assert_array_equal(track.at_times(2 * end + track.time[1:50]), track.rest[1:50])


def test_a_wheel_that_stands_has_one_offset_and_one_that_rolls_a_wave():
    """Of 400 s, what goes with time leaves a mean of 4 times 0.7 / √6500 at most."""
    track = split(*turning()[:3])
    standing = with_sensor_track(still(400.0), track, {"left": 0.3}).arms["left"].wrench
    np.testing.assert_allclose(standing.mean(axis=0), track.at_angles(np.zeros(1))[0], atol=0.05)
    np.testing.assert_allclose(standing.std(axis=0), NOISE, rtol=0.05)
    log = rolling(0.8, 400.0, heading=2.0)
    felt = with_sensor_track(log, track, {"left": 0.3}).arms["left"].wrench
    turned = 0.8 * log.time / 0.3
    for k in range(6):
        wave = np.exp(-1j * turned) @ felt[:, k] * 2 / len(turned)
        assert abs(wave) == pytest.approx(WAVE[k], abs=0.1)


def test_it_is_scaled_by_component_and_added_to_the_arms_that_are_named():
    log, track = parabola(np.arange(500) / 100), split(*turning()[:3])
    one = with_sensor_track(log, track, {"left": 0.3}, start=2.0).arms["left"].wrench - log.arms["left"].wrench
    scale = np.array([2.0, 0.0, 1.0, 0.0, 0.0, -1.0])
    scaled = with_sensor_track(log, track, {"left": 0.3}, scale, start=2.0).arms["left"].wrench
    np.testing.assert_allclose(scaled - log.arms["left"].wrench, scale * one, atol=1e-12)
    nobody = with_sensor_track(log, track, {})
    np.testing.assert_array_equal(nobody.table, log.table)
    assert np.abs(one).max() > 1


def test_what_goes_with_time_begins_where_it_is_told_to():
    log, track = still(8.0), split(*turning()[:3])
    early, late = (with_sensor_track(log, track, {"left": 0.3}, start=s).arms["left"].wrench for s in (2.0, 5.0))
    np.testing.assert_array_equal(early[300:], late[:-300])
    assert np.abs(early - late).max() > 1


def test_the_way_is_along_the_heading_and_counts_down_backward():
    """A circle of 2 m, driven forward and back, chord by chord: short of the arc by (step/r)²/24."""
    time = np.linspace(0, 1, 401)
    arc = 3.0 * np.sin(np.pi * time)
    turned = 1.0 + arc / 2.0
    pose = np.column_stack([2 * np.sin(turned), -2 * np.cos(turned), np.angle(np.exp(1j * turned))])
    log = RunLog(time, pose, None, still(4.01).arms, "circle")
    np.testing.assert_allclose(travelled(log), arc, atol=1e-4)
    holes = pose.copy()
    holes[100:103] = np.nan
    np.testing.assert_allclose(travelled(RunLog(time, holes, None, log.arms, "circle")), arc, atol=1e-3)


def test_a_wheel_that_has_not_turned_once_is_refused():
    time, angle, wrench, _ = turning(turns=0.8)
    with pytest.raises(LogError, match="a whole turn"):
        split(time, angle, wrench)


def test_another_table_is_refused_by_its_columns(tmp_path):
    path = tmp_path / "track.csv"
    path.write_text("t,fx\n0,1\n")
    with pytest.raises(LogError, match=",".join(COLUMNS)):
        read_sensor_track(path)


@needs_data
def test_the_real_track_has_the_sizes_that_are_known_of_it():
    """A wave of 5.7 N in fx and fy, and 0.6 to 0.8 N beside it; means of 36 sectors leave a little less."""
    track = read_sensor_track(TRACK)
    once_a_turn = 2 / SECTORS * np.abs(np.fft.fft(track.wave, axis=0)[1])
    np.testing.assert_allclose(once_a_turn[:2], 5.7, atol=0.1)
    rest = track.rest[:, :3].std(axis=0)
    assert (rest > 0.5).all()
    assert (rest < 0.8).all()
