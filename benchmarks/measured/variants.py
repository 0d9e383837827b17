"""Logs as somebody else would have recorded or printed them: pure functions from a run log to another.

What they change says nothing new of the cart, so names and values should stay. None draws a number of its own.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from cartgrasp.frames import Array, wrap_angle
from cartgrasp.logs import ArmLog, RunLog

from .fitted_velocities import fitted_velocities

FAST_CLOCK = 1.000008
"""Of a clock that runs 8 parts in a million fast: a millisecond is then a hair more than one, as a printed time's
rounding makes it."""
LATE, STRETCHED = 0.05, 1.03
"""s, and times: of velocities that another sensor gives than the poses."""
NOISE_SHARE = 0.05
"""Of the root mean square of each component of a wrench: noise of a sensor of a middling kind."""


@dataclass(frozen=True)
class Variant:
    """A change of the log, or a first guess of the mass at a share of the true one (None: as the cart is believed).
    `needs` says what a log must have for it: `force`, `velocity`."""

    name: str
    change: Callable[[RunLog], RunLog]
    guess: float | None = None
    needs: frozenset[str] = frozenset()


def unchanged(log: RunLog) -> RunLog:
    return log


def every(log: RunLog, size: int) -> RunLog:
    """One row of so many."""
    return taken(log, slice(None, None, size))


def first_part(log: RunLog, share: float) -> RunLog:
    return taken(log, log.time <= log.time[0] + share * log.duration)


def last_part(log: RunLog, share: float) -> RunLog:
    return taken(log, log.time >= log.time[-1] - share * log.duration)


def taken(log: RunLog, rows: slice | np.ndarray) -> RunLog:
    return by_columns(log, lambda column: column[rows])


def averaged(log: RunLog, size: int) -> RunLog:
    """Means of so many rows each, with the contacts of the first; rows at the end that are too few are lost."""
    n = len(log) // size * size

    def mean(table: Array) -> Array:
        return np.asarray(table[:n].reshape(-1, size, *table.shape[1:]).mean(axis=1))

    pose = log.pose[:n].copy()
    first = np.repeat(pose[::size, 2], size)
    pose[:, 2] = first + wrap_angle(pose[:, 2] - first)
    velocity = None if log.velocity is None else mean(log.velocity)
    arms = {name: ArmLog(arm.contact[:n:size], mean(arm.wrench)) for name, arm in log.arms.items()}
    return replace(log, time=mean(log.time), pose=mean(pose), velocity=velocity, arms=arms)


def resampled(log: RunLog, rate: float) -> RunLog:
    """At so many Hz, on the straight lines between rows; it begins half a step late, so that no row is as it was."""
    time = np.arange(log.time[0] + 0.5 / rate, log.time[-1], 1.0 / rate)

    def between(table: Array) -> Array:
        return np.column_stack([np.interp(time, log.time, column) for column in table.T])

    pose = log.pose.copy()
    seen = np.isfinite(pose[:, 2])
    pose[seen, 2] = np.unwrap(pose[seen, 2])
    velocity = None if log.velocity is None else between(log.velocity)
    arms = {name: ArmLog(between(arm.contact), between(arm.wrench)) for name, arm in log.arms.items()}
    return replace(log, time=time, pose=between(pose), velocity=velocity, arms=arms)


def printed_places(log: RunLog, step: float) -> RunLog:
    """Places to the next step, m; angles stay."""
    pose = log.pose.copy()
    pose[:, :2] = step * np.round(pose[:, :2] / step)
    return replace(log, pose=pose)


def printed_times(log: RunLog, digits: int) -> RunLog:
    """To so many digits behind the point; of rows of one time then, the first stays."""
    time, rows = np.unique(np.round(log.time, digits), return_index=True)
    return replace(taken(log, rows), time=time)


def by_clock(log: RunLog, rate: float) -> RunLog:
    """By a clock that runs at another rate."""
    return replace(log, time=rate * log.time)


def without_velocities(log: RunLog) -> RunLog:
    return replace(log, velocity=None)


def with_velocities(log: RunLog, late: float = 0.0, scale: float = 1.0) -> RunLog:
    """Made from the poses; so late (s), and so many times too large."""
    made = fitted_velocities(log.time, log.pose)
    then = np.column_stack([np.interp(log.time - late, log.time, column) for column in made.T])
    return replace(log, velocity=scale * then)


def with_noise(log: RunLog, share: float) -> RunLog:
    """On each component of each wrench, so large a share of its root mean square."""
    random = np.random.default_rng(0)
    arms = {}
    for name, arm in sorted(log.arms.items()):
        size = np.sqrt(np.nanmean(arm.wrench**2, axis=0))
        noise = random.standard_normal(arm.wrench.shape)
        arms[name] = ArmLog(arm.contact, arm.wrench + share * size * noise)
    return replace(log, arms={name: arms[name] for name in log.arms})


def by_columns(log: RunLog, change: Callable[[Array], Array]) -> RunLog:
    """The same done to everything, rows along the first axis."""
    velocity = None if log.velocity is None else change(log.velocity)
    arms = {name: ArmLog(change(arm.contact), change(arm.wrench)) for name, arm in log.arms.items()}
    return replace(log, time=change(log.time), pose=change(log.pose), velocity=velocity, arms=arms)


AS_IT_IS = Variant("as it is", unchanged)

VARIANTS = (
    Variant("half the rows", partial(every, size=2)),
    Variant("a third of the rows", partial(every, size=3)),
    Variant("at 100 Hz", partial(resampled, rate=100.0)),
    Variant("at 50 Hz", partial(resampled, rate=50.0)),
    Variant("means of two", partial(averaged, size=2)),
    Variant("means of four", partial(averaged, size=4)),
    Variant("first 60 %", partial(first_part, share=0.6)),
    Variant("last 60 %", partial(last_part, share=0.6)),
    Variant("guess of a third", unchanged, guess=1 / 3),
    Variant("guess of three times", unchanged, guess=3.0),
    Variant("x in mm", partial(printed_places, step=0.001)),
    Variant("x in 5 mm", partial(printed_places, step=0.005)),
    Variant("t in ms", partial(printed_times, digits=3)),
    Variant("clock 8 ppm fast", partial(by_clock, rate=FAST_CLOCK)),
    Variant("velocities left out", without_velocities, needs=frozenset({"velocity"})),
    Variant("velocities fitted", with_velocities),
    Variant("velocities 50 ms late", partial(with_velocities, late=LATE)),
    Variant("velocities 3 % large", partial(with_velocities, scale=STRETCHED)),
    Variant("5 % of noise", partial(with_noise, share=NOISE_SHARE), needs=frozenset({"force"})),
)
