"""References that obey the rolling constraint: speed and yaw rate as time passes, pose by integration.

A `Stretch` holds constant accelerations of u and r, so u and r are piecewise linear and theta is piecewise
quadratic; x and y are its integrals by Gauss-Legendre quadrature. A cart's {b} origin that is not on the axle moves
sideways by the constraint, `(u, w, r) = S_b nu`; u is the speed along the wheels' rolling.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from cartgrasp.checks import angle as checked_angle
from cartgrasp.checks import check_kind, listed, number, pose, positive
from cartgrasp.constraints import RollingConstraints
from cartgrasp.errors import UsageError
from cartgrasp.frames import Array, body_to_world
from cartgrasp.motion import Reference
from cartgrasp.reference_file import LONGEST, STRONGEST, Stretch

__all__ = ["PathReference", "Stretch", "chain", "pause", "speed_change", "straight", "turn"]

KNOT_SPACING = 0.05
FASTEST = 50.0
"""m/s or rad/s: what is beyond is a slip of units."""
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(5)


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
        u, r = self._starts[-1]
        if abs(u) > 1e-9 or abs(r) > 1e-9:
            raise UsageError(f"reference: ends with u = {u:g} m/s, r = {r:g} rad/s; it must end at rest")
        if self.constraints.no_rotation and any(s.yaw_acceleration for s in self.stretches):
            raise UsageError("reference: a cart on a rail can't turn")

    @property
    def duration(self) -> float:
        return float(self._times[-1])

    def at(self, time: float) -> Reference:
        """The reference at a time; clamped to start and end."""
        clamped = min(max(number("reference: time", time, cure="give s"), 0.0), self.duration)
        i = min(int(np.searchsorted(self._times, clamped, side="right")) - 1, len(self.stretches) - 1)
        knot = min(int(clamped / KNOT_SPACING), len(self._knots) - 1)
        pose = self._knots[knot] + self._travel(knot * KNOT_SPACING, clamped)
        stretch, elapsed = self.stretches[i], clamped - self._times[i]
        rates = np.array([stretch.acceleration, 0.0, stretch.yaw_acceleration])
        u, r = self._starts[i]
        velocity = np.array([u, 0.0, r]) + rates * elapsed
        if not 0.0 <= time < self.duration:
            rates = np.zeros(3)
            velocity = np.zeros(3) if time >= self.duration else velocity
        pose[:2] += np.array(self.start_pose[:2])
        free = [0, 1, 2] if self.constraints.axle_x is None else [0, 2][: self.constraints.n_free]
        return Reference(time, pose, velocity[free], rates[free])

    @cached_property
    def _times(self) -> Array:
        return np.concatenate([[0.0], np.cumsum([s.duration for s in self.stretches])])

    @cached_property
    def _starts(self) -> Array:
        """(u, r) where each stretch begins, and at the end, (n + 1, 2)."""
        gains = [[s.duration * s.acceleration, s.duration * s.yaw_acceleration] for s in self.stretches]
        return np.concatenate([np.zeros((1, 2)), np.cumsum(gains, axis=0)])

    @cached_property
    def _headings(self) -> Array:
        durations = np.diff(self._times)
        mean_rates = (self._starts[:-1, 1] + self._starts[1:, 1]) / 2
        return self.start_pose[2] + np.concatenate([[0.0], np.cumsum(durations * mean_rates)])

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
        """Change of pose between two times, by quadrature over each stretch between them."""
        inner = self._times[(self._times > begin) & (self._times < end)]
        limits = np.concatenate([[begin], inner, [end]])
        half = np.diff(limits)[:, None] / 2
        times = (limits[:-1, None] + half * (1 + _NODES)).ravel()
        heading, velocity_b = self._motion(times)
        velocity_s = (body_to_world(heading) @ velocity_b[..., None])[..., 0]
        weights = (half * _WEIGHTS).ravel()
        return np.asarray(weights @ velocity_s)

    def _motion(self, times: Array) -> tuple[Array, Array]:
        """Heading (n,) and body velocity (n, 3) at times inside the path."""
        i = np.clip(np.searchsorted(self._times, times, side="right") - 1, 0, len(self.stretches) - 1)
        elapsed = times - self._times[i]
        du = np.array([s.acceleration for s in self.stretches])[i]
        dr = np.array([s.yaw_acceleration for s in self.stretches])[i]
        u, r = self._starts[i].T
        heading = self._headings[i] + r * elapsed + dr * elapsed**2 / 2
        velocity_b = np.stack([u + du * elapsed, np.zeros_like(u), r + dr * elapsed], axis=-1)
        if self.constraints.axle_x is not None:
            across = np.sin(self.constraints.angle) * velocity_b[:, 0]
            velocity_b[:, 1] = across - self.constraints.axle_x * velocity_b[:, 2]
            velocity_b[:, 0] *= np.cos(self.constraints.angle)
        return heading, velocity_b


def straight(distance: float, speed: float, acceleration: float = 0.5) -> list[Stretch]:
    """From rest to rest along a line with steps of acceleration; a negative distance drives backward."""
    distance = number("straight: distance", distance, -LONGEST, LONGEST, "give m")
    _check_rates("straight", speed, acceleration, ("m/s", "m/s²"))
    direction, distance = float(np.sign(distance)), abs(distance)
    ramp = min(speed / acceleration, (distance / acceleration) ** 0.5)
    cruise = (distance - acceleration * ramp**2) / (acceleration * ramp)
    stretches = [Stretch(ramp, direction * acceleration), Stretch(ramp, -direction * acceleration)]
    return stretches if cruise <= 1e-9 else [stretches[0], Stretch(cruise), stretches[1]]


def turn(angle: float, yaw_rate: float, yaw_acceleration: float = 0.5) -> list[Stretch]:
    """A curve by `angle` (rad) at the speed one has: yaw rate ramps up, holds, ramps down."""
    direction, angle = float(np.sign(checked_angle("turn: angle", angle))), abs(angle)
    _check_rates("turn", yaw_rate, yaw_acceleration, ("rad/s", "rad/s²"))
    ramp = min(yaw_rate / yaw_acceleration, (angle / yaw_acceleration) ** 0.5)
    hold = (angle - yaw_acceleration * ramp**2) / (yaw_acceleration * ramp)
    up, down = Stretch(ramp, 0.0, direction * yaw_acceleration), Stretch(ramp, 0.0, -direction * yaw_acceleration)
    return [up, down] if hold <= 1e-9 else [up, Stretch(hold), down]


def _check_rates(what: str, speed: float, acceleration: float, units: tuple[str, str]) -> None:
    positive(f"{what}: speed", speed, FASTEST, f"give {units[0]}")
    positive(f"{what}: acceleration", acceleration, STRONGEST, f"give {units[1]}")


def speed_change(change: float, acceleration: float = 0.5) -> list[Stretch]:
    """A step of acceleration that changes the forward speed by `change` (m/s)."""
    _check_rates(
        "speed_change",
        abs(number("speed_change: change", change, -FASTEST, FASTEST, "give m/s")),
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
