"""What physics says of columns: which heading goes where the cart goes, which velocities are differences of poses, and
whether forces push or are pushed back.

Each is a comparison of signals that two columns tell apart, over a whole log, on an even grid of times.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from ....frames import Array, unwrapped

MAX_GRID_RATE = 50.0
"""Hz: of the grid, at most."""
SMOOTHING_WINDOW = 0.4
"""s: window of the parabolas that velocities are read off; accelerations take twice of it."""
MIN_GRID_SAMPLES = 40
MOVING_SPEED_FRACTION = 0.15
"""Share of the 95th percentile of the speed below which no direction of travel is read."""
MAX_DISAGREEMENT_RATIO = 0.3
"""What one reading of headings lacks to agree (1 less its agreement) is at most so much of what any other lacks."""
AGREEMENT_THRESHOLD = 0.9
MASS_SIGMAS = 8.0
"""Standard deviations by which a mass must differ from zero; neighbours in the residual are not independent."""


@dataclass(frozen=True)
class Motion:
    """Times (n,), s, positions (n, 2) with their derivatives, of a tracked point."""

    time: Array
    position: Array
    velocity: Array
    acceleration: Array

    @property
    def speed(self) -> Array:
        return np.asarray(np.hypot(*self.velocity.T))

    @property
    def top_speed(self) -> float:
        return float(np.percentile(self.speed, 95))

    def on(self, time: Array, column: Array) -> Array:
        """A column (m,) of other times on the grid, NaN outside."""
        there = np.isfinite(column) & np.isfinite(time)
        if there.sum() < 2:
            return np.full(len(self.time), np.nan)
        return np.interp(self.time, time[there], column[there], left=np.nan, right=np.nan)

    def smoothed(self, time: Array, column: Array) -> Array:
        """A column (m,) of other times on the grid, smoothed as accelerations are."""
        return _derivative(self.on(time, column), float(self.time[1] - self.time[0]), 2 * SMOOTHING_WINDOW, 0)


def motion_of(time: Array, x: Array, y: Array) -> Motion | None:
    """None where rows are too few, or the clock doesn't run."""
    there = np.isfinite(time) & np.isfinite(x) & np.isfinite(y)
    time, x, y = time[there], x[there], y[there]
    if len(time) < MIN_GRID_SAMPLES or not (np.diff(time) > 0).all():
        return None
    step = max(float(np.median(np.diff(time))), 1 / MAX_GRID_RATE, (time[-1] - time[0]) / 100_000)
    grid = np.arange(time[0], time[-1], step)
    if len(grid) < MIN_GRID_SAMPLES:
        return None
    position = np.column_stack([np.interp(grid, time, column) for column in (x, y)])
    velocity = np.column_stack([_derivative(column, step, SMOOTHING_WINDOW, 1) for column in position.T])
    acceleration = np.column_stack([_derivative(column, step, 2 * SMOOTHING_WINDOW, 2) for column in position.T])
    return Motion(grid, position, velocity, acceleration)


def _derivative(column: Array, step: float, window: float, order: int) -> Array:
    from scipy.signal import savgol_filter

    width = max(2 * round(window / step / 2) + 1, 5)
    width = min(width, len(column) - (1 - len(column) % 2))
    found = savgol_filter(np.nan_to_num(column), width, 2 if order < 2 else 3, deriv=order, delta=step)
    return np.where(np.isfinite(column), found, np.nan)


@dataclass(frozen=True)
class Heading:
    """How a column of headings is to be read: `agreement` (0 to 1) is the mean cosine of twice the angle from heading
    to travel, less the `offset` (rad) that is allowed for, mod pi: a cart may go backwards."""

    unit: str
    sign: int
    offset: float
    agreement: float


FULL_TURNS: Mapping[str, float] = {"deg": 360.0, "rad": 2 * np.pi}


def heading_of(motion: Motion, time: Array, column: Array) -> Heading | None:
    """The reading with which headings go where the cart goes, or always as far beside it; None where several do, or
    none does: on casters, or on a way that hardly turns."""
    moving = motion.speed > MOVING_SPEED_FRACTION * motion.top_speed
    travel = np.arctan2(motion.velocity[:, 1], motion.velocity[:, 0])
    straight, beside = [], []
    for unit, sign in product(FULL_TURNS, (1, -1)):
        angle = sign * motion.on(time, unwrapped(column, FULL_TURNS[unit])) * (2 * np.pi / FULL_TURNS[unit])
        seen = moving & np.isfinite(angle)
        if seen.sum() < MIN_GRID_SAMPLES:
            return None
        mean = np.mean(np.exp(2j * (travel - angle)[seen]))
        straight.append(Heading(unit, sign, 0.0, float(mean.real)))
        beside.append(Heading(unit, sign, float(np.angle(mean) / 2), float(abs(mean))))
    return _clearest(straight) or _clearest(beside)


def _clearest(found: Sequence[Heading]) -> Heading | None:
    """The one that agrees, if it is off by far less than any other."""
    best, second = sorted(found, key=lambda one: -one.agreement)[:2]
    lacking = MAX_DISAGREEMENT_RATIO * (1 - second.agreement)
    return best if best.agreement > AGREEMENT_THRESHOLD and 1 - best.agreement < lacking else None


@dataclass(frozen=True)
class Velocities:
    """The frame (`world` or `cart`) along whose axes columns are velocities, and how well they agree with differences
    of positions (0 to 1). `factors` say by what each is too large (with its sign); `is_clear` where the other frame
    agrees less."""

    frame: str
    agreement: float
    factors: tuple[float, float]
    is_clear: bool


def velocities(motion: Motion, time: Array, vx: Array, vy: Array, heading: Array | None) -> Velocities | None:
    """`heading` (rad) on the same times; None where nothing moves."""
    recorded = np.column_stack([motion.on(time, vx), motion.on(time, vy)])
    truths = {"world": motion.velocity}
    if heading is not None:
        angle = motion.on(time, heading)
        c, s = np.cos(angle), np.sin(angle)
        x, y = motion.velocity.T
        truths["cart"] = np.column_stack([c * x + s * y, c * y - s * x])
    found = []
    for frame, truth in truths.items():
        seen = np.isfinite(recorded).all(axis=1) & np.isfinite(truth).all(axis=1)
        a, b = recorded[seen], truth[seen]
        if seen.sum() < MIN_GRID_SAMPLES or not (b**2).sum() > 0 or not (a**2).sum() > 0:
            return None
        scales = [float(a[:, k] @ b[:, k] / (b[:, k] @ b[:, k])) if b[:, k].any() else 0.0 for k in range(2)]
        size = [float(np.sqrt((b[:, k] ** 2).sum())) for k in range(2)]
        factors = [
            scale if size[k] > 0.1 * max(size) else scales[int(np.argmax(size))] for k, scale in enumerate(scales)
        ]
        with_signs = b * np.sign(factors)
        agreement = float((a * with_signs).sum() / np.sqrt((a**2).sum() * (b**2).sum()))
        found.append(Velocities(frame, agreement, (factors[0], factors[1]), False))
    best = max(found, key=lambda one: one.agreement)
    others = [one.agreement for one in found if one is not best]
    is_clear = best.agreement > AGREEMENT_THRESHOLD and all(best.agreement - other > 0.02 for other in others)
    alike = best.agreement > AGREEMENT_THRESHOLD and all(abs(best.agreement - other) < 1e-3 for other in others)
    return replace(best, is_clear=is_clear or alike)


def scale(recorded: Array, truth: Array) -> tuple[float, float]:
    """The factor by which a column is larger than another, and how well they agree (-1 to 1)."""
    seen = np.isfinite(recorded) & np.isfinite(truth)
    a, b = recorded[seen], truth[seen]
    if seen.sum() < MIN_GRID_SAMPLES or not b.any() or not a.any():
        return 0.0, 0.0
    return float(a @ b / (b @ b)), float(a @ b / np.sqrt((a @ a) * (b @ b)))


@dataclass(frozen=True)
class MassRegression:
    """What a force that goes with the cart's motion tells: the mass (kg, with the force's sign) and how many standard
    deviations it is from zero; `power` is the work's sign on a way that costs work."""

    mass: float
    z: float
    explained: float
    power: float

    @property
    def is_sure(self) -> bool:
        return abs(self.z) > MASS_SIGMAS and self.explained > 0.3


def mass_regression(motion: Motion, heading: Array, force: Array) -> MassRegression | None:
    """Regression of a force (n,) along the cart on acceleration, speed, direction and a constant. The force is on the
    motion's grid, smoothed as its acceleration is. None where the rows tell too little."""
    c, s = np.cos(heading), np.sin(heading)
    along = motion.acceleration @ [1, 0] * c + motion.acceleration @ [0, 1] * s
    speed = motion.velocity @ [1, 0] * c + motion.velocity @ [0, 1] * s
    seen = np.isfinite(force) & np.isfinite(along) & np.isfinite(speed)
    step = float(motion.time[1] - motion.time[0])
    stride = max(round(SMOOTHING_WINDOW / step), 1)
    rows = np.flatnonzero(seen)[::stride]
    if len(rows) < 12 or np.ptp(along[rows]) == 0 or np.std(force[rows]) == 0:
        return None
    direction = np.tanh(speed / (0.05 * motion.top_speed + 1e-12))
    design = np.column_stack([along, speed, direction, np.ones_like(along)])[rows]
    target = force[rows]
    values, *_ = np.linalg.lstsq(design, target, rcond=None)
    left = target - design @ values
    variance = float(left @ left) / max(len(rows) - 4, 1)
    spread = np.linalg.pinv(design.T @ design)[0, 0] * variance
    explained = 1 - float(left.var() / target.var())
    return MassRegression(
        float(values[0]), float(values[0] / np.sqrt(spread + 1e-300)), explained, float(np.nansum(force * speed))
    )
