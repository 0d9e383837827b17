"""Which components recorded velocities are: of {s}, as they should be, of the cart's own axes, swapped or reversed.

Each reading turns them into velocities in {s}; the one that explains poses, with any positive gain, is right.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from cartgrasp.frames import Array
from cartgrasp.logs import RunLog

from ..evidence import gain_evidence, independent_rows, probabilities
from ..prior import ANY_GAIN, FAULTS, TRUEST
from ..suspicion import SURE, TOLD, Suspicion
from .track import Track
from .velocity_clock import best_lag
from .velocity_rows import VelocityRows, linear_rows, yaw_rows

Turn = Callable[[Array, Array], Array]
"""From recorded velocities (n, 3) and headings (n,) to those that the log should have (n, 3)."""


@dataclass(frozen=True)
class Reading:
    """The kind of its fault ("" for none), where it is, its probability before a log is seen, and words."""

    kind: str
    where: str
    prior: float
    words: str
    turn: Turn


def _of_cart(velocity: Array, heading: Array) -> Array:
    c, s = np.cos(heading), np.sin(heading)
    u, w, r = velocity.T
    return np.column_stack([c * u - s * w, s * u + c * w, r])


def _times(*signs: float) -> Turn:
    return lambda velocity, _: velocity * np.array(signs)


def readings(where: str) -> tuple[Reading, ...]:
    """Of `velocity` or `yaw_rate`, the sound one first."""
    faults = FAULTS[where]
    sound = Reading("", where, 1 - sum(faults.values()), "", _times(1, 1, 1))
    if where == "yaw_rate":
        words = "omega has the opposite sign of what theta does; multiply it by -1 (it is positive to the left)"
        return sound, Reading("sign", where, faults["reversed"], words, _times(1, 1, -1))
    return (
        sound,
        Reading(
            *("frame", where, faults["in the cart's frame"]),
            "vx and vy are along the cart's own axes; turn them by theta into the world's, of which x and y are",
            _of_cart,
        ),
        Reading(
            *("axes", where, faults["swapped"], "vx and vy are swapped against x and y; exchange them"),
            lambda velocity, _: velocity[:, [1, 0, 2]],
        ),
        Reading(
            *(
                "sign",
                where,
                faults["reversed"],
                "vx and vy have the opposite sign of what x and y do; multiply them by -1",
            ),
            _times(-1, -1, 1),
        ),
        Reading(
            *("sign", where, faults["y reversed"], "vy has the opposite sign of what y does; multiply it by -1"),
            _times(1, -1, 1),
        ),
        Reading(
            *("sign", where, faults["y reversed"], "vx has the opposite sign of what x does; multiply it by -1"),
            _times(-1, 1, 1),
        ),
    )


def reading_probabilities(log: RunLog, where: str) -> Array | None:
    """Of `readings(where)` (k,); None where there are no velocities, or too few."""
    track = Track.of(log)
    if log.velocity is None or len(track.time) < 2:
        return None
    heading = track.headed(log.time)
    seen = [_seen(track, log, one, heading) for one in readings(where)]
    whole = [one for one in seen if one is not None]
    if len(whole) < len(seen) or not all(np.any(y) for y, _ in whole):
        return None
    best = min((_left(*one) for one in whole), key=lambda left: float(left @ left) / len(left))
    rows = independent_rows(best)
    log_evidence = [
        gain_evidence((np.array([z @ z]), np.array([y @ z]), float(y @ y)), rows, np.zeros(1), ANY_GAIN, TRUEST**2)[0][
            0
        ]
        + 0.5 * rows * math.log(float(y @ y))
        for y, z in whole
    ]
    return probabilities(np.array(log_evidence), np.array([one.prior for one in readings(where)]))


def _seen(track: Track, log: RunLog, reading: Reading, heading: Array) -> tuple[Array, Array] | None:
    """What bumps see of poses, and of velocities at the lag that suits them (n,)."""
    if log.velocity is None:
        return None
    velocity = reading.turn(log.velocity, heading)
    is_yaw = reading.where == "yaw_rate"
    rows: VelocityRows | None = (
        yaw_rows(track, log.time, velocity[:, 2]) if is_yaw else linear_rows(track, log.time, velocity[:, :2])
    )
    lag = None if rows is None else best_lag(rows)
    found = None if rows is None or lag is None else rows.at(lag)
    return None if found is None else (found[0], found[1][:, 0])


def _left(seen: Array, velocity: Array) -> Array:
    return seen - velocity * max(float(seen @ velocity), 0.0) / max(float(velocity @ velocity), 1e-300)


def velocity_check(log: RunLog) -> dict[str, Array]:
    """`reading_probabilities` by where, of what is there."""
    found = {where: reading_probabilities(log, where) for where in ("velocity", "yaw_rate")}
    return {where: probability for where, probability in found.items() if probability is not None}


def velocity_suspicions(check: dict[str, Array]) -> tuple[Suspicion, ...]:
    """`frame`, `axes` and `sign` of velocities and yaw rates."""
    told = []
    for where, probability in check.items():
        known = readings(where)
        for kind in ("frame", "axes", "sign"):
            which = [i for i, one in enumerate(known) if one.kind == kind]
            total = float(probability[which].sum())
            if total >= TOLD:
                words = known[max(which, key=lambda i: float(probability[i]))].words
                told.append(Suspicion(kind, where, total, -1.0 if kind == "sign" else None, words))
    return tuple(told)


def velocities_turned_right(log: RunLog, check: dict[str, Array]) -> RunLog:
    """The log with velocities as the surest readings have them."""
    for where, probability in check.items():
        if log.velocity is not None and probability[1:].max() >= SURE:
            heading = Track.of(log).headed(log.time)
            log = replace(log, velocity=readings(where)[int(probability.argmax())].turn(log.velocity, heading))
    return log
