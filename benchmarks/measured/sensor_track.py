"""What a real force sensor says on a wheel that nobody touches, put under the wrenches of a made log.

The track is split in two: what follows the wheel's angle (an offset, and a wave once a turn) is the mean over its turns
and goes with the distance that the cart travels; the rest goes with time. No formula makes either.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from cartgrasp.errors import LogError, Place
from cartgrasp.frames import Array
from cartgrasp.logs import ArmLog, RunLog

COLUMNS = ("t", "angle_deg", "fx", "fy", "fz", "mx", "my", "mz")
SECTORS = 36
"""Of a turn: narrow enough for a wave of a few periods a turn, wide enough for many rows in each."""


@dataclass(frozen=True)
class SensorTrack:
    """`wave` (SECTORS, 6) at the middles of the sectors of a turn, and the `rest` (n, 6) at `time` (n,), s from 0.
    Force (N), then moment (N·m)."""

    wave: Array
    time: Array
    rest: Array

    def at_angles(self, angle: Array) -> Array:
        """(n, 6), of how far the wheel has turned, rad."""
        middles = (np.arange(SECTORS) + 0.5) * 2 * np.pi / SECTORS
        return np.column_stack([np.interp(angle, middles, column, period=2 * np.pi) for column in self.wave.T])

    def at_times(self, time: Array) -> Array:
        """(n, 6); the nearest row's, as one in between would be quieter. Where the track ends it runs back, so that it
        never jumps."""
        end = self.time[-1]
        folded = end - np.abs(end - time % (2 * end))
        middles = (self.time[1:] + self.time[:-1]) / 2
        return np.asarray(self.rest[np.searchsorted(middles, folded)])


def read_sensor_track(path: Path) -> SensorTrack:
    """Of a table with COLUMNS; the angle may wrap."""
    header, *rows = path.read_text(encoding="utf-8").splitlines()
    if tuple(header.split(",")) != COLUMNS:
        raise LogError(Place(str(path), 1), "", f"the columns of a sensor's track are {','.join(COLUMNS)}")
    table = np.loadtxt(rows, delimiter=",", ndmin=2)
    return split(table[:, 0], np.radians(table[:, 1]), table[:, 2:])


def split(time: Array, angle: Array, wrench: Array) -> SensorTrack:
    """The track of times (n,), angles (n,) in rad and wrenches (n, 6); each sector of a turn must have been seen."""
    sector = np.floor(angle % (2 * np.pi) * SECTORS / (2 * np.pi)).astype(int) % SECTORS
    count = np.bincount(sector, minlength=SECTORS)
    if not count.all():
        raise LogError(Place("sensor track"), "angle_deg", "the wheel has not turned once; record a whole turn or more")
    wave = np.column_stack([np.bincount(sector, column, SECTORS) / count for column in wrench.T])
    track = SensorTrack(wave, time - time[0], wrench)
    return replace(track, rest=wrench - track.at_angles(angle))


def with_sensor_track(
    log: RunLog, track: SensorTrack, radius: Mapping[str, float], scale: ArrayLike = 1.0, start: float = 0.0
) -> RunLog:
    """The log with the track added to the wrenches of the arms in `radius` (m, of the wheel that their sensor is taken
    to turn with), so many times as large, one number or (6,); the rest of it from `start` (s) of the track on."""
    way, since = travelled(log), log.time - log.time[0] + start
    arms = dict(log.arms)
    for name, r in radius.items():
        added = np.asarray(scale) * (track.at_angles(way / r) + track.at_times(since))
        arms[name] = ArmLog(arms[name].contact, arms[name].wrench + added)
    return replace(log, arms=arms)


def travelled(log: RunLog) -> Array:
    """(n,) m that {b}'s origin has rolled along its heading; backward counts down, and a missing pose not at all."""
    seen = np.isfinite(log.pose).all(axis=1)
    x, y, theta = log.pose[seen].T
    theta = np.unwrap(theta)
    heading = (theta[1:] + theta[:-1]) / 2
    steps = np.cos(heading) * np.diff(x) + np.sin(heading) * np.diff(y)
    way = np.concatenate([[0.0], np.cumsum(steps)])
    return np.asarray(np.interp(log.time, log.time[seen], way))
