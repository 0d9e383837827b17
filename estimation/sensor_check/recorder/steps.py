"""Sensors with steps: encoders, ranges in whole centimetres, columns printed with few digits.

Values that lie on a grid differ by whole numbers of its steps. Where the step is larger than the noise, differences of
neighbours are mostly 0 and the noise is read as 0; it is that of rounding, step / √12.
"""

from __future__ import annotations

import math

import numpy as np

from cartgrasp.errors import printable
from cartgrasp.frames import Array
from cartgrasp.logs import RunLog

from ...log_noise import LEAST_FORCE, LEAST_MOMENT, LEAST_POSITION, LEAST_VELOCITY, noise_floor
from ..suspicion import Suspicion, listing

FEWEST = 20
"""Gaps between values."""
WHOLE = 0.7
"""Resultant length of the gaps' remainders from which they are whole numbers of steps: 1 where they are, less than a
half (in 99 of 100) where 20 of them are anything. Digits that are cut off leave remainders of an eighth of a step."""
NEAR = 20.5
"""Steps: of wider gaps the remainder depends on the step's last digit."""
ROUNDING = 1 / math.sqrt(12)
"""Standard deviation of rounding, in steps."""


def step_of(column: Array) -> float | None:
    """The grid's step of a column (n,), NaN where missing; None where its values lie on none."""
    values = np.unique(column[np.isfinite(column)])
    if len(values) <= FEWEST:
        return None
    gaps = np.diff(values)
    gaps = gaps[gaps > 1e-9 * np.abs(values).max()]
    if len(gaps) < FEWEST:
        return None
    for first in np.quantile(gaps, [0.0, 0.02, 0.1, 0.5]):
        step = _refined(gaps, float(first))
        near = gaps[gaps < NEAR * step]
        if len(near) >= max(FEWEST, 0.1 * len(gaps)) and _resultant(near, step) > WHOLE:
            return step
    return None


def _refined(gaps: Array, step: float) -> float:
    """Least squares of gaps on whole numbers of steps, near ones first."""
    for reach in (1.5, 3.5, 6.5, 10.5, NEAR):
        near = gaps[gaps < reach * step]
        count = np.maximum(np.round(near / step), 1.0)
        step = float((near @ count) / (count @ count)) if len(near) else step
    return step


def _resultant(gaps: Array, step: float) -> float:
    return float(np.abs(np.exp(2j * np.pi * gaps / step).mean()))


def noise_with_steps(column: Array) -> float:
    """Standard deviation of the noise of a column (n,): what third differences tell, and what rounding adds where they
    tell less than it."""
    step, told = step_of(column), noise_floor(column)
    return told if step is None else max(told, step * ROUNDING)


def coarse_step(column: Array, least: float) -> float | None:
    """The step of a column (n,) where rounding is most of its noise, and more than the `least` that noise may be."""
    step = step_of(column)
    if step is None or step * ROUNDING <= least or (step * ROUNDING) ** 2 < 0.5 * noise_floor(column) ** 2:
        return None
    return step


def quantised(log: RunLog) -> tuple[Suspicion, ...]:
    """One for each sensor of which a column has coarse steps."""
    groups = [("pose", "pose", [("x", log.pose[:, 0], "m"), ("y", log.pose[:, 1], "m")], LEAST_POSITION)]
    heading = log.pose[:, 2].copy()
    known = np.isfinite(heading)
    heading[known] = np.unwrap(heading[known])
    groups.append(("heading", "heading", [("theta", heading, "rad")], LEAST_POSITION))
    if log.velocity is not None:
        pairs = zip(("vx", "vy", "omega"), log.velocity.T, ("m/s", "m/s", "rad/s"), strict=True)
        groups.append(("velocity", "velocity", list(pairs), LEAST_VELOCITY))
    for name, arm in log.arms.items():
        forces = [(f"{name}.{c}", arm.wrench[:, i], "N") for i, c in enumerate(("fx", "fy", "fz"))]
        moments = [(f"{name}.{c}", arm.wrench[:, i], "N·m") for i, c in enumerate(("tx", "ty", "tz"), 3)]
        groups += [(name, "force", forces, LEAST_FORCE), (name, "moment", moments, LEAST_MOMENT)]
    told = (_told(where, what, columns, least) for where, what, columns, least in groups)
    return tuple(one for one in told if one is not None)


def _told(where: str, what: str, columns: list[tuple[str, Array, str]], least: float) -> Suspicion | None:
    found = [(name, coarse_step(column, least), unit) for name, column, unit in columns]
    coarse = [(name, step, unit) for name, step, unit in found if step is not None]
    if not coarse:
        return None
    steps = listing([f"{printable(name)} {step:.3g} {unit}" for name, step, unit in coarse])
    largest, unit = max((step, unit) for _, step, unit in coarse)
    words = (
        f"{what} comes in steps ({steps}), which are most of its noise: take a standard deviation of "
        f"{largest * ROUNDING:.2g} {unit} (step / √12) for it rather than what neighbouring rows tell, or record "
        "with finer steps"
    )
    return Suspicion("quantised", where, 0.99, largest, words)
