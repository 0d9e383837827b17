"""Margins from the estimate's covariance: limits of the cart that hold with a stated probability, as cones.

A side of a limit is `g(F, theta) = a(theta) F - b(theta) <= 0`, with theta the model's parameters. For theta ~
N(mean, P) and P = L Lᵀ, g is normal to first order, with the standard deviation `‖D F - d‖`: D and d are the slopes of
a and b along the columns of L. So (chance constraint, exact where a and b are affine in theta)

    P(g <= 0) >= p    where    b - a F >= q ‖D F - d‖,    q the p-quantile of N(0, 1).

The k sides that depend on theta hold together with the `confidence` c for p = 1 - (1 - c) / k, whatever their
correlation (Bonferroni). What is asked of the cart, and the arms' own limits, are free of theta and stay as they are.
Rows are affine in the floor's reaction, whose slopes are analytic (`FloorReaction.by_parameters`): what a limit's own
rows give for these, less what they give for none, are the slopes of the rows. So a limit states nothing but its rows,
and neither a step nor how wide the covariance is matters to them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from statistics import NormalDist
from typing import Literal

import numpy as np

from cartgrasp.checks import number
from cartgrasp.errors import UsageError
from cartgrasp.frames import Array

from . import CartLimit, CartRows, Pushed, RowCone, cart_rows

RANK = 1e-12  # of the largest eigenvalue of the correlation: what counts as uncertain
NO_SLOPE = 1e-9  # N: a standard deviation that is rounding
NUMBERS, AXES = ("of_sum", "of_arm", "low", "high"), (1, 2, 1, 1)
"""Numbers of `CartRows`, and where their rows stand behind a leading axis."""

Side = tuple[int, Literal["low", "high"]]


@dataclass(frozen=True)
class RobustLimits:
    """Limits of the cart, and with which probability they hold together; None: for the cart as estimated."""

    limits: tuple[CartLimit, ...]
    confidence: float | None = None

    def __post_init__(self) -> None:
        if self.confidence is not None and not 0.5 <= number("confidence", self.confidence) < 1:
            raise UsageError(f"confidence: {self.confidence} is not a probability from 0.5 to below 1")

    def rows(self, pushed: Pushed, covariance: Array | None = None) -> CartRows:
        """Cones in the place of sides that depend on the cart's parameters, of which `covariance` (p, p) is."""
        nominal = cart_rows(self.limits, pushed)
        if self.confidence is None or covariance is None:
            return nominal
        slopes = _slopes(self.limits, pushed, root(covariance).T)
        uncertain = [side for side in _sides(nominal) if slopes.depends(side)]
        if not uncertain:
            return nominal
        quantile = NormalDist().inv_cdf(1.0 - (1.0 - self.confidence) / len(uncertain))
        stated = (quantile, f" ({100 * self.confidence:g} %)")
        cones = [_cone(nominal, slopes, side, stated) for side in uncertain]
        return CartRows.stacked([_without(nominal, uncertain), *cones], len(nominal.of_arm))


def root(covariance: Array) -> Array:
    """L (p, r) with L Lᵀ = covariance (p, p), r its rank; units may differ from parameter to parameter."""
    deviations = np.sqrt(np.maximum(np.diagonal(covariance), 0.0))
    units = np.where(deviations > 0, deviations, 1.0)
    values, vectors = np.linalg.eigh(covariance / np.outer(units, units))
    kept = values > RANK * max(1.0, float(values.max(initial=0.0)))
    return np.asarray(units[:, None] * vectors[:, kept] * np.sqrt(values[kept]))


@dataclass(frozen=True, eq=False)
class _Slopes:
    """Derivatives of rows along r directions of the parameters: of_sum (r, k, 6), of_arm (r, n, k, 6), low and high
    (r, k), 0 for a limit that isn't there."""

    of_sum: Array
    of_arm: Array
    low: Array
    high: Array

    @cached_property
    def _of_rows(self) -> np.ndarray:
        """Which rows (k,) have a slope; NaN is none of nought."""
        of_sum = np.abs(self.of_sum).max(axis=(0, 2), initial=0.0)
        of_arm = np.abs(self.of_arm).max(axis=(0, 1, 3), initial=0.0)
        return np.asarray(~((of_sum <= NO_SLOPE) & (of_arm <= NO_SLOPE)))

    def depends(self, side: Side) -> bool:
        i, which = side
        return bool(self._of_rows[i] or not np.abs(getattr(self, which)[:, i]).max(initial=0.0) <= NO_SLOPE)


def _slopes(limits: Sequence[CartLimit], pushed: Pushed, directions: Array) -> _Slopes:
    """Along directions (r, p): what rows are for a slope of the floor's numbers, less what they are for none."""
    ways = np.vstack([np.zeros(directions.shape[1]), directions])
    many, each = pushed.along(ways), None
    found = []
    for limit in limits:
        if limit.takes_many:
            found.append(_spread(limit.rows(many), len(ways)))
        else:
            each = each or [pushed.along(way) for way in ways]
            rows = [limit.rows(one) for one in each]
            found.append(tuple(np.array([getattr(one, name) for one in rows]) for name in NUMBERS))
    parts = zip(*found, strict=True)
    whole = (np.concatenate(part, axis=axis) for part, axis in zip(parts, AXES, strict=True))
    return _Slopes(*map(_less_the_first, whole))


def _spread(rows: CartRows, count: int) -> tuple[Array, ...]:
    """Numbers of rows that were asked for many slopes at once, all with the leading axis."""
    n_axes = (3, 4, 2, 2)
    numbers = (getattr(rows, name) for name in NUMBERS)
    return tuple(
        one if one.ndim == n else np.broadcast_to(one, (count, *one.shape))
        for one, n in zip(numbers, n_axes, strict=True)
    )


def _less_the_first(values: Array) -> Array:
    """Differences (r, ...) from the first of (r + 1, ...), 0 where that is a limit that isn't there."""
    first = np.isfinite(values[0])
    return np.asarray(np.subtract(values[1:], values[0], out=np.zeros(values[1:].shape), where=first))


def _sides(rows: CartRows) -> list[Side]:
    low: list[Side] = [(i, "low") for i in np.flatnonzero(np.isfinite(rows.low)).tolist()]
    high: list[Side] = [(i, "high") for i in np.flatnonzero(np.isfinite(rows.high)).tolist()]
    return low + high


def _without(rows: CartRows, sides: Sequence[Side]) -> CartRows:
    """Rows but for some of their sides."""
    low, high = rows.low.copy(), rows.high.copy()
    for i, which in sides:
        (low if which == "low" else high)[i] = -np.inf if which == "low" else np.inf
    left = np.flatnonzero(np.isfinite(low) | np.isfinite(high))
    low_names, high_names = (tuple(names[i] for i in left) for names in (rows.low_names, rows.high_names))
    return CartRows(rows.of_sum[left], rows.of_arm[:, left], low[left], high[left], low_names, high_names)


def _cone(rows: CartRows, slopes: _Slopes, side: Side, stated: tuple[float, str]) -> CartRows:
    """`(b - a F, q (D F - d))` for a side; `stated` are q and what is added to the side's name."""
    (i, which), (quantile, suffix) = side, stated
    sign = 1.0 if which == "high" else -1.0
    name = (rows.high_names if which == "high" else rows.low_names)[i] + suffix
    of_sum = np.concatenate([-sign * rows.of_sum[None, i], quantile * slopes.of_sum[:, i]])
    of_arm = np.concatenate([-sign * rows.of_arm[None, :, i], quantile * slopes.of_arm[:, :, i]]).swapaxes(0, 1)
    offset = np.concatenate([sign * getattr(rows, which)[None, i], -quantile * getattr(slopes, which)[:, i]])
    free = np.full(len(offset), np.inf)
    names = (name, *[""] * (len(offset) - 1))
    return CartRows(of_sum, of_arm, -free, free, names, names, (RowCone(name, 0, offset),))
