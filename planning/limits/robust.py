"""Margins from the estimate's covariance: limits of the cart that hold with a stated probability, as cones.

A side of a limit is `g(F, theta) = a(theta) F - b(theta) <= 0`, with theta the model's parameters. For theta ~
N(mean, P) and P = L Lᵀ, g is normal to first order, with the standard deviation `‖D F - d‖`: D and d are the slopes of
a and b along the columns of L. So (chance constraint, exact where a and b are affine in theta)

    P(g <= 0) >= p    where    b - a F >= q ‖D F - d‖,    q the p-quantile of N(0, 1).

The k sides that depend on theta hold together with the `confidence` c for p = 1 - (1 - c) / k, whatever their
correlation (Bonferroni). What is asked of the cart, and the arms' own limits, are free of theta and stay as they are.
Limits of the floor add up wheels' loads and the lateral force (`FloorLimit`), so their slopes add up the analytic ones
of these (`FloorReaction.with_partials`): a limit states nothing for its margins, and neither a step nor how wide the
covariance is matters to them.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from statistics import NormalDist
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cartgrasp.checks import number
from cartgrasp.errors import UsageError
from cartgrasp.floor_reaction import n_loads
from cartgrasp.frames import Array

from .cart_limit import CartLimit, CartRows, PushedCart
from .floor_limit import FloorLimit, FloorRows

if TYPE_CHECKING:
    from cartgrasp.model import CartModel

CORRELATION_RANK_TOLERANCE = 1e-12  # of the correlation: what counts as uncertain
MIN_SLOPE_STD = 1e-9  # N: a standard deviation that is rounding


@dataclass(frozen=True)
class RobustLimits:
    """Limits of the cart, and with which probability they hold together; None: for the cart as estimated."""

    limits: tuple[CartLimit, ...]
    confidence: float | None = None

    def __post_init__(self) -> None:
        if self.confidence is not None and not 0.5 <= number("confidence", self.confidence) < 1:
            raise UsageError(f"confidence: {self.confidence} is not a probability from 0.5 to below 1")

    def on_floor(self, cart: CartModel) -> FloorRows:
        """Rows of all limits of the floor, the same for all carts of one structure."""
        stated = [limit.checked_on_floor(cart) for limit in self.limits if isinstance(limit, FloorLimit)]
        return FloorRows.stacked(stated, n_loads(cart))

    def rows(
        self,
        pushed: PushedCart,
        covariance: Array | None = None,
        on_floor: FloorRows | None = None,
        share: float | None = 1.0,
    ) -> CartRows:
        """Cones in the place of sides that depend on the cart's parameters, of which `covariance` (p, p) is; `on_floor`
        is what this says of such a cart, `share` how much of the margins is kept; None: no limit of the floor is."""
        stated = self.on_floor(pushed.cart) if on_floor is None else on_floor
        parts = [limit.checked_rows(pushed) for limit in self.limits if not isinstance(limit, FloorLimit)]
        if len(stated.low):
            now = self._with_margins(stated, pushed, covariance, share or 0.0)
            parts.append(now.lifted() if share is None else now)
        return parts[0] if len(parts) == 1 else CartRows.stacked(parts, len(pushed.arms))

    def _with_margins(self, stated: FloorRows, pushed: PushedCart, covariance: Array | None, share: float) -> CartRows:
        n_arms = len(pushed.arms)
        if self.confidence is None or covariance is None:
            return stated.under(pushed.floor, n_arms)
        floor, partials = pushed.floor_with_partials
        slopes = _slopes(stated.mix, partials, covariance)
        return _as_cones(stated.under(floor, n_arms), slopes, self.confidence, share)


def root(covariance: Array) -> Array:
    """L (p, r) with L Lᵀ = covariance (p, p); units may differ from parameter to parameter. r is p, or its rank where
    correlations are singular."""
    return _root(np.asarray(covariance, dtype=float).tobytes(), len(covariance))


@lru_cache(maxsize=16)
def _root(numbers: bytes, size: int) -> Array:
    """From tick to tick a covariance is often the same."""
    covariance = np.frombuffer(numbers).reshape(size, size)
    deviations = np.sqrt(np.maximum(np.diagonal(covariance), 0.0))
    units = np.where(deviations > 0, deviations, 1.0)
    correlation = covariance / np.outer(units, units)
    try:
        found = deviations[:, None] * np.linalg.cholesky(correlation + np.diag(deviations == 0))
    except np.linalg.LinAlgError:
        values, vectors = np.linalg.eigh(correlation)
        kept = values > CORRELATION_RANK_TOLERANCE * max(1.0, float(values.max(initial=0.0)))
        found = np.asarray(units[:, None] * vectors[:, kept] * np.sqrt(values[kept]))
    found.setflags(write=False)
    return found


def _slopes(mix: Array, partials: Array, covariance: Array) -> Array:
    """Derivatives (k, r, 7) of rows `mix` (k, n + 1) along r directions of the parameters, a deviation each;
    `partials` (p, n + 1, 7) are the floor's."""
    directions = root(covariance).T
    along = (directions @ partials.reshape(len(partials), -1)).reshape(len(directions), -1, 7)
    return np.asarray((mix @ along).swapaxes(0, 1))


def _as_cones(rows: CartRows, slopes: Array, confidence: float, share: float) -> CartRows:
    """`(b - a F, share q (D F + d))` in the place of each side that has slopes (k, r, 7), which are D and d."""
    depends = ~(np.abs(slopes).max(axis=(1, 2), initial=0.0) <= MIN_SLOPE_STD)  # NaN is none of nought
    which = depends.tobytes(), np.isfinite(rows.low).tobytes(), np.isfinite(rows.high).tobytes()
    sides = _sides(which, (rows.low_names, rows.high_names), confidence, slopes.shape[1])
    n_sides, left, free = len(sides.of), sides.left, sides.free
    if n_sides == 0:
        return rows
    cones = np.empty((n_sides, 1 + slopes.shape[1], 7))
    cones[:, 0, :6] = -sides.sign * rows.of_sum[sides.of]
    cones[:, 0, 6] = np.concatenate([-rows.low, rows.high])[sides.among_both]
    cones[:, 1:] = share * sides.quantile * slopes[sides.of]
    return CartRows(
        of_sum=np.concatenate([rows.of_sum[left], cones[:, :, :6].reshape(-1, 6)]),
        of_arm=np.zeros((len(rows.of_arm), len(left) + len(free), 6)),
        low=np.concatenate([np.where(depends, -np.inf, rows.low)[left], -free]),
        high=np.concatenate([np.where(depends, np.inf, rows.high)[left], free]),
        low_names=sides.low_names,
        high_names=sides.high_names,
        cone_names=sides.names,
        cone_offsets=cones[:, :, 6],
    )


class _Sides(NamedTuple):
    """Which rows (k,) have c sides that become cones: `of` (c,), with a sign (c, 1), and their places (c,) where the
    low sides stand before the high ones; the q-quantile; which rows are `left`; no limits for the cones' rows; names.
    """

    of: NDArray[np.int64]
    sign: Array
    among_both: NDArray[np.int64]
    quantile: float
    left: NDArray[np.int64]
    free: Array
    names: tuple[str, ...]
    low_names: tuple[str, ...]
    high_names: tuple[str, ...]


@lru_cache(maxsize=64)
def _sides(
    which: tuple[bytes, bytes, bytes], names: tuple[tuple[str, ...], tuple[str, ...]], confidence: float, r: int
) -> _Sides:
    """Often those of the tick before. `which`: rows that depend on the parameters, have a low limit, and a high one."""
    depends, has_low, has_high = (np.frombuffer(part, dtype=bool) for part in which)
    (low_names, high_names), k = names, len(depends)
    low, high = (np.flatnonzero(depends & has) for has in (has_low, has_high))
    left = np.flatnonzero(~depends & (has_low | has_high))
    of, n_sides = np.concatenate([low, high]), len(low) + len(high)
    suffix = f" ({100 * confidence:g} %)"
    found = [low_names[i] + suffix for i in low.tolist()] + [high_names[i] + suffix for i in high.tolist()]
    each = tuple(part for name in found for part in (name, *[""] * r))
    return _Sides(
        of=of,
        sign=np.repeat([-1.0, 1.0], [len(low), len(high)])[:, None],
        among_both=np.concatenate([low, k + high]),
        quantile=-NormalDist().inv_cdf((1.0 - confidence) / max(n_sides, 1)),
        left=left,
        free=np.full(n_sides * (1 + r), np.inf),
        names=tuple(found),
        low_names=tuple([low_names[i] for i in left.tolist()]) + each,
        high_names=tuple([high_names[i] for i in left.tolist()]) + each,
    )
