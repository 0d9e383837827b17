"""Impacts: sudden changes of motion that no wrench explains, such as a bumper's or a threshold's.

The cart's free velocities are followed as ways along them, from poses alone: how far it rolled, and how far it turned.
Where one of these has a corner (`corners.py`) the cart was hit. It is no impact where the arms did it: then the motion
that their wrench alone would give the body has the same corner, or a good share of it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from scipy.integrate import cumulative_trapezoid

from cartgrasp.contacts import grasp_map_planar
from cartgrasp.frames import Array, rotation_planar, wrap_angle
from cartgrasp.logs import RunLog
from cartgrasp.model import CartModel

from ..log_noise.glitches import outlying
from ..log_noise.log_noise import noise_floor
from .corners import MAX_TOUCH_DURATION, MIN_POSE_NOISE, Corner, Track, corners, jump_at, reach_of, without_corner

MAX_POSE_RATE = 100.0
"""Hz: poses that come faster are averaged; a corner is told to a hundredth of a second at best."""
GLITCH_SIGMAS = 20.0
"""Times the noise of a pose, from which one is a glitch among its neighbours."""
ROUNDING_TOLERANCE = 1e-9
"""m, rad: values that differ by less are one value, written with other digits."""
QUANTUM_TOLERANCE = 1e-3
"""Share of a step within which a difference is a whole multiple of it."""
MIN_ARM_SHARE = 0.1
"""Share of a corner from which the arms explain it, by a roughly known mass. What stops a cart pushes against the arms,
not along with them."""
MAX_CLOCK_OFFSET, CORNER_WRENCH_WINDOW = 0.05, 1.0
"""s by which the clocks of wrenches and poses may differ; s around a corner that tell what the arms did."""
MAX_SPEED_FIT_DURATION, CURVATURE_SIGMAS = 1.2, 2.0
"""s, of motion that tells the speed at its end; standard deviations of a cubic from which less of it is taken."""


@dataclass(frozen=True, eq=False)
class Impact:
    """At `time` (s), with {b} at `pose` (3,) in {s}: where the motions before and after meet. The speeds (m/s), at the
    ends of the touch, are forward, along the way that the wheels leave free."""

    time: float
    pose: Array
    speed_before: float
    speed_after: float

    def as_dict(self) -> dict[str, Any]:
        speeds = {"speed_before": self.speed_before, "speed_after": self.speed_after}
        return {"time": self.time, "pose": self.pose.tolist(), **speeds}


def impacts(log: RunLog, cart: CartModel) -> tuple[Impact, ...]:
    """The impacts in order of time. Only the cart's constraints and, roughly, its inertia are used."""
    poses = _poses(log)
    if len(poses.time) < 2:
        return ()
    tracks = _tracks(poses, cart)
    found = [corners(track, len(tracks)) for track in tracks]
    hits = _merged([corner for of_track in found for corner in of_track])
    return tuple(
        _impact(poses, tracks, hits, i) for i, hit in enumerate(hits) if not _explained(log, cart, tracks, hit)
    )


class _Poses(NamedTuple):
    """Times (n,), poses (n, 3), and to what each coordinate is rounded (3,)."""

    time: Array
    pose: Array
    rounding: Array


def _poses(log: RunLog) -> _Poses:
    """Headings unwrapped, without glitches, at most at `MAX_POSE_RATE`."""
    seen = np.isfinite(log.pose).all(axis=1)
    time, pose = log.time[seen], log.pose[seen].copy()
    pose[:, 2] = np.unwrap(pose[:, 2])
    rounding = np.array([_rounded(column) for column in log.pose[seen].T])
    far = [GLITCH_SIGMAS * noise_floor(column) + 2 * step for column, step in zip(pose.T, rounding, strict=True)]
    sound = ~np.any([outlying(column, limit) for column, limit in zip(pose.T, far, strict=True)], axis=0)
    time, pose = time[sound], pose[sound]
    if len(time) < 2:
        return _Poses(time, pose, rounding)
    _, first = np.unique(np.floor((time - time[0]) * MAX_POSE_RATE + ROUNDING_TOLERANCE), return_index=True)
    count = np.diff(np.append(first, len(time)))
    mean = np.add.reduceat(np.column_stack([time, pose]), first, axis=0) / count[:, None]
    return _Poses(mean[:, 0], mean[:, 1:], rounding)


def _rounded(column: Array) -> float:
    """The step of which all differences between values are whole multiples; 0 where there is none."""
    steps = np.diff(np.unique(column))
    steps = steps[steps > ROUNDING_TOLERANCE]
    if not len(steps):
        return 0.0
    step = float(steps.min())
    return step if (np.abs(steps - np.round(steps / step) * step) < QUANTUM_TOLERANCE * step).all() else 0.0


def _tracks(poses: _Poses, cart: CartModel) -> list[Track]:
    """How far the cart went along each of its free velocities."""
    time, pose, rounding = poses
    middle = pose[:-1, 2] + np.diff(pose[:, 2]) / 2
    step = np.diff(pose, axis=0)
    step[:, :2] = (step[:, None, :2] @ rotation_planar(middle))[:, 0]
    ways = np.vstack([np.zeros(cart.constraints.n_free), np.cumsum(cart.rolling.free_velocity(step), axis=0)])
    known = {True: rounding[2], False: rounding[:2].max()}
    noise = [max(float(known[name == "r"]) / 12**0.5, MIN_POSE_NOISE) for name in cart.constraints.velocity_names]
    return [Track(time, way, floor) for way, floor in zip(ways.T, noise, strict=True)]


def _merged(found: Sequence[Corner]) -> list[Corner]:
    """The corners in order of time; where several are one touch, only the clearest."""
    kept: list[Corner] = []
    for corner in sorted(found, key=lambda one: -one.evidence):
        if all(abs(corner.time - other.time) >= MAX_TOUCH_DURATION for other in kept):
            kept.append(corner)
    return sorted(kept)


def _impact(poses: _Poses, tracks: Sequence[Track], hits: Sequence[Corner], i: int) -> Impact:
    """The i-th of the hits: its place and speeds as the motions between hits have them."""
    at, half = hits[i].time, hits[i].lasts / 2
    others = [*hits[:i], *hits[i + 1 :]]
    since, until = (float(t[0]) for t in without_corner(others, np.array([at])))
    sides = (
        (max(since, at - MAX_SPEED_FIT_DURATION), at - MAX_TOUCH_DURATION / 2),
        (at + MAX_TOUCH_DURATION / 2, min(until, at + MAX_SPEED_FIT_DURATION)),
    )
    ends = zip((at - half, at + half), sides, strict=True)
    before, after = (_speed(tracks[0], end, side) for end, side in ends)
    reach = reach_of(tracks[0])
    near = [(max(low, at - reach), min(high, at + reach)) for low, high in sides]
    place = [np.mean([_fit(poses.time, column, at, side)[0][0] for side in near]) for column in poses.pose.T]
    place[2] = wrap_angle(place[2])
    return Impact(at, np.array(place, dtype=float), before, after)


def _speed(track: Track, at: float, side: tuple[float, float]) -> float:
    """At one end of a stretch: of as much of it as a parabola follows."""
    low, high = side
    for longest in (1.0, 2 / 3, 1 / 3, 1 / 6):
        length = longest * MAX_SPEED_FIT_DURATION
        stretch = (max(low, at - length), min(high, at + length))
        numbers, deviations = _fit(track.time, track.place, at, stretch, 3)
        if len(numbers) < 4 or abs(numbers[3]) < CURVATURE_SIGMAS * deviations[3]:
            break
    return float(_fit(track.time, track.place, at, stretch)[0][1])


def _fit(time: Array, place: Array, at: float, stretch: tuple[float, float], degree: int = 2) -> tuple[Array, Array]:
    """Coefficients of a polynomial in the time from an instant, and their standard deviations; of less degree where
    there are few rows."""
    rows = (time >= stretch[0]) & (time <= stretch[1])
    degree = max(min(degree, int(rows.sum()) - 2), 0)
    powers = (time[rows] - at)[:, None] ** np.arange(degree + 1)
    numbers = np.linalg.lstsq(powers, place[rows], rcond=None)[0]
    left = place[rows] - powers @ numbers
    follows = min(max(float(left[1:] @ left[:-1]) / max(float(left @ left), np.finfo(float).tiny), 0.0), 0.99)
    variance = float(left @ left) / max(int(rows.sum()) - degree - 1, 1) * (1 + follows) / (1 - follows)
    spread = np.linalg.pinv(powers.T @ powers)
    padded = np.zeros(2)
    padded[: len(numbers[:2])] = numbers[:2]
    return np.concatenate([padded, numbers[2:]]), np.sqrt(variance * np.diagonal(spread))


def _explained(log: RunLog, cart: CartModel, tracks: Sequence[Track], hit: Corner) -> bool:
    """Whether the arms' wrench alone, on the free body, makes so much of the corner."""
    mass = cart.inverse(cart.state(), np.zeros(len(tracks)), time=hit.time).by_acceleration
    pushed = _pushed(log, cart, mass, hit.time)
    if pushed is None:
        return False
    jump = np.array([jump_at(track, hit.time, hit.lasts) for track in tracks])
    times = hit.time + np.array([-MAX_CLOCK_OFFSET, 0.0, MAX_CLOCK_OFFSET])
    given = [[jump_at(track, float(time), hit.lasts) for track in pushed] for time in times]
    return bool((np.array(given) @ mass @ jump).max() > MIN_ARM_SHARE * jump @ mass @ jump)


def _pushed(log: RunLog, cart: CartModel, mass: Array, at: float) -> list[Track] | None:
    """Where the arms alone would take the cart around a time, along each free velocity; None without a wrench."""
    rows = np.abs(log.time - at) < CORNER_WRENCH_WINDOW
    force = np.zeros((int(rows.sum()), len(mass)))
    for arm in log.arms.values():
        force += (cart.basis_b.T @ grasp_map_planar(arm.contact[rows]) @ arm.wrench[rows, :, None])[..., 0]
    known = np.isfinite(force).all(axis=1)
    if not log.arms or known.sum() < 2:
        return None
    time = log.time[rows][known]
    speed = cumulative_trapezoid(np.linalg.solve(mass, force[known].T), time, initial=0)
    return [Track(time, way) for way in cumulative_trapezoid(speed, time, initial=0)]
