"""What a log can show at all: rates, gaps, noise, how much it moves; and a refusal where it can't be read."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from cartgrasp.errors import DataError
from cartgrasp.frames import Array
from cartgrasp.logs import RunLog, coasts
from cartgrasp.model import CartModel

from ..log_noise.log_noise import noise_of_log
from ..log_noise.sample_step import usual_step
from ..noise import FilterNoise
from ..sensor_check import Suspicion
from ..sensor_check.repeated_rows import without_repeats
from ..sensor_check.sizes import check_jumps
from ..weak_form.balances import Balances
from ..weak_form.integrals import SPLINE_SUPPORT
from ..weak_form.motion import Motion
from .clock_offset import ClockOffset

MIN_LOG_ROWS = 40
"""A log of 40 s at 1 Hz: some times the parameters of a cart."""
MIN_LOG_DURATION = 4.0
"""Shortest log (s)."""
MIN_LOG_BALANCE_ROWS = 10
"""Fewest rows of balances in weak form, which hold all that is needed."""
HEADING_SECTORS, MIN_SECTOR_INTERVAL = 8, 1.0
"""Parts of the circle; time (s) for which a cart heads into one at least."""
MIN_ROLLING_SPEED, MIN_TURNING_RATE = 0.015, 0.015
"""Speed (m/s) and yaw rate (rad/s): below both a cart may stand still, and friction takes whatever value holds it."""


@dataclass(frozen=True)
class LogCheck:
    """Rows, duration (s), rate (Hz), longest gap (s), rows with every wrench, poses that repeat the last one; noise
    floors; by how much wrenches are later than the motion; motion: distance (m), turning (rad), reversals, the fastest
    speed (m/s), the share of the time that it moves; of that time, speeds (m/s) that nine, five and one tenth exceed,
    how many eighths of the circle it heads into, and accelerations along the free directions (m/s², rad/s²) that a
    twentieth exceeds; what its sensors seem to do.
    """

    name: str
    rows: int
    duration: float
    rate: float
    longest_gap: float
    rows_with_wrenches: int
    stale_poses: int
    noise: FilterNoise
    clock_offset: ClockOffset | None
    distance: float
    turned: float
    reversals: int
    fastest: float
    moving: float
    speeds: tuple[float, ...]
    headings: int
    accelerations: tuple[float, ...]
    suspicions: tuple[Suspicion, ...] = ()


def is_long_enough(log: RunLog) -> bool:
    return len(log) >= MIN_LOG_ROWS and log.duration >= MIN_LOG_DURATION


def check_rows(log: RunLog) -> None:
    """Refuses a log that is too short, or misses what is needed."""
    if not is_long_enough(log):
        raise DataError(
            f"{log.name}: {len(log)} rows over {log.duration:.2f} s are too few to compare with a simulation; "
            f"record at least {MIN_LOG_ROWS} rows and {MIN_LOG_DURATION:g} s"
        )
    seen = np.isfinite(log.pose).all(axis=1)
    if seen.sum() < MIN_LOG_ROWS:
        raise DataError(
            f"{log.name}: only {int(seen.sum())} rows have a whole pose (x, y, theta); {MIN_LOG_ROWS} are needed"
        )
    whole = {f"the {what} is whole": np.isfinite(values).all(axis=1) for what, values in _of_arms(log).items()}
    if log.arms:
        whole["all arms together have wrenches and contact points"] = _with_wrenches(log)
    for what, rows in whole.items():
        count, step = int(rows.sum()), usual_step(log.time[rows])
        if count < MIN_LOG_ROWS or count * step < MIN_LOG_DURATION:
            raise DataError(
                f"{log.name}: {what} in {count} rows only, {count * step:.1f} s; record at least "
                f"{MIN_LOG_DURATION:g} s of them"
            )


def _of_arms(log: RunLog) -> dict[str, Array]:
    """What is recorded of arms, (n, k) each, by its name."""
    found = dict[str, Array]()
    for name, arm in log.arms.items():
        found |= {f"wrench of arm {name}": arm.wrench, f"contact point of arm {name}": arm.contact}
    return found


def _with_wrenches(log: RunLog) -> np.ndarray:
    """Rows (n,) in which every arm's wrench and contact are whole; none without arms."""
    if not log.arms:
        return np.zeros(len(log), dtype=bool)
    return np.asarray(np.isfinite(np.hstack(list(_of_arms(log).values()))).all(axis=1))


def checked(log: RunLog, cart: CartModel, balances: Balances) -> LogCheck:
    """Check of one log. How late its wrenches are is told by a model that is fitted (`with_clock_offsets`). Raises
    DataError for poses that jump, too few rows that hold all, and wrenches that never change although the cart
    moves."""
    motion, moves, steps = balances.motion, moving(balances), np.diff(log.time)
    check_jumps(balances.log, float(motion.noise.pose[0]))
    _check_together(log, balances, bool(moves.any()))
    noise, fresh, forward = noise_of_log(balances.log, cart), without_repeats(log), motion.velocity[:, 0]
    of_eighths = np.round(motion.pose[moves, 2] / (2 * np.pi / HEADING_SECTORS)).astype(int) % HEADING_SECTORS
    return LogCheck(
        name=log.name,
        rows=len(log),
        duration=log.duration,
        rate=1 / usual_step(log.time),
        longest_gap=float(steps.max()),
        rows_with_wrenches=int(_with_wrenches(log).sum()),
        stale_poses=int((np.isnan(fresh.pose) & ~np.isnan(log.pose)).any(axis=1).sum()),
        noise=replace(
            noise,
            position=max(noise.position, float(motion.noise.pose[0])),
            heading=max(noise.heading, float(motion.noise.pose[2])),
        ),
        clock_offset=None,
        distance=float(motion.speed[moves].sum() * motion.step),
        turned=float(_turning(motion)[moves].sum() * motion.step),
        reversals=int((np.diff(np.sign(forward[np.abs(forward) > MIN_ROLLING_SPEED])) != 0).sum()),
        fastest=float(motion.speed.max()),
        moving=float(moves.mean()),
        speeds=_percentiles(motion.speed[moves], (10.0, 50.0, 90.0)),
        headings=int((np.bincount(of_eighths, minlength=HEADING_SECTORS) * motion.step > MIN_SECTOR_INTERVAL).sum()),
        accelerations=tuple(_percentiles(each, (95.0,))[0] for each in np.abs(motion.acceleration[moves].T)),
    )


def _check_together(log: RunLog, balances: Balances, moves: bool) -> None:
    """Refuses a log whose poses and wrenches hardly ever come together, and one without a sensor."""
    if len(balances.used) < MIN_LOG_BALANCE_ROWS:
        raise DataError(
            f"{log.name}: poses and wrenches come together for {len(balances.used) * balances.row_step:.1f} s only; "
            f"record at least {max(MIN_LOG_DURATION, MIN_LOG_BALANCE_ROWS * balances.row_step):.1f} s without gaps"
        )
    wrenches = [arm.wrench[np.isfinite(arm.wrench).all(axis=1)] for arm in log.arms.values()]
    if moves and not coasts(log) and not any((one != one[:1]).any() for one in wrenches):
        raise DataError(
            f"{log.name}: the cart moves and no wrench ever changes, as if no sensor were there; look at its "
            "connection, or leave the wrenches' columns out if nobody pushed"
        )


def with_clock_offsets(checks: Sequence[LogCheck], offsets: Sequence[ClockOffset | None]) -> tuple[LogCheck, ...]:
    return tuple(replace(check, clock_offset=offset) for check, offset in zip(checks, offsets, strict=True))


def with_suspicions(check: LogCheck, suspicions: Sequence[Suspicion]) -> LogCheck:
    """The check with suspicions, those first that stop a command."""
    return replace(check, suspicions=tuple(sorted(suspicions, key=lambda one: not one.is_refused)))


def _percentiles(values: Array, shares: tuple[float, ...]) -> tuple[float, ...]:
    """Percentiles of values; 0 where there are none."""
    return tuple(float(one) for one in np.percentile(values if len(values) else np.zeros(1), shares))


def moves(balances: Balances) -> bool:
    """Whether the cart moves for at least as long as the shortest test function lasts."""
    fast = (balances.turning_speed > balances.still_speed) & balances.motion.seen
    size = SPLINE_SUPPORT * balances.every(0.0).per_row
    return bool((np.convolve(fast, np.ones(size), "valid") > size - 0.5).any())


def moving(balances: Balances) -> np.ndarray:
    """Whether (n,), at each time of the motion, the cart was seen and surely moves."""
    motion = balances.motion
    return np.asarray(((motion.speed > MIN_ROLLING_SPEED) | (_turning(motion) > MIN_TURNING_RATE)) & motion.seen)


def _turning(motion: Motion) -> Array:
    """Absolute yaw rate of a motion (n,), rad/s; zero on a rail."""
    return np.abs(motion.velocity[:, -1]) if motion.velocity.shape[1] > 1 else np.zeros(len(motion.time))
