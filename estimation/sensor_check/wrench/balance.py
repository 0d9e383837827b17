"""What bumps see of a cart's accelerations and of what sensors say was pushed, beside all that may act in between.

Divided by the mass and by the yaw inertia, the balances of physics 4 read

    u' = Fx / m + [r', r², u, sgn u, 1, cos, sin, casters] · unknowns
    r' = tau / J + [u', u r, r, sgn r, u, sgn u, 1, cos, sin, casters, contact points] · unknowns

where the bracketed columns (first moments, drags, offsets, slopes, offsets at levers) are taken out of both sides; what
is left of each recorded component (and of it times its levers) is a row of `signals`. Wrenches are what explains and
motion what is explained, so every way to read the former explains the same data.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cartgrasp.frames import Array
from cartgrasp.logs import RunLog
from cartgrasp.model import CartModel

from ..motion.track import MEASURED, Track
from ..weak_form import Bumps, Sums
from .casters import caster_forces

WIDTH = 1.5
"""s: of the bumps. Models of pushed carts hold below a hertz or so: loads lean and swing, handles give."""
FEWEST = 16
"""Rows: the columns that are taken out are up to a dozen."""
STANDING = 0.02
"""m/s, rad/s: over which dry friction turns round."""
FORWARD = ("fx", "fy", "fz", "fx of {s}")
"""Signals of the forward balance: components along x that a reading may take."""
TURNING = ("px·fx", "px·fy", "px·fz", "py·fx", "py·fy", "py·fz", "tx", "ty", "tz", "moment of {s}")
"""Of the yaw balance."""


@dataclass(frozen=True)
class Balance:
    """One balance: accelerations (k,) and each arm's signals (k, s), both beside the columns taken out; and how many
    those were."""

    motion: Array
    signals: dict[str, Array]
    taken: int


def balances(log: RunLog, cart: CartModel) -> tuple[Balance | None, Balance | None]:
    """Forward and yaw; None where the log is too short, still or without wrenches, or the cart can't turn."""
    track = Track.of(log)
    if len(track.time) < 2 * MEASURED or not track.is_fast(WIDTH) or not log.arms:
        return None, None
    bumps = Bumps.over(track.time, track.width(WIDTH))
    on_track = bumps.on(track.time)
    kept = on_track.covered
    signals = {}
    for name in log.arms:
        found = _signals(log, name, track, bumps)
        if found is None:
            return None, None
        kept = kept & found[2]
        signals[name] = found[:2]
    if kept.sum() < FEWEST:
        return None, None
    forward, _, turning = track.accelerating(on_track)
    of_forward, of_turning = _taken_out(cart, track, on_track, (forward, turning))
    levers = [_levers(log, name, bumps) for name in log.arms]
    ahead = _beside(forward, {name: pair[0] for name, pair in signals.items()}, of_forward, kept)
    if cart.constraints.no_rotation:
        return ahead, None
    turned = _beside(
        turning, {name: pair[1] for name, pair in signals.items()}, np.column_stack([of_turning, *levers]), kept
    )
    return ahead, turned


def _signals(log: RunLog, name: str, track: Track, bumps: Bumps) -> tuple[Array, Array, np.ndarray] | None:
    """∫ phi of `FORWARD` (k, 4) and `TURNING` (k, 10) of an arm, and which windows are covered."""
    arm = log.arms[name]
    there = np.isfinite(np.hstack([arm.wrench, arm.contact[:, :2]])).all(axis=1)
    if there.sum() < 2 * MEASURED:
        return None
    time, wrench, contact = log.time[there], arm.wrench[there], arm.contact[there]
    sums, heading = bumps.on(time), track.headed(time)
    c, s = np.cos(heading), np.sin(heading)
    px, py = contact[:, 0], contact[:, 1]
    of_cart = np.column_stack([c * wrench[:, 0] + s * wrench[:, 1], c * wrench[:, 1] - s * wrench[:, 0]])
    ahead = np.column_stack([wrench[:, :3], of_cart[:, 0]])
    levers = [px[:, None] * wrench[:, :3], py[:, None] * wrench[:, :3], wrench[:, 3:]]
    turning = np.column_stack([*levers, px * of_cart[:, 1] - py * of_cart[:, 0]])
    return sums.integral(ahead), sums.integral(turning), sums.covered


def _levers(log: RunLog, name: str, bumps: Bumps) -> Array:
    """∫ phi of contact points (k, 2): what offsets of forces turn with."""
    arm = log.arms[name]
    there = np.isfinite(arm.contact[:, :2]).all(axis=1)
    return bumps.on(log.time[there]).integral(arm.contact[there, :2])


def _taken_out(cart: CartModel, track: Track, sums: Sums, accelerations: tuple[Array, Array]) -> tuple[Array, Array]:
    """Columns (k, ·) of the forward and of the yaw balance."""
    speeds = track.speeds(track.time)
    u, _, r = speeds.T
    c, s = np.cos(track.heading), np.sin(track.heading)
    forward, turning = accelerations
    always = [u, np.tanh(u / STANDING), np.ones_like(u), c, s]
    of_forward = sums.integral(np.column_stack([*always, r**2]))
    of_turning = sums.integral(np.column_stack([*always, u * r, r, np.tanh(r / STANDING)]))
    casters = sums.integral(caster_forces(cart, track.time, track.heading, speeds))
    return np.column_stack([of_forward, turning, casters[:, 0]]), np.column_stack([of_turning, forward, casters[:, 1]])


def _beside(motion: Array, signals: dict[str, Array], columns: Array, kept: np.ndarray) -> Balance | None:
    """What is left of both sides when the columns are taken out."""
    columns = columns[kept]
    size = np.linalg.norm(columns, axis=0)
    left, values, _ = np.linalg.svd(columns / np.where(size > 0, size, 1.0), full_matrices=False)
    axes = left[:, values > 1e-8 * values[0]]
    if len(columns) < axes.shape[1] + FEWEST // 2:
        return None

    def off(rows: Array) -> Array:
        return np.asarray(rows - axes @ (axes.T @ rows))

    return Balance(off(motion[kept]), {name: off(rows[kept]) for name, rows in signals.items()}, axes.shape[1])
