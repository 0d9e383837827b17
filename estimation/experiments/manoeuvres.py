"""Manoeuvres that a robot can follow and a person can say: pieces from rest to rest, one after the other."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from itertools import groupby

import numpy as np

from cartgrasp.constraints import RollingConstraints
from cartgrasp.errors import UsageError
from cartgrasp.frames import Array, body_to_world
from cartgrasp.reference_file import Stretch

MANOEUVRE_TIME_STEP = 0.02
"""s: ramps and holds are whole multiples, and motions are looked at so often."""
HOLD_DURATION, REST_DURATION = 1.6, 0.3
"""How long a motion is held, and how long a rest lasts, s."""
SLOW_SPEED_RATIO = 0.3
"""The slow speed, as a share of the highest one."""
ACCELERATION, YAW_ACCELERATION = 0.6, 1.0
MAX_YAW_RATE, YAW_RATE_PER_SPEED = 0.6, 0.8
"""rad/s; rad/m."""
SPEED_BOUNDS, MIN_EXPERIMENT_DURATION, MAX_EXPERIMENT_DURATION = (0.05, 3.0), 8.0, 600.0
COUNT_WORDS = ("", "twice", "three times", "four times")


@dataclass(frozen=True)
class Limits:
    """The limits of a manoeuvre: its highest speed (m/s), and how long it may take (s)."""

    speed: float = 0.8
    duration: float = 20.0

    def __post_init__(self) -> None:
        low, high = SPEED_BOUNDS
        if not low <= self.speed <= high:
            raise UsageError(f"limits of a manoeuvre: speed {self.speed:g} m/s: give {low:g} to {high:g}")
        if not MIN_EXPERIMENT_DURATION <= self.duration <= MAX_EXPERIMENT_DURATION:
            raise UsageError(
                f"limits of a manoeuvre: duration {self.duration:g} s: give {MIN_EXPERIMENT_DURATION:g} to "
                f"{MAX_EXPERIMENT_DURATION:g}"
            )

    @property
    def yaw_rate(self) -> float:
        return min(MAX_YAW_RATE, YAW_RATE_PER_SPEED * self.speed)


@dataclass(frozen=True)
class Piece:
    """A motion from rest to rest; `says` tells what to do."""

    says: str
    stretches: tuple[Stretch, ...] = field(repr=False)

    @property
    def duration(self) -> float:
        return sum(stretch.duration for stretch in self.stretches)


@dataclass(frozen=True, eq=False)
class Place:
    """Where a cart rests: its pose (3,), what its effects remember (k,), and the time (s)."""

    pose: Array
    memory: Array
    time: float


def pieces(limits: Limits, constraints: RollingConstraints) -> tuple[Piece, ...]:
    """What a cart with these constraints can do, from the simplest on."""
    fast, slow, rate = limits.speed, SLOW_SPEED_RATIO * limits.speed, limits.yaw_rate
    found = [
        Piece(f"roll {way} at {speed:.2g} m/s", _held(sign * speed, 0.0))
        for speed in (slow, fast)
        for way, sign in (("forwards", 1.0), ("backwards", -1.0))
    ]
    found.append(Piece("push it to and fro", _swung(fast / 2, 0.0)))
    if not constraints.no_rotation:
        found += [Piece(f"turn {side} on the spot", _held(0.0, sign * rate)) for side, sign in SIDES]
        found.append(Piece("turn to and fro on the spot", _swung(0.0, rate)))
        found += [
            Piece(f"curve {side} {way} at {fast:.2g} m/s", _held(along * fast, along * sign * rate))
            for way, along in (("forwards", 1.0), ("backwards", -1.0))
            for side, sign in SIDES
        ]
    return tuple(found)


SIDES = (("left", 1.0), ("right", -1.0))


def said(parts: Sequence[Piece]) -> str:
    """One after the other, in words."""
    counted = [(says, len(list(same))) for says, same in groupby(part.says for part in parts)]
    return ", ".join(
        f"{says} {COUNT_WORDS[n - 1] if n <= len(COUNT_WORDS) else f'{n} times'}".rstrip() for says, n in counted
    )


def sampled(piece: Piece) -> tuple[Array, Array, Array]:
    """Times (n,) since its beginning, (u, w, r) and their rates (n, 3), in the middles of steps."""
    n = round(piece.duration / MANOEUVRE_TIME_STEP)
    time = np.asarray(MANOEUVRE_TIME_STEP * (np.arange(n) + 0.5), dtype=float)
    edges = np.cumsum([0.0, *(stretch.duration for stretch in piece.stretches)])
    rates = np.array([[one.acceleration, 0.0, one.yaw_acceleration] for one in piece.stretches])
    starts: Array = np.vstack([np.zeros(3), np.cumsum(rates * np.diff(edges)[:, None], axis=0)])
    where = np.searchsorted(edges[1:-1], time, side="right")
    velocity = np.asarray(starts[where] + rates[where] * (time - edges[where])[:, None])
    return time, velocity, np.asarray(rates[where])


def path(velocity_b: Array, start: Array) -> tuple[Array, Array]:
    """Poses (n, 3) in the middles of steps of a velocity (n, 3) in {b}, and the last one (3,), from a start (3,)."""
    turned = start[2] + MANOEUVRE_TIME_STEP * np.cumsum(velocity_b[:, 2])
    heading = turned - MANOEUVRE_TIME_STEP * velocity_b[:, 2] / 2
    moved = MANOEUVRE_TIME_STEP * (body_to_world(heading) @ velocity_b[..., None])[..., 0]
    there = start[:2] + np.cumsum(moved[:, :2], axis=0)
    middles = np.column_stack([there - moved[:, :2] / 2, heading])
    return middles, np.array([*there[-1], turned[-1]])


def _held(speed: float, yaw_rate: float) -> tuple[Stretch, ...]:
    """Up to a speed and a yaw rate, along there, and down to a short rest."""
    up, down = _ramps(speed, yaw_rate)
    return up, Stretch(HOLD_DURATION), down, Stretch(REST_DURATION)


def _swung(speed: float, yaw_rate: float) -> tuple[Stretch, ...]:
    """There, back, and there again."""
    up, down = _ramps(speed, yaw_rate)
    there, back = (replace(one, duration=2 * one.duration) for one in (up, down))
    return up, back, there, back, up, Stretch(REST_DURATION)


def _ramps(speed: float, yaw_rate: float) -> tuple[Stretch, Stretch]:
    """From rest to a speed and a yaw rate, and back, in whole steps."""
    least = max(abs(speed) / ACCELERATION, abs(yaw_rate) / YAW_ACCELERATION)
    duration = round(MANOEUVRE_TIME_STEP * math.ceil(least / MANOEUVRE_TIME_STEP - 1e-9), 6)
    rates = speed / duration, yaw_rate / duration
    return Stretch(duration, *rates), Stretch(duration, -rates[0], -rates[1])
