"""What recorders and encoders put in: rows on straight lines between others, values in coarse steps, rows too slow,
numbers that stand for no reading.

None of them is a measurement, and all hide the noise: a row in between has none, and where the step is larger than the
noise, neighbours are mostly equal.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from cartgrasp.errors import printable
from cartgrasp.frames import Array, unwrapped
from cartgrasp.logs import ArmLog, RunLog
from cartgrasp.model import CartModel

from ..log_noise.log_noise import MIN_POSITION_NOISE, MIN_VELOCITY_NOISE, noise_floor
from ..log_noise.resolution import ROUNDING_STD
from ..log_noise.sentinel_values import sentinels
from .repeated_rows import local_change, repeats_fast
from .stuck_wrenches import clipped_arm, frozen_arm, without_frozen
from .suspicion import Suspicion

STRAIGHT_BEND_RATIO = 1e-3
"""Share of the usual bend below which a row is straight: a bend of white noise is as small in a thousandth of the
rows."""
MIN_RECORDER_SAMPLES = 20
"""Rows, and gaps between values."""
MIN_STEP_RESULTANT = 0.7
"""Resultant length of the gaps' remainders from which they are whole numbers of steps: 1 where they are, less than a
half (in 99 of 100) where 20 of them are anything. Digits that are cut off leave remainders of an eighth of a step."""
MAX_VALUE_GAP_STEPS = 20.5
"""Steps: of wider gaps the remainder depends on the step's last digit."""
MAX_ROW_INTERVAL = 0.2
"""s between rows: carts are started and stopped within half a second, which three samples at least show."""


def blank_columns(log: RunLog) -> dict[str, list[str]]:
    """Names of the columns without a value, by arm, of arms that have others: none of their rows is whole."""
    found = {}
    for arm in log.arms:
        own = [i for i, name in enumerate(log.columns) if name.startswith(f"{arm}.")]
        blank = [log.columns[i] for i in own if not np.isfinite(log.table[:, i]).any()]
        if 0 < len(blank) < len(own):
            found[arm] = blank
    return found


def unreadable_columns(log: RunLog) -> tuple[Suspicion, ...]:
    """Columns without a value, and those in which numbers stand for no reading."""
    told = []
    for arm, blank in blank_columns(log).items():
        words = (
            f"{printable(', '.join(blank))}: blank in every row, so nobody knows what {printable(arm)} gave, and no "
            "row teaches anything: write 0 where that was not there, or leave the whole arm out if it held nothing"
        )
        told.append(Suspicion("holes", arm, 0.99, None, words))
    for name, column in zip(log.columns, log.table.T, strict=True):
        rows = np.flatnonzero(sentinels(column))
        if len(rows):
            value = float(column[rows[0]])
            words = (
                f"{name}: is {value:.10g} in {len(rows)} of {len(column)} rows, first at t = {log.time[rows[0]]:g} s, "
                "and never near it elsewhere: it stands for no reading, so they are left out; leave such cells blank"
            )
            told.append(Suspicion("jumps", name, 0.99, value, words, put_right=True))
    return tuple(told)


def repeated(log: RunLog, fresh: RunLog) -> tuple[Suspicion, ...]:
    """Suspicions of poses and velocities that repeat the rows before, as often as a recorder writes them again, and of
    wrenches that froze, or are at the end of their range. The fresh log lacks such rows."""
    told = []
    pairs = {"pose": (log.pose, fresh.pose)}
    if log.velocity is not None and fresh.velocity is not None:
        pairs["velocity"] = log.velocity, fresh.velocity
    for where, (before, after) in pairs.items():
        there = np.asarray(np.isfinite(before).all(axis=1))
        again = ~np.asarray(np.isfinite(after[there]).all(axis=1))
        if repeats_fast(again, local_change(before[there], log.time[there])):
            words = (
                f"{where}: {int(again.sum())} of {len(again)} rows repeat the one before while the cart moves, as a "
                "recorder writes where nothing new has come; a diagnosis leaves them out: leave such cells blank"
            )
            factor = len(again) / max(len(again) - int(again.sum()), 1)
            told.append(Suspicion("repeated", where, 0.99, factor, words, put_right=True))
    for name, arm in log.arms.items():
        told += frozen_arm(name, arm, log.time)
        told += clipped_arm(name, without_frozen(arm), log.time)
    return tuple(told)


def interpolated(log: RunLog) -> tuple[RunLog, tuple[Suspicion, ...]]:
    """The log with what lies on straight lines between knots as missing samples, and what was found."""
    told, found = list[Suspicion](), dict[str, Array]()
    sensors = {"pose": log.pose} | ({} if log.velocity is None else {"velocity": log.velocity})
    sensors |= {name: arm.wrench for name, arm in log.arms.items()}
    for where, rows in sensors.items():
        straight = straight_rows(rows, log.time)
        count, there = int(straight.sum()), int(np.isfinite(rows).all(axis=1).sum())
        found[where] = np.where(straight[:, None], np.nan, rows) if count else rows
        if count:
            words = (
                f"{printable(where)}: {count} of {there} rows lie on straight lines between others, so they were "
                "interpolated, not measured; a diagnosis leaves them out: record at the sensor's own rate"
            )
            told.append(Suspicion("repeated", where, 0.99, there / (there - count), words, put_right=True))
    if not told:
        return log, ()
    arms = {name: ArmLog(arm.contact, found[name]) for name, arm in log.arms.items()}
    return replace(log, pose=found["pose"], velocity=found.get("velocity"), arms=arms), tuple(told)


def straight_rows(rows: Array, time: Array) -> np.ndarray:
    """Which rows (n,) of (n, k) lie on the straight line between knots that are no neighbours of one another. What
    moves evenly for long is no such row: knots come one by one, and at least one for every ten rows."""
    there = np.flatnonzero(np.isfinite(rows).all(axis=1))
    found = np.zeros(len(rows), dtype=bool)
    if len(there) < MIN_RECORDER_SAMPLES:
        return found
    slope = np.diff(rows[there], axis=0) / np.diff(time[there])[:, None]
    bend = np.abs(np.diff(slope, axis=0))
    usual = np.sqrt((bend**2).mean(axis=0))
    live = usual > 0
    if not live.any():
        return found
    is_bent = (bend[:, live] > STRAIGHT_BEND_RATIO * usual[live]).any(axis=1)
    moves = (np.abs(slope[1:]) > 0).any(axis=1) & (np.abs(slope[:-1]) > 0).any(axis=1)
    alone = is_bent[1:-1] & ~is_bent[:-2] & ~is_bent[2:]
    straight = ~is_bent & moves
    is_knotted = 2 * alone.sum() > is_bent[1:-1].sum() and 10 * is_bent.sum() > straight.sum()
    if is_knotted and 3 * straight.sum() > len(there):
        found[there[1:-1][straight]] = True
    return found


def frozen(log: RunLog, cart: CartModel) -> tuple[Suspicion, ...]:
    """A heading that nobody measured, of a cart that may turn."""
    pose = log.pose[np.isfinite(log.pose).all(axis=1)]
    if cart.constraints.no_rotation or len(pose) < 2 or np.ptp(pose[:, 2]) > 0.0 or not np.ptp(pose, axis=0).any():
        return ()
    words = (
        "theta never changes: nobody measured it; if the cart can't turn, write `no_rotation: {}` under constraints, "
        "else record it"
    )
    return (Suspicion("repeated", "heading", 0.99, None, words),)


def quantised(log: RunLog) -> tuple[Suspicion, ...]:
    """Poses and velocities in coarse steps."""
    groups = [("pose", {"x": log.pose[:, 0], "y": log.pose[:, 1]}, "m", MIN_POSITION_NOISE)]
    groups.append(("heading", {"theta": log.pose[:, 2]}, "rad", MIN_POSITION_NOISE))
    if log.velocity is not None:
        groups.append(("velocity", {"vx": log.velocity[:, 0], "vy": log.velocity[:, 1]}, "m/s", MIN_VELOCITY_NOISE))
        groups.append(("yaw_rate", {"omega": log.velocity[:, 2]}, "rad/s", MIN_VELOCITY_NOISE))
    told = []
    for where, columns, unit, least in groups:
        found = {name: coarse_step(column, least, name == "theta") for name, column in columns.items()}
        steps = {name: step for name, step in found.items() if step is not None}
        if steps:
            step = max(steps.values())
            words = (
                f"{' and '.join(steps)} in steps of {step:.3g} {unit}, which are most of their noise (standard "
                f"deviation {step * ROUNDING_STD:.2g} {unit}); record with finer steps if you can"
            )
            told.append(Suspicion("quantised", where, 0.99, step, words))
    return tuple(told)


def coarse_step(column: Array, least: float, turns: bool = False) -> float | None:
    """The step of a column (n,) where rounding is most of its noise, and more than the `least` that noise may be. Of
    angles, which were rounded as they are written: a whole turn is no number of steps."""
    step, noise = step_of(column), noise_floor(unwrapped(column) if turns else column)
    if step is None or step * ROUNDING_STD <= least or (step * ROUNDING_STD) ** 2 < 0.5 * noise**2:
        return None
    return step


def step_of(column: Array) -> float | None:
    """The grid's step of a column (n,), NaN where missing; None where its values lie on none."""
    values = np.unique(column[np.isfinite(column)])
    gaps = np.diff(values)
    gaps = gaps[gaps > 1e-9 * np.abs(values).max(initial=0.0)]
    if len(gaps) < MIN_RECORDER_SAMPLES:
        return None
    for first in np.quantile(gaps, [0.0, 0.02, 0.1, 0.5]):
        step = _refined(gaps, float(first))
        near = gaps[gaps < MAX_VALUE_GAP_STEPS * step]
        if (
            len(near) >= max(MIN_RECORDER_SAMPLES, 0.1 * len(gaps))
            and np.abs(np.exp(2j * np.pi * near / step).mean()) > MIN_STEP_RESULTANT
        ):
            return step
    return None


def _refined(gaps: Array, step: float) -> float:
    """Least squares of gaps on whole numbers of steps, near ones first."""
    for reach in (1.5, 3.5, 6.5, 10.5, MAX_VALUE_GAP_STEPS):
        near = gaps[gaps < reach * step]
        count = np.maximum(np.round(near / step), 1.0)
        step = float((near @ count) / (count @ count)) if len(near) else step
    return step


def slow(log: RunLog) -> tuple[Suspicion, ...]:
    """Rows that come too seldom, or times in milliseconds."""
    step = float(np.median(np.diff(log.time))) if len(log) > 1 else 0.0
    if step <= MAX_ROW_INTERVAL:
        return ()
    words = (
        f"rows come every {step:.3g} s: starts and stops fall between them; record at {1 / MAX_ROW_INTERVAL:.0f} Hz "
        "or more, or, if t is in milliseconds, multiply it by 0.001"
    )
    return (Suspicion("holes", "time", 0.99, step, words),)
