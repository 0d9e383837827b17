"""Units of times, places, headings and velocities: which of them make sense together.

Speeds and the spacing of rows have usual sizes; velocities are as large as what poses do; and accelerations ask for the
mass that the file says, where forces are of a known unit or of any.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from cartgrasp.frames import Array
from cartgrasp.logs import RunLog

from ...log_noise import noise_floor
from ..evidence import gain_evidence, independent_rows, log_normal_density, probabilities
from ..prior import ANGLES, LENGTHS, ROW, ROW_SPREAD, SAME_GAIN, SPEED, SPEED_SPREAD, TIMES, TRUEST, UNITS
from ..suspicion import SURE, TOLD, Suspicion
from ..weak_form import Bumps
from .track import Track
from .velocity_clock import best_lag
from .velocity_rows import VelocityRows, linear_rows, yaw_rows

WIDTH = 0.8
"""s: of the bumps over which speeds are taken."""
SEEN = 10.0
"""Times the noise of places, from which a way is one that the cart went."""

MassEvidence = Callable[[Array], Array]
"""Log evidence (k,) of units (k,) of forces over accelerations."""


@dataclass(frozen=True)
class UnitCheck:
    """Entries of `TIMES`, `LENGTHS` and `ANGLES` that go together (k, 3), and their probabilities (k,)."""

    entries: np.ndarray
    probability: Array

    def of(self, column: int, entry: int) -> float:
        return float(self.probability[self.entries[:, column] == entry].sum())


def unit_check(log: RunLog, mass_evidence: MassEvidence, headings_known: bool) -> UnitCheck | None:
    """Without headings in degrees where `headings_known` says that they aren't. None where there are no poses."""
    track = Track.of(log)
    if len(track.time) < 3:
        return None
    angles = [i for i, one in enumerate(ANGLES) if not headings_known or one.names[0] == "rad"]
    entries = np.array(list(product(range(len(TIMES)), range(len(LENGTHS)), angles)))
    time, _ = np.array([one.factors for one in TIMES])[entries[:, 0]].T
    place, speed = np.array([one.factors for one in LENGTHS])[entries[:, 1]].T
    heading, yaw = np.array([one.factors for one in ANGLES])[entries[:, 2]].T
    log_evidence = log_normal_density(np.log(track.step * time / ROW), ROW_SPREAD)
    usual = _usual_speed(track)
    if usual is not None:
        log_evidence = log_evidence + log_normal_density(np.log(usual * place / time / SPEED), SPEED_SPREAD)
    if log.velocity is not None:
        linear = linear_rows(track, log.time, log.velocity[:, :2])
        log_evidence = log_evidence + _gain(linear, np.log(speed * time / place))
        turning = yaw_rows(track, log.time, log.velocity[:, 2])
        log_evidence = log_evidence + _gain(turning, np.log(yaw * time / heading))
    log_evidence = log_evidence + _of_masses(mass_evidence, time**2 / place)
    prior = np.array([TIMES[i].prior * LENGTHS[j].prior * ANGLES[k].prior for i, j, k in entries])
    return UnitCheck(entries, probabilities(log_evidence, prior))


def _usual_speed(track: Track) -> float | None:
    """What a tenth of the windows exceed; None where the cart hardly goes."""
    bumps = Bumps.over(track.time, track.width(WIDTH))
    sums, one = bumps.on(track.time), np.ones_like(track.time)
    if sums.covered.sum() < 2:
        return None
    way = np.hypot(sums.along(one, track.x), sums.along(one, track.y))[sums.covered]
    weight = sums.integral(one)[sums.covered]
    noise = max(noise_floor(track.x), noise_floor(track.y))
    far = float(np.quantile(way, 0.9))
    return float(np.quantile(way / weight, 0.9)) if far > SEEN * noise and far > 0 else None


def _gain(rows: VelocityRows | None, mean: Array) -> Array:
    """Log evidence (k,) of velocities whose gain's inverse is about exp(mean)."""
    lag = None if rows is None else best_lag(rows)
    found = None if rows is None or lag is None else rows.at(lag)
    if found is None:
        return np.zeros(len(mean))
    seen, velocity = found[0], found[1][:, 0]
    zz, zy, yy = float(velocity @ velocity), float(seen @ velocity), float(seen @ seen)
    if zz <= 0 or yy <= 0:
        return np.zeros(len(mean))
    rows_count = independent_rows(seen - velocity * max(zy, 0.0) / zz)
    products = np.full(len(mean), zz), np.full(len(mean), zy), yy
    return gain_evidence(products, rows_count, mean, SAME_GAIN, TRUEST**2)[0]


def _of_masses(mass_evidence: MassEvidence, per_acceleration: Array) -> Array:
    """Log evidence (k,) of units of 1 / acceleration, whatever forces are in."""
    forces: dict[float, float] = {}
    for _, (force, _), prior in UNITS:
        forces[force] = forces.get(force, 0.0) + prior
    found = np.array([mass_evidence(force * per_acceleration) + math.log(prior) for force, prior in forces.items()])
    top = found.max(axis=0)
    return np.asarray(top + np.log(np.exp(found - top).sum(axis=0)))


def unit_suspicions(check: UnitCheck) -> tuple[Suspicion, ...]:
    """`unit` of `time`, `pose`, `heading`, `velocity` and `yaw_rate`."""
    tables = ((0, TIMES, ("time", "")), (1, LENGTHS, ("pose", "velocity")), (2, ANGLES, ("heading", "yaw_rate")))
    told = []
    for column, table, names in tables:
        for side, where in enumerate(names):
            units: dict[str, tuple[float, float]] = {}
            for i, one in enumerate(table):
                _, total = units.get(one.names[side], (0.0, 0.0))
                units[one.names[side]] = one.factors[side], total + check.of(column, i)
            told.append(_told(where, units, table[0].names[side]))
    return tuple(one for one in told if one is not None)


COLUMNS = {"time": "t", "pose": "x and y", "velocity": "vx and vy", "heading": "theta", "yaw_rate": "omega"}


def _told(where: str, units: dict[str, tuple[float, float]], right: str) -> Suspicion | None:
    """Of units by name, with factors and probabilities."""
    wrong = {name: pair for name, pair in units.items() if name != right}
    probability = sum(pair[1] for pair in wrong.values())
    if probability < TOLD:
        return None
    name, (factor, _) = max(wrong.items(), key=lambda item: item[1][1])
    words = (
        f"{COLUMNS[where]} seem to be in {name}: in {right}, speeds, poses and accelerations would not go together; "
        f"multiply by {factor:.6g}"
    )
    return Suspicion("unit", where, probability, factor, words)


def units_put_right(log: RunLog, check: UnitCheck) -> RunLog:
    """The log in SI units, as far as they are sure."""
    best = check.entries[int(check.probability.argmax())]
    factors = [table[int(i)].factors for table, i in zip((TIMES, LENGTHS, ANGLES), best, strict=True)]
    sure = [check.of(column, int(best[column])) >= SURE for column in range(3)]
    (time, _), places, angles = (pair if is_sure else (1.0, 1.0) for pair, is_sure in zip(factors, sure, strict=True))
    pose = log.pose * np.array([places[0], places[0], angles[0]])
    velocity = None if log.velocity is None else log.velocity * np.array([places[1], places[1], angles[1]])
    return replace(log, time=log.time * time, pose=pose, velocity=velocity)
