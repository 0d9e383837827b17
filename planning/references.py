"""References that obey the rolling constraint: speed and yaw rate as time passes, pose by integration.

A `Stretch` holds constant accelerations of u and r, so u and r are piecewise linear and theta is piecewise
quadratic; x and y are its integrals by Gauss-Legendre quadrature. A cart's {b} origin that is not on the axle moves
sideways by the constraint, `(u, w, r) = S_b nu`; u is the speed along the wheels' rolling.
"""

from __future__ import annotations

import math
from bisect import bisect_left, bisect_right
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import accumulate, pairwise
from typing import NamedTuple

import numpy as np

from cartgrasp.checks import angle as checked_angle
from cartgrasp.checks import check_kind, listed, number, pose, positive
from cartgrasp.constraints import RollingConstraints
from cartgrasp.errors import UsageError
from cartgrasp.frames import Array
from cartgrasp.motion import Reference
from cartgrasp.reference_file import MAX_STRETCH_ACCELERATION, MAX_STRETCH_DURATION, Stretch

__all__ = ["PathReference", "Stretch", "chain", "pause", "speed_change", "straight", "turn"]

KNOT_SPACING = 0.05
MAX_STRETCH_SPEED = 50.0
"""m/s or rad/s: what is beyond is a slip of units."""
GAUSS_LEGENDRE = tuple(zip(*(part.tolist() for part in np.polynomial.legendre.leggauss(5)), strict=True))
"""Nodes in [-1, 1] and weights, of Gauss and Legendre."""


class _Piece(NamedTuple):
    """A stretch with what it begins at: time, speed, yaw rate and heading."""

    begin: float
    speed: float
    yaw_rate: float
    heading: float
    acceleration: float
    yaw_acceleration: float

    def rates(self, time: float) -> tuple[float, float]:
        """u and r."""
        elapsed = time - self.begin
        return self.speed + self.acceleration * elapsed, self.yaw_rate + self.yaw_acceleration * elapsed

    def heading_at(self, time: float) -> float:
        elapsed = time - self.begin
        return self.heading + elapsed * (self.yaw_rate + elapsed * self.yaw_acceleration / 2)


@dataclass(frozen=True)
class PathReference:
    """A sequence of stretches from rest to rest; after its end the last pose is held.

    Args:
        stretches: Of constant accelerations, made by `chain(straight(…), turn(…), …)`.
        constraints: Those of the cart that shall follow.
        start_pose: (x, y, theta) of {b} in {s}, m and rad.

    Raises:
        UsageError: No stretch, one without duration, an end that is no rest, or a turn on a rail.

    Example:
        >>> from planning import PathReference, chain, speed_change, turn
        >>> path = PathReference(chain(speed_change(0.6), turn(1.57, 0.4), speed_change(-0.6)))
        >>> round(path.duration, 2), path.at(path.duration).pose_sb.round(2).tolist()
        (7.12, [2.11, 2.1, 1.57])
    """

    stretches: tuple[Stretch, ...]
    constraints: RollingConstraints = RollingConstraints()
    start_pose: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        cure = "write chain(straight(distance, speed), turn(angle, yaw_rate), …)"
        object.__setattr__(self, "stretches", listed("reference: stretches", self.stretches, Stretch, cure))
        check_kind("reference: constraints", self.constraints, RollingConstraints, "give those of your cart")
        object.__setattr__(self, "start_pose", pose("reference: start_pose", self.start_pose))
        if not self.stretches or any(s.duration <= 0 for s in self.stretches):
            raise UsageError("reference: every stretch needs a duration above 0 s, and there must be one")
        u, r = self._pieces[-1].speed, self._pieces[-1].yaw_rate
        if abs(u) > 1e-9 or abs(r) > 1e-9:
            raise UsageError(f"reference: ends with u = {u:g} m/s, r = {r:g} rad/s; it must end at rest")
        if self.constraints.no_rotation and any(s.yaw_acceleration for s in self.stretches):
            raise UsageError("reference: a cart on a rail can't turn")

    @property
    def duration(self) -> float:
        return self._times[-1]

    def at(self, time: float) -> Reference:
        """The reference at a time; clamped to start and end."""
        clamped = min(max(number("reference: time", time, cure="give s"), 0.0), self.duration)
        knot = min(int(clamped / KNOT_SPACING), len(self._knots) - 1)
        pose = self._knots[knot] + self._travel(knot * KNOT_SPACING, clamped)
        pose[:2] += self.start_pose[:2]
        piece = self._pieces[min(bisect_right(self._times, clamped), len(self._pieces)) - 1]
        u, r, du, dr = *piece.rates(clamped), piece.acceleration, piece.yaw_acceleration
        if not 0.0 <= time < self.duration:
            du = dr = 0.0
            u, r = (0.0, 0.0) if time >= self.duration else (u, r)
        free = [0, 1, 2] if self.constraints.axle_x is None else [0, 2][: self.constraints.n_free]
        return Reference(time, pose, np.array([u, 0.0, r])[free], np.array([du, 0.0, dr])[free])

    @cached_property
    def _times(self) -> list[float]:
        """When each stretch begins, and the end."""
        return [0.0, *accumulate(stretch.duration for stretch in self.stretches)]

    @cached_property
    def _pieces(self) -> tuple[_Piece, ...]:
        """The stretches, and one of no length at the end."""
        u, r, heading, pieces = 0.0, 0.0, self.start_pose[2], []
        for begin, stretch in zip(self._times, (*self.stretches, Stretch(0.0)), strict=True):
            pieces.append(_Piece(begin, u, r, heading, stretch.acceleration, stretch.yaw_acceleration))
            heading += stretch.duration * (r + stretch.duration * stretch.yaw_acceleration / 2)
            u, r = u + stretch.duration * stretch.acceleration, r + stretch.duration * stretch.yaw_acceleration
        return tuple(pieces)

    @cached_property
    def _knots(self) -> Array:
        """Pose at multiples of the knot spacing, from the start position, (k, 3)."""
        times = np.arange(0.0, self.duration + KNOT_SPACING, KNOT_SPACING)
        times = times[times <= self.duration]
        poses = np.zeros((len(times), 3))
        poses[0, 2] = self.start_pose[2]
        for k in range(1, len(times)):
            poses[k] = poses[k - 1] + self._travel(times[k - 1], times[k])
        return poses

    def _travel(self, begin: float, end: float) -> Array:
        """Change of pose (3,) between two times inside the path, by quadrature over each stretch between them."""
        x = y = turned = 0.0
        first, last = bisect_right(self._times, begin), bisect_left(self._times, end)
        limits = [begin, *self._times[first:last], end]
        for piece, (low, high) in zip(self._pieces[first - 1 :], pairwise(limits), strict=False):
            half = (high - low) / 2
            for node, weight in GAUSS_LEGENDRE:
                time = low + half * (1 + node)
                u, r = piece.rates(time)
                forward, aside = self._free(u, r)
                heading, share = piece.heading_at(time), half * weight
                cosine, sine = math.cos(heading), math.sin(heading)
                x, y = x + share * (cosine * forward - sine * aside), y + share * (sine * forward + cosine * aside)
                turned += share * r
        return np.array([x, y, turned])

    def _free(self, u: float, r: float) -> tuple[float, float]:
        """Velocity of {b}'s origin along x and y: u is along the wheels' rolling."""
        if self.constraints.axle_x is None:
            return u, 0.0
        angle = self.constraints.angle
        return math.cos(angle) * u, math.sin(angle) * u - self.constraints.axle_x * r


def straight(distance: float, speed: float, acceleration: float = 0.5) -> list[Stretch]:
    """From rest to rest along a line with steps of acceleration; a negative distance drives backward, none
    is no stretch."""
    distance = number("straight: distance", distance, -MAX_STRETCH_DURATION, MAX_STRETCH_DURATION, "give m")
    _check_rates("straight", speed, acceleration, ("m/s", "m/s²"))
    direction, distance = float(np.sign(distance)), abs(distance)
    ramp = min(speed / acceleration, (distance / acceleration) ** 0.5)
    if not ramp:
        return []
    cruise = (distance - acceleration * ramp**2) / (acceleration * ramp)
    stretches = [Stretch(ramp, direction * acceleration), Stretch(ramp, -direction * acceleration)]
    return stretches if cruise <= 1e-9 else [stretches[0], Stretch(cruise), stretches[1]]


def turn(angle: float, yaw_rate: float, yaw_acceleration: float = 0.5) -> list[Stretch]:
    """A curve by `angle` (rad) at the speed one has: yaw rate ramps up, holds, ramps down; no angle is no
    stretch."""
    direction, angle = float(np.sign(checked_angle("turn: angle", angle))), abs(angle)
    _check_rates("turn", yaw_rate, yaw_acceleration, ("rad/s", "rad/s²"))
    ramp = min(yaw_rate / yaw_acceleration, (angle / yaw_acceleration) ** 0.5)
    if not ramp:
        return []
    hold = (angle - yaw_acceleration * ramp**2) / (yaw_acceleration * ramp)
    up, down = Stretch(ramp, 0.0, direction * yaw_acceleration), Stretch(ramp, 0.0, -direction * yaw_acceleration)
    return [up, down] if hold <= 1e-9 else [up, Stretch(hold), down]


def _check_rates(what: str, speed: float, acceleration: float, units: tuple[str, str]) -> None:
    positive(f"{what}: speed", speed, MAX_STRETCH_SPEED, f"give {units[0]}")
    positive(f"{what}: acceleration", acceleration, MAX_STRETCH_ACCELERATION, f"give {units[1]}")


def speed_change(change: float, acceleration: float = 0.5) -> list[Stretch]:
    """A step of acceleration that changes the forward speed by `change` (m/s)."""
    _check_rates(
        "speed_change",
        abs(number("speed_change: change", change, -MAX_STRETCH_SPEED, MAX_STRETCH_SPEED, "give m/s")),
        acceleration,
        ("m/s", "m/s²"),
    )
    return [Stretch(abs(change) / acceleration, float(np.sign(change)) * acceleration)]


def pause(duration: float) -> list[Stretch]:
    """Keep speed and yaw rate (from rest: stand still)."""
    return [Stretch(duration)]


def chain(*parts: Sequence[Stretch]) -> tuple[Stretch, ...]:
    """One sequence of several manoeuvres."""
    return tuple(stretch for part in parts for stretch in part)
