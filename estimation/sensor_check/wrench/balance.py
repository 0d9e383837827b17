"""What bumps see of a cart's accelerations and of what sensors say was pushed, beside all that may act in between.

Divided by the mass and by the yaw inertia, the balances of physics 4 read

    u' - w r = Fx / m + [r', r², u, sgn u, 1, cos, sin, casters] · unknowns
    w' + u r = Fy / m + [r', r², w, sgn w, 1, cos, sin] · unknowns                        (carts on casters alone)
    r' = tau / J + [u' - w r, w' + u r, r, sgn r, u, sgn u, 1, cos, sin, casters, contact points] · unknowns

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
"""Signals of the forward balance: components along x that a reading may take; of the sideways one likewise."""
TURNING = ("px·fx", "px·fy", "px·fz", "py·fx", "py·fy", "py·fz", "tx", "ty", "tz", "moment of {s}")
"""Of the yaw balance."""


@dataclass(frozen=True)
class Balance:
    """One balance: accelerations (k,) and each arm's signals (k, s), both beside the columns taken out; and how many
    those were."""

    motion: Array
    signals: dict[str, Array]
    taken: int


@dataclass(frozen=True)
class Balances:
    """Forward, sideways (of carts that may go so) and yaw (of those that may turn)."""

    forward: Balance
    sideways: Balance | None
    turning: Balance | None


@dataclass(frozen=True)
class _Signals:
    """∫ phi of `FORWARD` (k, 4), of the same for y, and of `TURNING` (k, 10), of one arm; which windows are covered."""

    forward: Array
    sideways: Array
    turning: Array
    covered: np.ndarray


def balances(log: RunLog, cart: CartModel) -> Balances | None:
    """None where the log is too short, too slow or without wrenches."""
    track = Track.of(log)
    if len(track.time) < 2 * MEASURED or not track.is_fast(WIDTH) or not log.arms:
        return None
    bumps = Bumps.over(track.time, track.width(WIDTH))
    on_track = bumps.on(track.time)
    found = {name: _signals(log, name, track, bumps) for name in log.arms}
    signals = {name: one for name, one in found.items() if one is not None}
    kept = np.all([on_track.covered, *(one.covered for one in signals.values())], axis=0)
    if len(signals) < len(found) or kept.sum() < FEWEST:
        return None
    speeds = track.speeds(track.time)
    u, w, r = speeds.T
    ahead, aside, turned = track.accelerating(on_track)
    motions = ahead - on_track.integral(w * r), aside + on_track.integral(u * r), turned
    casters = on_track.integral(caster_forces(cart, track.time, track.heading, speeds))
    of_forward, of_sideways, of_turning = _taken_out(track, on_track, speeds, motions)
    levers = [_levers(log, name, bumps) for name in log.arms]
    forward = _beside(
        *(motions[0], {name: one.forward for name, one in signals.items()}),
        *(np.column_stack([of_forward, casters[:, 0]]), kept),
    )
    if forward is None:
        return None
    sideways = _beside(motions[1], {name: one.sideways for name, one in signals.items()}, of_sideways, kept)
    turning = _beside(
        *(motions[2], {name: one.turning for name, one in signals.items()}),
        *(np.column_stack([of_turning, casters[:, 1], *levers]), kept),
    )
    is_free, may_turn = cart.constraints.axle_x is None, not cart.constraints.no_rotation
    return Balances(forward, sideways if is_free else None, turning if may_turn else None)


def _signals(log: RunLog, name: str, track: Track, bumps: Bumps) -> _Signals | None:
    """None where too little is recorded; a component that is blank throughout counts for nothing."""
    arm = log.arms[name]
    table = np.hstack([arm.wrench, arm.contact[:, :2]])
    table = np.where(np.isfinite(table).any(axis=0), table, 0.0)
    there = np.isfinite(table).all(axis=1)
    if there.sum() < 2 * MEASURED or not np.isfinite(arm.wrench).any():
        return None
    time, wrench, (px, py) = log.time[there], table[there, :6], table[there, 6:].T
    sums, heading = bumps.on(time), track.headed(time)
    c, s = np.cos(heading), np.sin(heading)
    along, across = c * wrench[:, 0] + s * wrench[:, 1], c * wrench[:, 1] - s * wrench[:, 0]
    levers = [px[:, None] * wrench[:, :3], py[:, None] * wrench[:, :3], wrench[:, 3:]]
    return _Signals(
        sums.integral(np.column_stack([wrench[:, :3], along])),
        sums.integral(np.column_stack([wrench[:, :3], across])),
        sums.integral(np.column_stack([*levers, px * across - py * along])),
        sums.covered,
    )


def _levers(log: RunLog, name: str, bumps: Bumps) -> Array:
    """∫ phi of contact points (k, 2): what offsets of forces turn with."""
    contact = log.arms[name].contact[:, :2]
    contact = np.where(np.isfinite(contact).any(axis=0), contact, 0.0)
    there = np.isfinite(contact).all(axis=1)
    return bumps.on(log.time[there]).integral(contact[there])


def _taken_out(track: Track, sums: Sums, speeds: Array, motions: tuple[Array, ...]) -> tuple[Array, Array, Array]:
    """Columns (k, ·) of the three balances."""
    u, w, r = speeds.T
    c, s = np.cos(track.heading), np.sin(track.heading)
    forward, sideways, turning = motions

    def columns(speed: Array, *others: Array) -> Array:
        return sums.integral(np.column_stack([speed, np.tanh(speed / STANDING), np.ones_like(u), c, s, *others]))

    return (
        np.column_stack([columns(u, r**2), turning]),
        np.column_stack([columns(w, r**2), turning]),
        np.column_stack([columns(u, r, np.tanh(r / STANDING)), forward, sideways]),
    )


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
