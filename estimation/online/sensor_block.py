"""Means over a block of samples, by which `sensor_monitor.py` asks whether sensors mean what they say."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple, TypeVar

import numpy as np

from cartgrasp.frames import Array, wrap_angle
from cartgrasp.motion import Measurement

HEADING_FACTORS = (1.0, math.pi / 180, -1.0)
"""What recorded headings are multiplied by: as they are, of degrees, of the other sense."""
MAX_NOISE_INTERVAL = 0.015
"""s between velocities, up to which second differences are noise: a loop at 50 Hz moves a cart between samples."""
MEDIAN_PER_STD = 0.6745
"""The median magnitude of a standard normal number."""
MIN_NOISE_VELOCITIES = 8
"""Velocities that tell their noise."""
SENSOR_BLOCK_DURATION = 0.25
"""s, of a block."""
MAX_BLOCK_SAMPLES = 64
"""Samples of each sensor that are looked at."""
MIN_JUMP_STEPS = 8
"""Steps from pose to pose that tell a jump: of a cart that starts with the way growing as t³, fewer do so, too."""
MAX_MEASURED_VALUE = 1e9
"""SI: beyond, nothing was measured."""
FULL_TURN = 2.0 * math.pi
T = TypeVar("T")


class SensorBlock(NamedTuple):
    """Times (s) and poses (n, 4); their mean time, where {b} was (2,), and the heading by HEADING_FACTORS (3,). The
    mean velocity (3,) in {s}, and the mean wrenches (3,) of the arms in {b}, or None; and variances (2,) of white noise
    of a sample's velocity, linear and yaw, None where they can't be told."""

    poses: Array
    time: float
    place: list[float]
    headings: list[float]
    velocity: list[float] | None
    wrenches_b: list[list[float]] | None
    noise: tuple[float, float] | None


class SampleBuffer:
    """Samples until they are looked at, in blocks that end as long ago as samples come late."""

    def __init__(self) -> None:
        self._noted: list[Measurement] = []
        self._end, self._lateness = -math.inf, 0.0
        self.due = -math.inf
        """s: when there is a block."""

    def note(self, measurement: Measurement, newest: float) -> None:
        """A sample, where the newest is of that time (s)."""
        self._noted.append(measurement)
        late = newest - measurement.time
        if late > self._lateness:
            self.due, self._lateness = self.due + late - self._lateness, late

    def block_at(self, time: float) -> list[Measurement]:
        """What is of before a time (s), by as much as samples come late; it is handed over once."""
        noted = sorted(self._noted, key=lambda one: one.time) if self._lateness else self._noted
        self._end = end = time - self._lateness
        self._noted = [one for one in noted if one.time > end]
        return [one for one in noted if one.time <= end]

    def begin(self) -> None:
        """The next block, after the last one."""
        self.due = self._end + self._lateness + SENSOR_BLOCK_DURATION


def wrapped(angle: float) -> float:
    """The angle (rad) wrapped to [-pi, pi)."""
    return (angle + math.pi) % FULL_TURN - math.pi


def poses_jump(first: SensorBlock, last: SensorBlock) -> bool:
    """Whether positions or headings jump, to and fro or for good: beside the two longest steps, all others together are
    shorter than what the longest is too long. So quickly no cart is sped up that is seen often enough."""
    rows = np.concatenate([first.poses, last.poses])
    time, x, y, turn = np.diff(rows, axis=0).T
    if len(time) < MIN_JUMP_STEPS:
        return False
    for way in (np.hypot(x, y), np.abs(wrap_angle(turn))):
        order = np.argsort(way)
        longest, others = order[-1], order[:-2]
        gone, lasting = float(way[others].sum()), float(time[others].sum())
        if way[longest] - gone * time[longest] / lasting > gone:
            return True
    return False


def poses_of(samples: Sequence[Measurement]) -> tuple[Array, float, list[float], list[float]] | None:
    """Times and poses, their mean time, place and headings; None where no pose is whole."""
    seen = _thinned([(m.time, m.pose) for m in samples if m.pose is not None])
    rows = _whole([(time, *pose) for time, pose in seen])
    if rows is None:
        return None
    times, poses = rows[:, 0].tolist(), rows[:, 1:]
    first, *turned = poses[:, 2].tolist()
    x, y, _ = poses.sum(axis=0).tolist()
    n, headings = len(times), []
    for factor in HEADING_FACTORS:
        off = sum([(factor * (one - first) + math.pi) % FULL_TURN for one in turned]) - math.pi * len(turned)
        headings.append(factor * first + off / n)
    return rows, sum(times) / n, [x / n, y / n], headings


def velocities_of(samples: Sequence[Measurement]) -> tuple[list[float] | None, tuple[float, float] | None]:
    """The mean velocity, and the variances of its white noise: from second differences of those that follow each other,
    which motion has no share in."""
    seen = [m for m in samples if m.velocity is not None]
    rows = _whole([m.velocity for m in _thinned(seen)])
    if rows is None:
        return None, None
    noise, first = None, seen[:MAX_BLOCK_SAMPLES]
    near = rows if len(first) == len(seen) else _whole([m.velocity for m in first])
    if (
        near is not None
        and len(near) >= MIN_NOISE_VELOCITIES
        and first[-1].time - first[0].time < MAX_NOISE_INTERVAL * len(near)
    ):
        jumps = np.abs(near[2:] - 2.0 * near[1:-1] + near[:-2])
        jumps.sort(axis=0)
        x, y, yaw = (jumps[len(jumps) // 2] / MEDIAN_PER_STD).tolist()
        noise = (x * x + y * y) / 12.0, yaw * yaw / 6.0
    return _mean(rows), noise


def wrenches_of(
    samples: Sequence[Measurement], contacts: Mapping[str, Array], arms: Sequence[str], yaws: Mapping[str, float]
) -> list[list[float]] | None:
    """The mean planar wrench (3,) of each arm in {b}; None where one of them, or where it holds, is not known."""
    found = list[list[float]]()
    for arm in arms:
        told = _thinned([m.wrenches[arm] for m in samples if arm in m.wrenches])
        rows = _whole([(wrench[0], wrench[1], wrench[5]) for wrench in told])
        if rows is None or arm not in contacts:
            return None
        (fx, fy, tz), (x, y, *_) = _mean(rows), contacts[arm]
        cosine, sine = math.cos(yaws.get(arm, 0.0)), math.sin(yaws.get(arm, 0.0))
        fx, fy = cosine * fx - sine * fy, sine * fx + cosine * fy
        found.append([fx, fy, float(x * fy - y * fx) + tz])
    return found or None


def _thinned(rows: Sequence[T]) -> Sequence[T]:
    """Evenly, of one sensor: sensors that take turns would be thinned to one of them."""
    return rows[:: max(1, math.ceil(len(rows) / MAX_BLOCK_SAMPLES))]


def _whole(rows: Sequence[Any]) -> Array | None:
    """The rows that are measurements (n, k), if any."""
    found = np.array(rows, dtype=float)
    if len(found) and not np.abs(found).max() < MAX_MEASURED_VALUE:
        found = found[(np.abs(found) < MAX_MEASURED_VALUE).all(axis=1)]
    return found if len(found) else None


def _mean(rows: Array) -> list[float]:
    return [one / len(rows) for one in rows.sum(axis=0).tolist()]
