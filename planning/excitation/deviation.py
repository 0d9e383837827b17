"""A small departure from a reference that comes back to it: smooth offsets along and across the path.

With (x, y)(t) the offset of the axle's middle in the reference's frame, and (u, r) the reference's velocities, the axle
moves at

    v = (u + x' - r y, r x + y'),

so the cart, which can't slip, drives at |v| with its heading turned by a = atan2(v_y, v_x): its yaw rate is r + a'.
Offsets are bounded by their amplitudes, and they and three of their derivatives vanish at both ends. Where the
reference's accelerations are steady the motion is smooth; a step of them while the offset isn't zero is left out of the
yaw acceleration, so deviations belong into steady stretches (`steady_part`).
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from cartgrasp.constraints import RollingConstraints
from cartgrasp.errors import UsageError
from cartgrasp.frames import Array, rotation_planar
from cartgrasp.motion import Reference
from cartgrasp.roles import ReferencePath

DERIVATIVE_ORDERS = 4
ACCELERATION_CHECK_INTERVAL = 0.02  # s, between looks for steps of acceleration
_HARMONICS = np.arange(-2, 3)
_SIN4 = np.array([1.0, -4.0, 6.0, -4.0, 1.0]) / 16  # sin⁴(pi s) = sum of these times exp(2 pi i j s)


@dataclass(frozen=True)
class Wave:
    """`amplitude * sin⁴(pi s) * sin(2 pi swings s)` over s from 0 to 1; with no swings, `amplitude * sin⁴(pi s)`."""

    amplitude: float = 0.0
    swings: int = 0

    def derivatives(self, s: Array, duration: float) -> Array:
        """Value and three derivatives by time, (..., 4); zero outside."""
        speeds = 2j * np.pi * (_HARMONICS + self.swings)
        turn = -1j if self.swings else 1.0
        waves = np.exp(speeds * np.asarray(s)[..., None]) * _SIN4
        powers = (speeds / duration) ** np.arange(DERIVATIVE_ORDERS)[:, None]
        values = self.amplitude * (turn * waves @ powers.T).real
        inside = (np.asarray(s) > 0) & (np.asarray(s) < 1)
        return np.asarray(np.where(inside[..., None], values, 0.0))


@dataclass(frozen=True)
class Deviation:
    """From `start` for `duration` (s), offsets (m) along and across the reference."""

    start: float
    duration: float
    along: Wave = Wave()
    across: Wave = Wave()

    def offsets(self, times: Array) -> Array:
        """(x, y) with three derivatives, (..., 2, 4)."""
        s = (np.asarray(times) - self.start) / self.duration
        return np.stack([wave.derivatives(s, self.duration) for wave in (self.along, self.across)], axis=-2)


@dataclass(frozen=True)
class DeviatedReference:
    """A reference with deviations, for a cart with one rolling constraint."""

    base: ReferencePath
    deviations: tuple[Deviation, ...]
    constraints: RollingConstraints = RollingConstraints()

    def __post_init__(self) -> None:
        spans = sorted((d.start, d.start + d.duration) for d in self.deviations)
        if any(stop > start + 1e-9 for (_, stop), (start, _) in pairwise(spans)):
            raise UsageError("deviations: two of them overlap")

    @property
    def duration(self) -> float:
        return self.base.duration

    def at(self, time: float) -> Reference:
        reference = self.base.at(time)
        found = [d for d in self.deviations if d.start < time < d.start + d.duration]
        if not found:
            return reference
        offsets = found[0].offsets(np.array(time))
        turned, velocity, acceleration = deviated(reference.velocity, reference.acceleration, offsets)
        to_axle = np.array([self.constraints.axle_x or 0.0, 0.0])
        turned_offset = rotation_planar(self.constraints.angle) @ offsets[:, 0]
        heading = reference.pose_sb[2]
        axle = reference.pose_sb[:2] + rotation_planar(heading) @ (to_axle + turned_offset)
        heading = heading + float(turned)
        origin = axle - rotation_planar(heading) @ to_axle
        return Reference(time, np.array([*origin, heading]), velocity, acceleration)


def deviated(velocity: Array, acceleration: Array, offsets: Array) -> tuple[Array, Array, Array]:
    """Change of heading (...), velocity (..., 2) and acceleration (..., 2) of a reference's (u, r) and (u', r') with
    offsets (..., 2, 4)."""
    (u, r), (du, dr) = np.moveaxis(velocity, -1, 0), np.moveaxis(acceleration, -1, 0)
    x, y = np.moveaxis(offsets, (-1, -2), (0, 1)).swapaxes(0, 1)
    vx, vy = u + x[1] - r * y[0], r * x[0] + y[1]
    ax, ay = du + x[2] - dr * y[0] - r * y[1], dr * x[0] + r * x[1] + y[2]
    bx, by = x[3] - 2 * dr * y[1] - r * y[2], 2 * dr * x[1] + r * x[2] + y[3]
    direction = np.where(vx < 0, -1.0, 1.0)
    square = np.maximum(vx**2 + vy**2, np.finfo(float).tiny)
    along, across = vx * ax + vy * ay, vx * ay - vy * ax
    turning = (vx * by - vy * bx) / square - 2 * across * along / square**2
    speed = np.sqrt(square)
    new_velocity = np.stack([direction * speed, r + across / square], axis=-1)
    new_acceleration = np.stack([direction * along / speed, dr + turning], axis=-1)
    return np.arctan2(direction * vy, direction * vx), new_velocity, new_acceleration


def steady_part(reference: ReferencePath, start: float, stop: float) -> tuple[float, float]:
    """The longest part of a window in which the reference's accelerations stay as they are."""
    times = np.linspace(start, stop, max(2, int(np.ceil((stop - start) / ACCELERATION_CHECK_INTERVAL))) + 1)[1:-1]
    accelerations = np.array([reference.at(time).acceleration for time in times])
    steps = np.flatnonzero(np.abs(np.diff(accelerations, axis=0)).max(axis=1) > 1e-9)
    edges = np.concatenate([[start], times[steps + 1], [stop]])
    before = np.concatenate([times[steps], [stop]])
    longest = int((before - edges[:-1]).argmax())
    return float(edges[longest]), float(before[longest])
