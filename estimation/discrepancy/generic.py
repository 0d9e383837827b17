"""What a residual depends on, in the world's terms: time, distance, heading, speed, place.

Families of smooth functions, none of them an effect, are fitted to the means of short stretches. What a family takes
away is judged by Schwarz's criterion, which needs no size of the noise.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from cartgrasp.frames import Array

from ..batch.motion_smoother import SmoothMotion
from .fitted import Scatter

FREQUENCIES = np.geomspace(0.1, 4.0, 90)
"""Hz."""
WAVELENGTHS = np.geomspace(0.15, 6.0, 90)
"""m."""
LEVELS = 5
"""Of speed."""
DRIFT = 4
"""Slow waves over a log."""
LEAST_TURN = 2.0
"""Turns that something periodic takes, at least, in a log."""


@dataclass(frozen=True)
class Dependence:
    """A family's fit along one free direction: what it is called, its period and that period's unit where it has one,
    the log of its Bayes factor by Schwarz's criterion, and the share of the squares that it takes away."""

    name: str
    direction: int
    period: float | None
    unit: str
    log_factor: float
    share: float


@dataclass(frozen=True)
class Course:
    """Where the middles of stretches are (b,): time, distance rolled, heading, forward speed, yaw rate, pose."""

    time: Array
    distance: Array
    heading: Array
    speed: Array
    turning: Array
    place: Array
    since_reversal: Array

    @classmethod
    def of(cls, scatter: Scatter, motions: Sequence[SmoothMotion], duration: float) -> Course:
        parts = [_middles(motion, scatter.start[scatter.log == k] + duration / 2) for k, motion in enumerate(motions)]
        return cls(*(np.concatenate(columns) for columns in zip(*parts, strict=True)))


def dependences(scatter: Scatter, course: Course) -> list[Dependence]:
    """The best of each family, the most probable first."""
    found: dict[tuple[str, int], Dependence] = {}
    for i in range(scatter.mean.shape[1]):
        weight = scatter.information[:, i, i]
        value = scatter.mean[:, i] - np.average(scatter.mean[:, i], weights=weight)
        for name, unit, period, columns, tried in _families(course):
            factor, share = _judged(value, weight, columns, tried)
            best = found.get((name, i))
            if best is None or factor > best.log_factor:
                found[name, i] = Dependence(name, i, period, unit, factor, share)
    return sorted(found.values(), key=lambda one: -one.log_factor)


def _families(course: Course) -> Iterator[tuple[str, str, float | None, Array, int]]:
    """Name, unit of the period, period, columns (b, k), and how many periods are tried."""
    for frequency in FREQUENCIES:
        if frequency * np.ptp(course.time) > LEAST_TURN:
            yield "time, periodic", "s", 1 / frequency, _wave(frequency * course.time), len(FREQUENCIES)
    for length in WAVELENGTHS:
        if np.ptp(course.distance) > LEAST_TURN * length:
            yield "travelled distance, periodic", "m", length, _wave(course.distance / length), len(WAVELENGTHS)
    yield "heading", "", None, _wave(course.heading / (2 * np.pi)), 1
    yield "speed", "", None, _levels(course.speed), 1
    yield "yaw rate", "", None, _levels(course.turning), 1
    along = (course.time - course.time.min()) / max(float(np.ptp(course.time)), 1e-9)
    slow = np.column_stack([np.cos(np.pi * (k + 1) * along) for k in range(DRIFT)])
    yield "time, slowly", "", None, slow, 1
    place = course.place - course.place.mean(axis=0)
    scale = np.maximum(np.abs(place).max(axis=0), 1e-9)
    x, y = (place / scale).T
    yield "place", "", None, np.column_stack([x, y, x * y, x**2, y**2]), 1


def _judged(value: Array, weight: Array, columns: Array, tried: int) -> tuple[float, float]:
    root = np.sqrt(weight)[:, None]
    design = root * np.column_stack([np.ones(len(value)), columns])
    target = root[:, 0] * value
    left = target - design @ np.linalg.lstsq(design, target, rcond=1e-10)[0]
    before, after = float(target @ target), max(float(left @ left), 1e-300)
    n, k = len(value), columns.shape[1]
    share = 1 - after / max(before, 1e-300)
    factor = 0.5 * n * np.log(max(before, 1e-300) / after) - 0.5 * k * np.log(n) - np.log(tried)
    return float(factor), share


def _wave(turns: Array) -> Array:
    return np.column_stack([np.sin(2 * np.pi * turns), np.cos(2 * np.pi * turns)])


def _levels(values: Array) -> Array:
    edges = np.quantile(values, np.linspace(0, 1, LEVELS + 1)[1:-1])
    return np.eye(LEVELS)[np.searchsorted(edges, values)][:, 1:]


def _middles(motion: SmoothMotion, middle: Array) -> tuple[Array, ...]:
    time, speed = motion.time, motion.velocity[:, 0]
    steps = np.append(0.0, np.diff(time))
    distance = np.cumsum(np.abs(speed) * steps)
    turning = motion.velocity[:, -1] if motion.velocity.shape[1] > 1 else np.zeros(len(time))
    rolling = np.where(np.abs(speed) > 0.02, np.sign(speed), 0.0)
    last, reversed_at, at = 0.0, -np.inf, np.full(len(time), np.inf)
    for i in range(len(time)):
        if rolling[i] and rolling[i] != last:
            reversed_at = distance[i] if last else -np.inf
            last = rolling[i]
        at[i] = distance[i] - reversed_at
    rows = np.clip(np.searchsorted(time, middle), 0, len(time) - 1)
    columns = (distance, np.unwrap(motion.pose[:, 2]), speed, turning, motion.pose[:, :2], at)
    return middle, *(column[rows] for column in columns)
