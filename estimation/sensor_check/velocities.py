"""Recorded velocities that are late, too large, in another unit, or of other axes than the poses beside them.

With velocities v(t) = gain * v_true(t - lag), each window sees

    ∫ phi dx = 1/gain ∫ phi(t - lag) v dt + lever terms,

where the lever is the place of the velocities' point in the poses' frame. Solved for both by Gauss and Newton. Of a
speed that fades evenly a lag looks like a scale, and noise alone would tell them apart: then neither is told.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from cartgrasp.frames import Array
from cartgrasp.logs import RunLog

from ..log_noise.log_noise import white_noise
from .evidence import gross_error_probability, independent_rows, reading_probabilities
from .suspicion import REFUSAL_PROBABILITY, REPORT_PROBABILITY, Suspicion
from .windows import MAX_SAMPLE_INTERVAL, MIN_WINDOWS, Sums, Track, Windows

VELOCITY_LAG_STDS, LATE_VELOCITY_ODDS = (0.002, 0.05), 0.2
"""s by which sound velocities are late (what clocks of one machine differ by) and wrong ones (filters, buses, means
over the last row); odds of the latter: one log in six."""
VELOCITY_LOG_GAIN_STDS, WRONG_VELOCITY_GAIN_ODDS = (0.005, 0.1), 0.1
"""Spreads of the log gain of sound velocities, from one calibrated device, and of wrong ones (worn or mistaken wheels);
odds of the latter."""
WRONG_VELOCITY_AXES_ODDS = 0.01
"""Odds of each way in which axes are mistaken: one log in a hundred."""
VELOCITY_UNITS = {"mm/s": 1e-3, "cm/s": 1e-2, "km/h": 1 / 3.6, "ft/s": 0.3048}
"""What velocities are multiplied by to be m/s. Where places are in one of them and velocities aren't, its inverse."""
SAME_UNIT_TOLERANCE = 0.1
"""Spread of the log gain that calibration leaves."""
MAX_VELOCITY_LAG, LAG_GRID_STEP = 0.4, 0.1
"""s: of lags that are looked for, and between those with which a search begins; half a start or stop."""
MAX_LAG_ITERATIONS, LAG_TOLERANCE = 12, 1e-6
"""Most rounds of Gauss and Newton; change of the lag (s) below which they end."""
MAX_LAG_NOISE_FRACTION = 0.1
"""Share of what tells lags from scales that noise may make."""
MIN_EXPLAINED_FRACTION = 0.5
"""Least share of what poses do that velocities must explain before their clock can be told."""


@dataclass(frozen=True)
class Sensor:
    """Some columns of the velocities, and what they are called."""

    where: str
    what: str
    columns: slice
    units: dict[str, float]


VELOCITY_SENSORS = (
    Sensor("velocity", "velocities (vx, vy)", slice(0, 2), VELOCITY_UNITS),
    Sensor("yaw_rate", "yaw rates (omega)", slice(2, 3), {"deg/s": math.pi / 180}),
)

VelocityMap = Callable[[Array, Array], Array]
"""From recorded velocities (n, 3) and headings (n,) to those that the log should have (n, 3)."""


def _of_cart(velocity: Array, heading: Array) -> Array:
    c, s = np.cos(heading), np.sin(heading)
    u, w, r = velocity.T
    return np.column_stack([c * u - s * w, s * u + c * w, r])


def _times(*signs: float) -> VelocityMap:
    return lambda velocity, _: velocity * np.array(signs)


VELOCITY_READINGS: dict[str, tuple[tuple[str, str, VelocityMap], ...]] = {
    "velocity": (
        ("", "", _times(1, 1, 1)),
        ("frame", "vx and vy are along the cart's own axes; turn them by theta into the world's", _of_cart),
        ("axes", "vx and vy are swapped against x and y; exchange them", lambda v, _: v[:, [1, 0, 2]]),
        ("sign", "vx and vy are opposed to what x and y do; multiply them by -1", _times(-1, -1, 1)),
        ("sign", "vy is opposed to what y does; multiply it by -1", _times(1, -1, 1)),
        ("sign", "vx is opposed to what x does; multiply it by -1", _times(-1, 1, 1)),
    ),
    "yaw_rate": (
        ("", "", _times(1, 1, 1)),
        ("sign", "omega is opposed to what theta does; multiply it by -1", _times(1, 1, -1)),
    ),
}
"""Kind, words and turn of the ways in which velocities may be meant, the sound one first."""


def corrected_velocities(log: RunLog) -> tuple[RunLog, tuple[Suspicion, ...]]:
    """The log with velocities on the poses' clock and scale, and what was found. What is of other axes or units is
    told, and left as it is."""
    told = list[Suspicion]()
    if log.velocity is None or not np.isfinite(log.velocity).any():
        return log, ()
    track, velocity = Track.of(log), log.velocity.copy()
    for sensor in VELOCITY_SENSORS:
        rates = Rates.of(track, log.time, log.velocity[:, sensor.columns])
        if rates is None:
            continue
        wrong = _axes(log.velocity, np.interp(log.time, track.time, track.heading), rates, sensor)
        told += wrong
        fit = None if wrong else clock(rates)
        if fit is None:
            continue
        found = _late_or_large(fit, sensor)
        told += found
        lag = next((fit.lag for one in found if one.kind == "lag" and one.put_right), 0.0)
        gain = next((fit.gain for one in found if one.kind == "scale" and one.put_right), 1.0)
        own = velocity[rates.there, sensor.columns]  # rows of slower sensors are blank in between
        velocity[rates.there, sensor.columns] = later(rates.time, own, lag) / gain
    return replace(log, velocity=velocity), tuple(told)


def _axes(velocity: Array, heading: Array, rates: Rates, sensor: Sensor) -> list[Suspicion]:
    """Suspicions of a sensor's columns, by how much of what poses do each reading explains."""
    readings, left = VELOCITY_READINGS[sensor.where], list[tuple[Array, float]]()
    for best in best_lags([rates.read_as(turn(velocity, heading)[:, sensor.columns]) for _, _, turn in readings]):
        if best is None or not best[1].any():
            return []
        _, seen, z = best
        left.append((seen - z * max(float(seen @ z), 0.0) / max(float(z @ z), 1e-300), float(seen @ seen)))
    odds = np.array([1.0] + [WRONG_VELOCITY_AXES_ODDS] * (len(readings) - 1))
    best_of = dict[str, tuple[float, str]]()
    for (kind, words, _), p in zip(readings, reading_probabilities(left, odds).tolist(), strict=True):
        best_of[kind] = max(best_of.get(kind, (0.0, "")), (p, words))
    return [
        Suspicion(kind, sensor.where, p, None, words)
        for kind, (p, words) in best_of.items()
        if kind and p >= REPORT_PROBABILITY
    ]


def _late_or_large(fit: Clock, sensor: Sensor) -> list[Suspicion]:
    """`lag` and `scale`, or `unit`, where one is likelier than not: then it is put right."""
    told = []
    log_gain, gain_std = math.log(fit.gain), fit.gain_std / fit.gain
    late = gross_error_probability(fit.lag, fit.lag_std, *VELOCITY_LAG_STDS, LATE_VELOCITY_ODDS)
    large = gross_error_probability(log_gain, gain_std, *VELOCITY_LOG_GAIN_STDS, WRONG_VELOCITY_GAIN_ODDS)
    if late > 0.5:
        words = (
            f"{sensor.what} come {abs(fit.lag) * 1e3:.1f} ± {fit.lag_std * 1e3:.1f} ms "
            f"{'late' if fit.lag > 0 else 'early'} against the poses; a diagnosis takes them at the poses' clock: give "
            "the sensor's latency, or record both with one clock"
        )
        told.append(Suspicion("lag", sensor.where, late, fit.lag, words, put_right=True))
    unit = _unit(log_gain, sensor)
    if unit is not None:
        where, words, factor = unit
        told.append(Suspicion("unit", where, max(large, REFUSAL_PROBABILITY), factor, words))
    elif large > 0.5:
        words = (
            f"{sensor.what} are {fit.gain:.4f} ± {fit.gain_std:.4f} times what the poses do; a diagnosis divides "
            "them by that: calibrate the wheels' radius or the tracker"
        )
        told.append(Suspicion("scale", sensor.where, large, fit.gain, words, put_right=True))
    return told


def _unit(log_gain: float, sensor: Sensor) -> tuple[str, str, float] | None:
    """Where, words and factor of the unit that a gain is of: the velocities', or that of the poses beside them."""
    poses, columns = ("pose", "x and y") if sensor.where == "velocity" else ("heading", "theta")
    for name, factor in sensor.units.items():
        if abs(log_gain + math.log(factor)) < SAME_UNIT_TOLERANCE:
            words = f"{sensor.what} seem to be in {name} against {columns}; multiply them by {factor:.6g}"
            return sensor.where, words, factor
        if abs(log_gain - math.log(factor)) < SAME_UNIT_TOLERANCE:
            words = f"{columns} seem to be in {name.removesuffix('/s')} against {sensor.what}; multiply by {factor:.6g}"
            return poses, words, factor
    return None


@dataclass(frozen=True)
class Clock:
    """Lag (s) and gain of velocities against poses, with standard deviations."""

    lag: float
    lag_std: float
    gain: float
    gain_std: float


@dataclass(frozen=True)
class Rates:
    """Rates (m, d) at rows of a log (n,), m of them whole, and times (m,), beside what windows see of their poses
    (d, k) and of levers (d, k, q)."""

    windows: Windows
    there: np.ndarray
    time: Array
    rate: Array
    seen: Array
    levers: Array
    covered: np.ndarray

    @classmethod
    def of(cls, track: Track, time: Array, rate: Array) -> Rates | None:
        """The rates from linear velocities (m, 2) in {s}, or yaw rates (m, 1), NaN where missing; None where there are
        too few."""
        there = np.asarray(np.isfinite(rate).all(axis=1))
        windows = Windows.over(track.time, time[there])
        if windows is None:
            return None
        sums = windows.on(track.time)
        if rate.shape[1] == 1:
            seen = sums.along(track.heading)[None]
            levers = np.zeros((*seen.shape, 0))
        else:
            c, s = np.cos(track.heading), np.sin(track.heading)
            seen = np.array([sums.along(track.x), sums.along(track.y)])
            levers = np.array([[sums.along(c), -sums.along(s)], [sums.along(s), sums.along(c)]]).swapaxes(1, 2)
        return cls(windows, there, time[there], rate[there], seen, levers, sums.covered)

    def read_as(self, rate: Array) -> Rates:
        """The same rows and poses with other rates (n, d)."""
        return replace(self, rate=rate[self.there])

    def by(self, sums: Sums) -> tuple[Array, Array, float] | None:
        """What is seen (n,), its columns by 1/gain and by lag (n, 2), both beside levers, and what noise of variance 1
        adds to the latter's sum of squares. None where windows are too few."""
        kept = sums.covered & self.covered
        if kept.sum() < MIN_WINDOWS:
            return None
        columns = np.stack([sums.integral(self.rate).T, sums.rate(self.rate).T], axis=-1)[:, kept].reshape(-1, 2)
        both = np.column_stack([self.seen[:, kept].ravel(), columns])
        levers = self.levers[:, kept].reshape(len(both), -1)
        if levers.shape[1]:
            both = both - levers @ np.linalg.lstsq(levers, both, rcond=1e-9)[0]
        return both[:, 0], both[:, 1:], sums.rate_noise(kept)


LagFit = tuple[float, Array, Array]
"""A lag (s), with what is seen and what velocities say (n,)."""


def best_lags(readings: Sequence[Rates]) -> list[LagFit | None]:
    """The lag of a coarse grid that leaves least, for rates at the same rows that are read in several ways."""
    tried: list[list[tuple[float, LagFit]]] = [[] for _ in readings]
    for lag in np.arange(-MAX_VELOCITY_LAG, MAX_VELOCITY_LAG + LAG_GRID_STEP / 2, LAG_GRID_STEP).tolist():
        sums = readings[0].windows.on(readings[0].time, lag)
        for rates, own in zip(readings, tried, strict=True):
            found = rates.by(sums)
            if found is not None:
                seen, z = found[0], found[1][:, 0]
                along, size = max(float(seen @ z), 0.0), max(float(z @ z), 1e-300)
                own.append(((float(seen @ seen) - along**2 / size) / len(seen), (lag, seen, z)))
    return [min(own, key=lambda one: one[0])[1] if own else None for own in tried]


def clock(rates: Rates | None) -> Clock | None:
    """None where motion and log are too little to tell, or velocities are of something else."""
    start = None if rates is None else best_lags([rates])[0]
    if rates is None or start is None:
        return None
    lag, variance = start[0], sum(white_noise(column) ** 2 for column in rates.rate.T)
    for _ in range(MAX_LAG_ITERATIONS):
        found = rates.by(rates.windows.on(rates.time, lag))
        if found is None:
            return None
        seen, columns, noise = found
        normal = columns.T @ columns
        if variance * noise >= MAX_LAG_NOISE_FRACTION * (normal[1, 1] - normal[0, 1] ** 2 / max(normal[0, 0], 1e-300)):
            return None
        values = np.linalg.solve(normal, columns.T @ seen)
        if values[0] <= 0:
            return None
        change = float(np.clip(values[1] / values[0], -LAG_GRID_STEP / 2, LAG_GRID_STEP / 2))
        lag += change
        if abs(change) < LAG_TOLERANCE:
            break
    left = seen - columns @ values
    if left @ left > (1 - MIN_EXPLAINED_FRACTION) * (seen @ seen) or abs(lag) > MAX_VELOCITY_LAG + LAG_GRID_STEP:
        return None
    rows = max(independent_rows(left) - 2, 1.0)
    std = np.sqrt(np.diag(np.linalg.inv(normal)) * (left @ left) / rows)
    return Clock(lag, float(std[1] / values[0]), float(1 / values[0]), float(std[0] / values[0] ** 2))


def later(time: Array, columns: Array, lag: float) -> Array:
    """What columns (n, k) say `lag` (s) later, by cubics through four rows (Catmull and Rom), which leave more of the
    noise white than straight lines do; NaN where those are too far apart."""
    if lag == 0:
        return columns
    i = np.searchsorted(time, time + lag, side="right") - 1
    rows = np.clip(i[:, None] + np.arange(-1, 3), 0, len(time) - 1)
    at = time[rows].T
    inside = (i >= 0) & (i < len(time) - 1) & (np.diff(at, axis=0).max(axis=0) <= MAX_SAMPLE_INTERVAL)
    step = np.where(inside, at[2] - at[1], 1.0)
    s = np.where(inside, (time + lag - at[1]) / step, 0.0)
    first, last = (
        slope * step / np.where(inside, far, 1.0)
        for slope, far in ((s - 2 * s**2 + s**3, at[2] - at[0]), (s**3 - s**2, at[3] - at[1]))
    )
    rise = 3 * s**2 - 2 * s**3
    moved = np.einsum("jn,njk->nk", [-first, 1 - rise - last, rise + first, last], columns[rows])
    return np.where(inside[:, None], moved, np.nan)
