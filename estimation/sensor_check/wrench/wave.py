"""Waves of a wrench over the way that the cart has rolled: what a sensor that turns with a wheel adds, or a wheel that
is not round.

While the cart rolls, each component is taken over short windows beside what motion and its directions make, and beside
a few harmonics of time, as hands give them; then harmonics of the way rolled (back counts back) are tried on a grid of
wave numbers. The evidence is how well stretches of the log foretell one another with the best of them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from cartgrasp.errors import printable
from cartgrasp.frames import Array
from cartgrasp.logs import RunLog

from ..evidence import from_odds, independent_rows
from ..motion.track import MEASURED, Track
from ..prior import LONGEST_WAVE, ODDS, SHORTEST_WAVE
from ..suspicion import TOLD, Suspicion
from ..weak_form import Bumps, middles
from .balance import STANDING

WIDTH = 0.3
"""s: of the bumps; waves of up to 3 Hz pass."""
TURNS = 5.0
"""Of a wheel, at least, over the way: fewer are a drift."""
FINE = 4.0
"""Wave numbers tried for each that the way can tell apart."""
HANDS = 8
"""Harmonics of time that are taken out, at most: slow leaning and strokes."""
EMPTY = 1e-9
"""Share of a signal that is rounding."""
PIECES = 6
"""Stretches that foretell one another."""
FASTEST_STROKE = 2.0
"""Hz: of hands and of leaning."""
LONGEST_STRETCH, FARTHEST = 120.0, 100.0
"""s and m of a log that are looked at: over more, what wheels creep puts a wave out of step."""
ANSWERS = (-0.45, -0.3, -0.15, 0.0, 0.15, 0.3, 0.45)
"""s: within which loads and people answer an acceleration."""
FEWEST = 50
"""Windows."""
COMPONENTS = (("fx", 0, "N"), ("fy", 1, "N"), ("tz", 5, "N·m"))


@dataclass(frozen=True)
class Wave:
    """Of one component: amplitude, period (m), and the log odds that it is there and goes with the way."""

    amplitude: float
    period: float
    log_odds: float


def waves(log: RunLog) -> tuple[Suspicion, ...]:
    """`offset` of each arm, for the surest of its components."""
    track = Track.of(log)
    if len(track.time) < 2 * MEASURED or not track.is_fast(WIDTH):
        return ()
    told = []
    for name in log.arms:
        found = [(wave_of(log, track, name, i), c, unit) for c, i, unit in COMPONENTS]
        there = [(wave, c, unit) for wave, c, unit in found if wave is not None]
        if not there:
            continue
        wave, component, unit = max(there, key=lambda one: one[0].log_odds)
        probability = from_odds(wave.log_odds - math.log(len(there)) + math.log(ODDS["offset"]))
        if probability >= TOLD:
            words = (
                f"{printable(name)}: {component} has a wave of {wave.amplitude:.2g} {unit} that repeats every "
                f"{wave.period:.3g} m rolled (a wheel of radius {wave.period / (2 * math.pi):.3g} m): an offset of a "
                "sensor that turns with the wheel, or a wheel that is not round; tare the sensor in its own axes"
            )
            told.append(Suspicion("offset", name, probability, wave.period, words))
    return tuple(told)


def wave_of(log: RunLog, track: Track, name: str, component: int) -> Wave | None:
    """The likeliest wave of a component; None where too little is rolled or recorded."""
    column = log.arms[name].wrench[:, component]
    there = np.isfinite(column)
    if there.sum() < 2 * MEASURED or np.ptp(column[there]) == 0:
        return None
    time = log.time[there]
    bumps = Bumps.over(track.time, max(track.width(WIDTH), MEASURED * float(np.median(np.diff(time)))))
    if len(bumps.centres) < FEWEST:
        return None
    sums = bumps.on(time)
    weight = sums.integral(np.ones_like(time))
    kept = sums.covered & bumps.on(track.time).covered
    kept &= np.abs(bumps.centres - bumps.centres.mean()) < LONGEST_STRETCH / 2
    speed = track.speeds(track.time)[:, 0]
    rolled = np.concatenate([[0.0], np.cumsum(middles(speed) * np.diff(track.time))])
    way = np.interp(bumps.centres, track.time, rolled)
    kept &= np.abs(way - np.median(way)) < FARTHEST / 2
    kept &= np.abs(np.interp(bumps.centres, track.time, speed)) > STANDING
    if kept.sum() < FEWEST:
        return None
    force = (sums.integral(column[there]) / np.maximum(weight, 1e-12))[kept]
    centre = bumps.centres[kept]
    return _likeliest(force, _motion(track, centre), way[kept], centre)


def _motion(track: Track, centre: Array) -> Array:
    """Columns (k, ·) of what motion makes: speeds, directions, a drift, and accelerations now and around, so that any
    sluggish answer of loads and people is taken out, but not what no motion follows."""
    u, _, r = track.speeds(centre).T
    t = (centre - centre[0]) / max(centre[-1] - centre[0], 1e-9)
    always = [np.ones_like(u), t, u, u * np.abs(u), np.tanh(u / STANDING), r, np.tanh(r / STANDING), u * r, r**2]
    around = [one for late in ANSWERS for one in _accelerations(track, centre + late)]
    return np.column_stack([*always, *around])


def _accelerations(track: Track, time: Array) -> tuple[Array, Array]:
    u, _, r = track.speeds(time).T
    return np.gradient(u, time), np.gradient(r, time)


def _likeliest(force: Array, columns: Array, way: Array, time: Array) -> Wave | None:
    """Harmonics of time are taken out one by one, the largest first, until one of the way is larger, or none shows."""
    rolled, span = float(np.ptp(way)), float(np.ptp(time))
    longest = min(LONGEST_WAVE, rolled / TURNS)
    if longest <= SHORTEST_WAVE:
        return None
    rates = np.arange(TURNS / 2 / span, FASTEST_STROKE, 1 / (FINE * span))
    numbers = np.arange(1 / longest, 1 / SHORTEST_WAVE, 1 / (FINE * rolled))
    axes, over_time, over_way = _axes(columns), _pairs(time, rates), _pairs(way, numbers)
    for _ in range(HANDS + 1):
        left = force - axes @ (axes.T @ force)
        if not left @ left > EMPTY * (force @ force):
            return None
        by_time, by_way = _explained(left, axes, over_time), _explained(left, axes, over_way)
        best, stroke = int(by_way[0].argmax()), int(by_time[0].argmax())
        rows = independent_rows(left)
        shows = -0.5 * rows * math.log(1 - min(float(by_time[0][stroke]), 1 - EMPTY)) > math.log(rows * len(rates))
        if by_way[0][best] > by_time[0][stroke] or not shows:
            break
        axes = np.column_stack([axes, _axes(_beside(over_time[stroke], axes))])
    log_odds = _kept(left, _beside(over_way[best], axes)) - math.log(len(numbers))
    return Wave(float(by_way[1][best]), float(1 / numbers[best]), log_odds)


def _kept(left: Array, pair: Array) -> float:
    """Log evidence of a pair of columns (k, 2) for what is left (k,): what each of `PIECES` stretches gains in
    likelihood by the amplitudes of all others. A wave of a wheel keeps step; strokes of hands don't."""
    total = left - pair @ np.linalg.lstsq(pair, left, rcond=1e-9)[0]
    foretold = left.copy()
    for piece in np.array_split(np.arange(len(left)), PIECES):
        others = np.setdiff1d(np.arange(len(left)), piece)
        values = np.linalg.lstsq(pair[others], left[others], rcond=1e-9)[0]
        foretold[piece] -= pair[piece] @ values
    ratio = float(foretold @ foretold) / float(left @ left)
    return -0.5 * independent_rows(total) * math.log(max(ratio, 1e-12))


def _axes(columns: Array) -> Array:
    """An orthonormal basis (k, ·) of columns."""
    size = np.linalg.norm(columns, axis=0)
    left, values, _ = np.linalg.svd(columns / np.where(size > 0, size, 1.0), full_matrices=False)
    return np.asarray(left[:, values > 1e-8 * values[0]])


def _pairs(along: Array, numbers: Array) -> Array:
    """Cosines and sines (m, 2, k) of a variable (k,) with wave numbers (m,)."""
    phase = 2 * math.pi * numbers[:, None] * along
    return np.stack([np.cos(phase), np.sin(phase)], axis=1)


def _beside(pair: Array, axes: Array) -> Array:
    """A pair (2, k) as columns (k, 2) beside axes."""
    return np.asarray(pair.T - axes @ (axes.T @ pair.T))


def _explained(left: Array, axes: Array, pairs: Array) -> tuple[Array, Array]:
    """Shares (m,) of what is left (k,) beside axes that pairs (m, 2, k) explain, and their amplitudes (m,)."""
    shared, seen = pairs @ axes, pairs @ left
    gram = np.einsum("mik,mjk->mij", pairs, pairs) - shared @ shared.transpose(0, 2, 1)
    values = np.linalg.solve(gram + 1e-9 * len(left) * np.eye(2), seen[..., None])[..., 0]
    return (values * seen).sum(axis=1) / (left @ left), np.hypot(values[:, 0], values[:, 1])
