"""What each arm gives the cart: its recorded wrenches, corrected and averaged, as planar wrenches in {b}."""

from __future__ import annotations

import numpy as np

from cartgrasp.contacts import grasp_map_planar
from cartgrasp.frames import Array
from cartgrasp.model import CartModel

from ..batch.wrench_regression import WrenchRegression

SMOOTHED = 0.1
"""s, on each side: over which wrenches are averaged before they say what force the wheels take."""


def arm_wrenches(regression: WrenchRegression, cart: CartModel, smoothed: float = SMOOTHED) -> dict[str, Array]:
    """Of each arm (n, 3), averaged over `smoothed` (s) on each side of a row."""
    log = regression.rows
    reach = max(1, round(smoothed / float(np.median(np.diff(log.time)))))
    kernel = np.ones(2 * reach + 1)
    count = _averaged(np.ones(len(log)), kernel)
    found = {}
    for name, arm in log.arms.items():
        wrench = cart.corrected_wrench(name, _filled(arm.wrench))[0]
        planar = (grasp_map_planar(_filled(arm.contact)) @ wrench[..., None])[..., 0]
        found[name] = np.column_stack([_averaged(planar[:, i], kernel) / count for i in range(3)])
    return found


def planar_wrench(regression: WrenchRegression, cart: CartModel) -> Array:
    """Of all arms (n, 3)."""
    return np.asarray(sum(arm_wrenches(regression, cart).values()))


def _averaged(column: Array, kernel: Array) -> Array:
    """Sums over as many rows as the kernel has, the ends' over those that are there."""
    reach = len(kernel) // 2
    return np.convolve(column, kernel)[reach : reach + len(column)]


def _filled(rows: Array) -> Array:
    """Rows (n, k) with the last known number where one is missing."""
    found = rows.copy()
    for i in range(rows.shape[1]):
        known = np.flatnonzero(np.isfinite(rows[:, i]))
        found[:, i] = (
            rows[known[np.searchsorted(known, np.arange(len(rows)), "right").clip(1) - 1], i] if len(known) else 0.0
        )
    return found
