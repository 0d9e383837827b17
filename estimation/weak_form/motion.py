"""The motion of a log on a uniform grid: smooth where it enters a model nonlinearly, unbiased where it is a rate of
momentum."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass, fields, replace
from functools import cached_property

import numpy as np

from cartgrasp.errors import DataError
from cartgrasp.frames import Array
from cartgrasp.logs import RunLog
from cartgrasp.model import CartModel
from cartgrasp.tracked_point import composed, in_frame, inverted

from ..log_noise.sample_step import usual_step
from ..noise import FilterNoise
from .quantisation import dequantised
from .sensor_noise import MotionNoise
from .splines import PoseFits, Samples, SplineBasis, SplineFit

MAX_CACHED_MEMORIES = 16
"""Memories of effects that are kept for a motion."""
GRID_STEP = 0.01
"""Step (s) of the grid, where samples come as often as that."""
MIN_GRID_STEP = 0.0025
"""Step (s) of a finer grid: as fine as anything moves by which a cart's mass is told."""
KNOT_STEPS = 5
"""Steps of the grid from knot to knot of the motion's splines."""
MIN_SAMPLES_PER_KNOT = 2.0
"""Fewest samples that stand behind each coefficient of a spline."""
MAX_GAP_STEPS = 3.0
"""Longest gap, in multiples of the samples' usual step: over a longer one nobody knows what happened."""
MIN_POSES = 12
MAX_GRID_POINTS = 10_000_000
"""Most points of the grid: more than a day at 100 Hz is a clock that jumped, and no memory holds it."""


@dataclass(frozen=True, eq=False)
class Twists:
    """A frame's motion in its own axes, (n, 3) each: smooth velocity, acceleration unbiased and smooth, and unbiased
    velocity (from poses alone, where there are any: recorded velocities may leave out what wheels creep)."""

    velocity: Array
    acceleration: Array
    smooth_acceleration: Array
    of_poses: Array

    def seen_from(self, pose_ab: Array) -> Twists:
        """Twists of a frame that is fixed to this one, at `pose_ab` (3,) in it."""
        turn = in_frame(pose_ab).T
        return Twists(*(part @ turn for part in (getattr(self, one.name) for one in fields(self))))


@dataclass(frozen=True, eq=False)
class Motion:
    """Motion at times (n,): smooth pose (n, 3) and free velocity (n, f), free acceleration (n, f), unbiased and smooth.
    `across` is the unbiased speed across the wheels at {b}'s axle (n,; None without one); `seen` (n,) tells where
    sensors saw it. Standard deviations (3,) are of the smooth pose and its rate in {s}, in the middle of the log.
    `pose_tb` (3,) is where {b} is taken to be in the frame that was tracked, of which the `fits` are."""

    time: Array
    pose: Array
    velocity: Array
    acceleration: Array
    smooth_acceleration: Array
    across: Array | None
    seen: np.ndarray
    noise: MotionNoise
    pose_std: Array
    rate_std: Array
    twists: Twists
    fits: PoseFits
    pose_tb: Array

    def memory(self, cart: CartModel, faster: Array | float = 0.0) -> Array:
        """What a cart's effects remember (n, k) along this motion, or along one that is `faster` by (f,). Fits change
        numbers on which it does not depend, so it is kept."""
        velocity = self.velocity + faster
        if not cart.memory_names or not cart.is_compiled:
            return cart.memory_along(self.pose, velocity, self.time)
        key = cart.memory_key, np.asarray(faster).tobytes() if np.any(faster) else b""
        if key not in self._memories:
            if len(self._memories) == MAX_CACHED_MEMORIES:
                del self._memories[next(iter(self._memories))]
            self._memories[key] = cart.memory_along(self.pose, velocity, self.time)
        return self._memories[key]

    @cached_property
    def _memories(self) -> dict[Hashable, Array]:
        """What carts remember along this motion, by what that depends on."""
        return {}

    def of_body(self, cart: CartModel) -> Motion:
        """Motion with {b} where a cart has it in the frame that was tracked."""
        if np.array_equal(cart.pose_tb, self.pose_tb):
            return self
        change = composed(inverted(self.pose_tb), cart.pose_tb)
        pose, twists = composed(self.pose, change), self.twists.seen_from(change)
        velocity, acceleration, smooth, across = _freed(cart, twists)
        return replace(
            self,
            pose=pose,
            velocity=velocity,
            acceleration=acceleration,
            smooth_acceleration=smooth,
            across=across,
            twists=twists,
            pose_tb=cart.pose_tb,
        )

    @property
    def step(self) -> float:
        return float(self.time[1] - self.time[0])

    @property
    def speed(self) -> Array:
        """Speed of {b}'s origin (n,), m/s."""
        return np.abs(self.velocity[:, 0]) if self.velocity.shape[1] < 3 else np.hypot(*self.velocity[:, :2].T)

    @property
    def way(self) -> Array:
        """Travelled distance (n,), m."""
        return np.append(0.0, np.cumsum(self.speed[:-1] * np.diff(self.time)))


def motion_of(
    log: RunLog, cart: CartModel, told: FilterNoise | None = None, samples_per_knot: float | None = None
) -> Motion:
    """Motion of a log, with noise as it is told, or read off the log. The grid is as fine as `MIN_GRID_STEP` where
    `samples_per_knot` stand behind each coefficient at least, else as `GRID_STEP`. Raises DataError for a log that is
    too short or too long."""
    seen = np.asarray(np.isfinite(log.pose).all(axis=1))
    if seen.sum() < MIN_POSES:
        raise DataError(f"{log.name}: {int(seen.sum())} rows have a pose; at least {MIN_POSES} are needed")
    time = log.time[seen]
    moving = np.zeros(0) if log.velocity is None else log.time[np.isfinite(log.velocity).all(axis=1)]
    native = usual_step(time)
    step = max(GRID_STEP, MIN_SAMPLES_PER_KNOT * native / KNOT_STEPS)
    if samples_per_knot is not None:
        step = min(step, max(MIN_GRID_STEP, samples_per_knot * native / KNOT_STEPS))
    first, last = (float(end) for end in np.sort(np.append(moving, time))[[0, -1]])
    if last - first < MIN_POSES * KNOT_STEPS * step:
        raise DataError(f"{log.name}: {last - first:.3g} s at {1 / native:.3g} Hz are too short to learn from")
    if not (last - first) / step < MAX_GRID_POINTS:
        raise DataError(
            f"{log.name}: {last - first:.3g} s at {1 / native:.3g} Hz are too long to learn from at once; cut the log "
            "where nothing was recorded, and look for a clock that jumps"
        )
    grid: Array = np.asarray(first + step * np.arange(int((last - first) / step) + 1), dtype=float)
    noise = MotionNoise.of(log) if told is None else MotionNoise.told(told, log)
    log = dequantised(log)
    poses = np.column_stack([log.pose[seen, :2], _unwrapped(log, seen)])
    basis = SplineBasis.over(first, last, KNOT_STEPS * step)
    fits, from_poses = [], []
    for i in range(3):
        samples = [Samples(time, poses[:, i], noise.pose[i], 0)]
        from_poses.append(samples[0])
        if log.velocity is not None and noise.velocity is not None:
            known = np.isfinite(log.velocity[:, i]) & (log.time >= first) & (log.time <= last)
            if known.any():
                samples.append(Samples(log.time[known], log.velocity[known, i], noise.velocity[i], 1))
        fits.append(SplineFit(basis, samples))
    at, rate, bend = (basis.design(grid, k) for k in range(3))
    pose = np.column_stack([at @ fit.smooth for fit in fits])
    smooth_rate = np.column_stack([rate @ fit.smooth for fit in fits])
    velocity_b = _turned(pose[:, 2], smooth_rate)
    unbiased, smooth = (
        _acceleration(pose[:, 2], velocity_b, np.column_stack([bend @ getattr(fit, kind) for fit in fits]))
        for kind in ("unbiased", "smooth")
    )
    gap = MAX_GAP_STEPS * max(native, step)
    placed, moved = _near(time, grid, gap), _near(moving, grid, gap)
    of_all = np.column_stack([rate @ fit.unbiased for fit in fits])
    of_poses = of_all
    if cart.constraints.n_rows == 1:
        of_poses = np.column_stack([rate @ SplineFit(basis, [samples]).unbiased for samples in from_poses])
        of_poses = np.where(placed[:, None], of_poses, of_all)
    middle = float(np.median(time))
    pose_std, rate_std = (np.array([fit.smooth_std(middle, order) for fit in fits]) for order in (0, 1))
    twists = Twists(velocity_b, unbiased, smooth, _turned(pose[:, 2], of_poses))
    freed, tracked = _freed(cart, twists), PoseFits(tuple(fits), grid, at, rate)
    own = Motion(grid, pose, *freed, placed | moved, noise, pose_std, rate_std, twists, tracked, np.zeros(3))
    return own.of_body(cart)


def _freed(cart: CartModel, twists: Twists) -> tuple[Array, Array, Array, Array | None]:
    """Free velocity and accelerations (n, f), and the speed of the axle to its left (n,), from twists of {b}."""
    free, across = cart.rolling.free_velocity, None
    if cart.constraints.n_rows == 1:
        across = twists.of_poses[:, 1] + float(cart.constraints.axle_x or 0.0) * twists.of_poses[:, 2]
    return free(twists.velocity), free(twists.acceleration), free(twists.smooth_acceleration), across


def _turned(heading: Array, vectors_s: Array) -> Array:
    """Vectors (n, 3) of {s} turned into {b}."""
    cosine, sine = np.cos(heading), np.sin(heading)
    x, y, yaw = vectors_s.T
    return np.column_stack([cosine * x + sine * y, cosine * y - sine * x, yaw])


def _acceleration(heading: Array, velocity_b: Array, bend_s: Array) -> Array:
    """Rate of the velocity in {b} (n, 3), from the rate of that in {s}."""
    found = _turned(heading, bend_s)
    found[:, 0] += velocity_b[:, 2] * velocity_b[:, 1]
    found[:, 1] -= velocity_b[:, 2] * velocity_b[:, 0]
    return found


def _near(time: Array, grid: Array, gap: float) -> np.ndarray:
    """Where a grid's points (n,) lie between samples that are no more than `gap` (s) apart."""
    if len(time) < 2:
        return np.zeros(len(grid), dtype=bool)
    after = np.clip(np.searchsorted(time, grid), 1, len(time) - 1)
    return np.asarray((time[after] - time[after - 1] <= gap) & (grid >= time[0]) & (grid <= time[-1]))


def _unwrapped(log: RunLog, seen: np.ndarray) -> Array:
    """Headings of the rows that are seen: between them, a cart turns as far as its yaw rate says, if there is one."""
    turned = np.zeros(len(log))
    if log.velocity is not None:
        rate = np.nan_to_num(log.velocity[:, 2])
        turned = np.append(0.0, np.cumsum(np.diff(log.time) * (rate[1:] + rate[:-1]) / 2))
    return np.asarray(np.unwrap(log.pose[seen, 2] - turned[seen]) + turned[seen])
