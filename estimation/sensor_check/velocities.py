"""Recorded velocities that are late, too large, in another unit, or of other axes than the poses beside them."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from cartgrasp.frames import Array
from cartgrasp.logs import RunLog

from .clock import Clock, Rates, best_lags, clock
from .evidence import gross_error_probability, reading_probabilities
from .suspicion import REFUSAL_PROBABILITY, REPORT_PROBABILITY, Suspicion
from .windows import Track

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
        velocity[:, sensor.columns] = later(log.time, velocity[:, sensor.columns], lag) / gain
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
    if large > 0.5 and unit is None:
        words = (
            f"{sensor.what} are {fit.gain:.4f} ± {fit.gain_std:.4f} times what the poses do; a diagnosis divides "
            "them by that: calibrate the wheels' radius or the tracker"
        )
        told.append(Suspicion("scale", sensor.where, large, fit.gain, words, put_right=True))
    if unit is not None:
        where, words, factor = unit
        told.append(Suspicion("unit", where, max(large, REFUSAL_PROBABILITY), factor, words))
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


def later(time: Array, columns: Array, lag: float) -> Array:
    """What columns (n, k) say `lag` (s) later, by cubics through four rows (Catmull and Rom), which leave more of the
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
