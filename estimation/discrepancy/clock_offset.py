"""By how much a log's wrenches are later than its motion, before any model is fitted.

Wrenches are regressed on what any cart's would be made of: the inertial parameters' regressors, and of each direction
the speed, its sign and a constant. They fit best when they are taken as late as they are.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cartgrasp.frames import Array

from ..batch.wrench_regression import WrenchRegression

LONGEST = 0.25
"""s, either way."""
PARTS = 4
"""Of a log, whose answers say how sure it is."""
FEWEST = 50
"""Rows of a part."""
SAMPLED, FORM = 0.3, 0.005
"""Of a row, and s: standard deviations of what a log does not tell."""
ROLLING = 0.02
"""m/s or rad/s: below, no sign."""


@dataclass(frozen=True)
class ClockOffset:
    """By how much later wrenches are than the motion (s), and its standard deviation: by how much parts of the log
    disagree, that nobody knows whether a sample holds until the next one, and that friction has many forms."""

    value: float
    std: float


def clock_offset(regression: WrenchRegression) -> ClockOffset | None:
    """None where a log is too short, or fits best at one of the ends."""
    motion, cart = regression.motion, regression.cart
    step = float(np.median(np.diff(motion.time)))
    reach = max(1, round(LONGEST / step))
    nu = motion.velocity
    inertial = cart.regressor(nu, motion.acceleration)
    n, f = nu.shape
    sign = np.where(np.abs(nu) > ROLLING, np.sign(nu), 0.0)
    own = np.stack([nu, sign, np.ones((n, f))], axis=2)
    columns = np.concatenate([inertial, (own[:, :, None, :] * np.eye(f)[:, :, None]).reshape(n, f, -1)], axis=2)
    wrench = np.where(np.append(regression.usable, False)[:, None], regression.reduced(cart), np.nan)
    late = np.arange(-reach, reach + 1)
    rows = np.arange(reach, n - reach)
    shifted = np.stack([wrench[rows + k] for k in late], axis=2)
    whole = np.isfinite(shifted).all(axis=(1, 2))
    rows, shifted = rows[whole], shifted[whole]
    if len(rows) < PARTS * FEWEST:
        return None
    size = np.maximum(shifted.std(axis=(0, 2)), 1e-9)[:, None]
    columns, shifted = columns[rows] / size, shifted / size
    best = _best(columns, shifted, late)
    if abs(best) >= reach:
        return None
    pairs = zip(np.array_split(columns, PARTS), np.array_split(shifted, PARTS), strict=True)
    spread = float(np.std([_best(*each, late) for each in pairs], ddof=1)) / PARTS**0.5
    row = step / regression.size
    return ClockOffset(best * step, float(np.hypot(np.hypot(spread * step, SAMPLED * row), FORM)))


def _best(columns: Array, shifted: Array, late: np.ndarray) -> float:
    """Rows by which wrenches (m, f, k), taken so many rows late (k,), fit columns (m, f, p) best."""
    flat, wrench = columns.reshape(-1, columns.shape[2]), shifted.reshape(-1, len(late))
    axes = np.linalg.qr(flat)[0]
    left = (wrench**2).sum(axis=0) - ((axes.T @ wrench) ** 2).sum(axis=0)
    best = int(np.argmin(left))
    if not 0 < best < len(late) - 1:
        return float(late[best])
    before, here, after = left[best - 1 : best + 2]
    return float(late[best] + 0.5 * (before - after) / max(before - 2 * here + after, 1e-12))
