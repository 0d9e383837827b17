"""By how much recorded velocities are later, and larger, than poses say: Gauss-Newton on `VelocityRows`, with
deviations from how stretches of the log disagree (clusters), so that noise may remember."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from cartgrasp.frames import Array
from cartgrasp.logs import RunLog

from ..evidence import from_odds, log_normal_density
from ..prior import GAIN_WRONG, LAG_WRONG, LEAST_LAG, ODDS, SOUND_GAIN
from ..recorder.jumps import without_jumps
from ..recorder.repeats import without_repeats
from ..suspicion import SURE, TOLD, Suspicion
from .track import WIDEST, Track
from .velocity_rows import WIDTH, VelocityRows, linear_rows, yaw_rows

LONGEST = 0.4
"""s: of lags that are looked for."""
START = 0.1
"""s between lags with which a search begins; half a start or stop."""
STEPS, ENOUGH = 12, 1e-7
"""Of Gauss-Newton, at most; s by which the lag still changes at the end."""
FEWEST_STRETCHES = 5
"""Of which deviations can be told."""
LEAST_SHARE = 0.5
"""Of what is seen that velocities must explain before their clock can be told."""
SAFE_GAIN = 0.3
"""Of log gain: velocities further off are in another unit, or of something else."""


@dataclass(frozen=True)
class ClockFit:
    """Lag (s) and gain of velocities against poses, with standard deviations."""

    lag: float
    lag_std: float
    gain: float
    gain_std: float


def clock_fit(rows: VelocityRows | None) -> ClockFit | None:
    """None where motion and log are too little to tell, or velocities are of something else."""
    lag = None if rows is None else best_lag(rows)
    if rows is None or lag is None:
        return None
    for _ in range(STEPS):
        solved = _solved(rows, lag)
        if solved is None:
            return None
        change = solved[0][1] / solved[0][0]
        lag += float(np.clip(change, -START / 2, START / 2))
        if abs(change) < ENOUGH:
            break
    found = rows.at(lag)
    solved = _solved(rows, lag)
    if found is None or solved is None or abs(lag) > 1.2 * LONGEST:
        return None
    seen, columns, stretch = found
    (inverse, _), left = solved
    if left @ left > (1 - LEAST_SHARE) * (seen @ seen):
        return None
    deviations = _clustered(columns, left, stretch)
    if deviations is None:
        return None
    return ClockFit(lag, deviations[1] / inverse, 1 / inverse, deviations[0] / inverse**2)


def best_lag(rows: VelocityRows) -> float | None:
    """Of a coarse grid, s."""
    costs: dict[float, float] = {}
    for lag in map(float, np.arange(-LONGEST, LONGEST + START / 2, START)):
        found = rows.at(lag)
        if found is not None:
            seen, columns, _ = found
            z = columns[:, 0]
            along, size = float(seen @ z), float(z @ z)
            costs[lag] = (float(seen @ seen) - along**2 / max(size, 1e-300)) / len(seen)
    return min(costs, key=lambda lag: costs[lag]) if costs else None


def _solved(rows: VelocityRows, lag: float) -> tuple[Array, Array] | None:
    """Coefficients (2,) of gain's inverse and of it times the lag's change, and what is left (n,)."""
    found = rows.at(lag)
    if found is None:
        return None
    seen, columns, _ = found
    solved, _, rank, _ = np.linalg.lstsq(columns, seen, rcond=1e-9)
    values = np.asarray(solved, dtype=float)
    return (values, seen - columns @ values) if rank == 2 and values[0] > 0 else None


def _clustered(columns: Array, left: Array, stretch: np.ndarray) -> tuple[float, float] | None:
    """Standard deviations of the two coefficients from sums of scores over stretches (Liang and Zeger, 1986)."""
    scores = np.zeros((int(stretch.max()) + 1, 2))
    np.add.at(scores, stretch, columns * left[:, None])
    count = len(np.unique(stretch))
    if count < FEWEST_STRETCHES:
        return None
    bread = np.linalg.inv(columns.T @ columns)
    covariance = bread @ (scores.T @ scores) @ bread * count / (count - 2)
    first, second = np.sqrt(np.diag(covariance))
    return float(first), float(second)


def linear_clock(log: RunLog) -> ClockFit | None:
    """Of linear velocities."""
    if log.velocity is None:
        return None
    return clock_fit(_if_fast(linear_rows(Track.of(log), log.time, log.velocity[:, :2])))


def yaw_clock(log: RunLog) -> ClockFit | None:
    """Of yaw rates."""
    if log.velocity is None:
        return None
    return clock_fit(_if_fast(yaw_rows(Track.of(log), log.time, log.velocity[:, 2])))


def _if_fast(rows: VelocityRows | None) -> VelocityRows | None:
    """None where rows come too slowly for a clock to be told."""
    return rows if rows is not None and rows.bumps.width <= WIDEST * WIDTH else None


CLOCKS: tuple[tuple[str, str, slice, Callable[[RunLog], ClockFit | None]], ...] = (
    ("velocity", "velocities (vx, vy)", slice(0, 2), linear_clock),
    ("yaw_rate", "yaw rates (omega)", slice(2, 3), yaw_clock),
)


def lag_probability(fit: ClockFit, step: float) -> float:
    """That velocities come at another time than poses; within half a `step` between rows nobody can say."""
    sound = max(step / 2, LEAST_LAG)
    return _wider(fit.lag, fit.lag_std, sound, LAG_WRONG, ODDS["lag"])


def scale_probability(fit: ClockFit) -> float:
    """That velocities have another scale."""
    return _wider(math.log(fit.gain), fit.gain_std / fit.gain, SOUND_GAIN, GAIN_WRONG, ODDS["scale"])


def _wider(value: float, std: float, sound: float, wrong: float, odds: float) -> float:
    """Probability that a value measured with `std` is spread by `wrong` rather than `sound`."""
    wide, narrow = math.hypot(std, wrong), math.hypot(std, sound)
    return from_odds(float(log_normal_density(value, wide) - log_normal_density(value, narrow)) + math.log(odds))


def late_or_scaled(log: RunLog) -> tuple[Suspicion, ...]:
    """`lag` and `scale` of linear velocities and yaw rates."""
    told = []
    for where, what, _, fitted in CLOCKS:
        fit = fitted(log)
        if fit is None:
            continue
        lag, late = lag_probability(fit, _step(log)), "late" if fit.lag > 0 else "early"
        words = (
            f"{what} come {abs(fit.lag) * 1e3:.1f} ± {fit.lag_std * 1e3:.1f} ms {late} against the poses; "
            "shift them to the poses' clock, or give the sensor's latency"
        )
        told.append(Suspicion("lag", where, lag, fit.lag, words))
        words = (
            f"{what} are {fit.gain:.4f} ± {fit.gain_std:.4f} times what the poses do; divide them by that, or "
            "calibrate the wheels' radius or the tracker"
        )
        told.append(Suspicion("scale", where, scale_probability(fit), fit.gain, words))
    return tuple(one for one in told if one.probability >= TOLD)


def velocities_put_right(log: RunLog, sure: float = SURE) -> RunLog:
    """The log with velocities on the poses' clock and scale, where lag or scale are at least as likely as `sure`. What
    lies before the first or after the last velocity is missing."""
    if log.velocity is None:
        return log
    velocity, clean = log.velocity.copy(), without_jumps(without_repeats(log))
    for _, _, which, fitted in CLOCKS:
        fit = fitted(clean)
        if fit is None or abs(math.log(fit.gain)) > SAFE_GAIN:
            continue
        lag = fit.lag if lag_probability(fit, _step(log)) >= sure else 0.0
        gain = fit.gain if scale_probability(fit) >= sure else 1.0
        velocity[:, which] = _at_other_times(log.time, velocity[:, which], lag) / gain
    return replace(log, velocity=velocity)


def _at_other_times(time: Array, columns: Array, lag: float) -> Array:
    """What columns (n, k) say `lag` later, by cubics through four rows (Catmull and Rom), which leave more of the
    noise white than straight lines do; NaN where a row of the four is missing."""
    if lag == 0:
        return columns
    i = np.searchsorted(time, time + lag, side="right") - 1
    inside = (i >= 0) & (i < len(time) - 1)
    rows = np.clip(i[:, None] + np.arange(-1, 3), 0, len(time) - 1)
    first, last = time[rows[:, 1]], time[rows[:, 2]]
    s = np.where(inside, (time + lag - first) / np.where(inside, last - first, 1.0), 0.0)
    weights = 0.5 * np.column_stack(
        [-s + 2 * s**2 - s**3, 2 - 5 * s**2 + 3 * s**3, s + 4 * s**2 - 3 * s**3, -(s**2) + s**3]
    )
    moved = np.einsum("nj,njk->nk", weights, columns[rows])
    return np.where(inside[:, None], moved, np.nan)


def _step(log: RunLog) -> float:
    return float(np.median(np.diff(log.time))) if len(log) > 1 else 0.0
