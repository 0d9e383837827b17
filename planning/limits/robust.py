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
from dataclasses import dataclass, replace
from statistics import NormalDist
from typing import Literal

import numpy as np

from cartgrasp.checks import number
from cartgrasp.errors import UsageError
from cartgrasp.frames import Array

from . import CartLimit, CartRows, Pushed, RowCone, cart_rows

RANK = 1e-12  # of the largest eigenvalue of the correlation: what counts as uncertain
NO_SLOPE = 1e-9  # N: a standard deviation that is rounding

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
        uncertain = [side for side in _sides(nominal) if any(_depends(slope, side) for slope in slopes)]
        if not uncertain:
            return nominal
        quantile = NormalDist().inv_cdf(1.0 - (1.0 - self.confidence) / len(uncertain))
        rows = _without(nominal, uncertain)
        for side in uncertain:
            rows &= _cone(nominal, slopes, side, (quantile, f" ({100 * self.confidence:g} %)"))
        return rows


def root(covariance: Array) -> Array:
    """L (p, r) with L Lᵀ = covariance (p, p), r its rank; units may differ from parameter to parameter."""
    deviations = np.sqrt(np.maximum(np.diagonal(covariance), 0.0))
    units = np.where(deviations > 0, deviations, 1.0)
    values, vectors = np.linalg.eigh(covariance / np.outer(units, units))
    kept = values > RANK * max(1.0, float(values.max(initial=0.0)))
    return np.asarray(units[:, None] * vectors[:, kept] * np.sqrt(values[kept]))


def _slopes(limits: Sequence[CartLimit], pushed: Pushed, columns: Array) -> list[CartRows]:
    """The rows' derivatives along directions (r, p) of the parameters; 0 for a limit that isn't there."""
    none = cart_rows(limits, pushed.along(np.zeros(columns.shape[1])))
    return [_less(cart_rows(limits, pushed.along(column)), none) for column in columns]


def _less(one: CartRows, other: CartRows) -> CartRows:
    def less(name: str) -> Array:
        ours, others = getattr(one, name), getattr(other, name)
        return np.asarray(np.subtract(ours, others, out=np.zeros(ours.shape), where=np.isfinite(others)))

    return replace(one, of_sum=less("of_sum"), of_arm=less("of_arm"), low=less("low"), high=less("high"))


def _sides(rows: CartRows) -> list[Side]:
    low: list[Side] = [(i, "low") for i in np.flatnonzero(np.isfinite(rows.low)).tolist()]
    high: list[Side] = [(i, "high") for i in np.flatnonzero(np.isfinite(rows.high)).tolist()]
    return low + high


def _depends(slope: CartRows, side: Side) -> bool:
    i, which = side
    parts = (slope.of_sum[i], slope.of_arm[:, i], getattr(slope, which)[i])
    return not all(float(np.abs(part).max(initial=0.0)) <= NO_SLOPE for part in parts)  # nor is NaN none


def _without(rows: CartRows, sides: Sequence[Side]) -> CartRows:
    """Rows but for some of their sides."""
    low, high = rows.low.copy(), rows.high.copy()
    for i, which in sides:
        (low if which == "low" else high)[i] = -np.inf if which == "low" else np.inf
    left = np.flatnonzero(np.isfinite(low) | np.isfinite(high))
    low_names, high_names = (tuple(names[i] for i in left) for names in (rows.low_names, rows.high_names))
    return CartRows(rows.of_sum[left], rows.of_arm[:, left], low[left], high[left], low_names, high_names)


def _cone(rows: CartRows, slopes: Sequence[CartRows], side: Side, stated: tuple[float, str]) -> CartRows:
    """`(b - a F, q (D F - d))` for a side; `stated` are q and what is added to the side's name."""
    (i, which), (quantile, suffix) = side, stated
    sign = 1.0 if which == "high" else -1.0
    name = (rows.high_names if which == "high" else rows.low_names)[i] + suffix
    of_sum = [-sign * rows.of_sum[i], *(quantile * slope.of_sum[i] for slope in slopes)]
    of_arm = [-sign * rows.of_arm[:, i], *(quantile * slope.of_arm[:, i] for slope in slopes)]
    offset = [sign * getattr(rows, which)[i], *(-quantile * getattr(slope, which)[i] for slope in slopes)]
    names, free = (name, *[""] * len(slopes)), np.full(len(offset), np.inf)
    cone = RowCone(name, 0, np.array(offset))
    return CartRows(np.array(of_sum), np.stack(of_arm, axis=1), -free, free, names, names, (cone,))
