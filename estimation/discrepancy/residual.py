"""What a model leaves of each coordinate: means over stretches, their standard deviations, and the circumstances."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from cartgrasp.frames import Array

from .circumstances import Circumstances
from .fitted import Fitted
from .scatter import SCATTER_BLOCK
from .sideways import BLOCK, LEAST_CREEP, Sideways

LATERAL = "lateral_velocity"
DIRECTIONS = {
    1: ("forward_force",),
    2: ("forward_force", "yaw_moment"),
    3: ("forward_force", "side_force", "yaw_moment"),
}
"""Of the residual wrench, by the number of free directions."""
LEAST = {LATERAL: LEAST_CREEP}
"""Root mean square beyond noise: less is no disagreement."""
UNITS = {"forward_force": "N", "side_force": "N", "yaw_moment": "N·m", LATERAL: "m/s"}
SURE = 3.0
"""Standard deviations of what noise makes of the squares."""


@dataclass(frozen=True)
class Residual:
    """Of one coordinate: means (b,) over stretches that begin at `start` (b,) and last for `duration` (s), and their
    standard deviations (b,)."""

    coordinate: str
    value: Array
    std: Array
    start: Array
    duration: float
    circumstances: Circumstances

    @property
    def unit(self) -> str:
        return UNITS[self.coordinate]

    @property
    def standard(self) -> Array:
        return self.value / self.std

    @cached_property
    def beyond(self) -> Array:
        """Of each stretch (b,), by how much its square is more than that of noise: noise alone takes some below, and
        none on the whole."""
        return self.standard**2 - 1.0

    @cached_property
    def changes(self) -> tuple[tuple[int, ...], ...]:
        """Of each log, the places among its stretches at which the residual's size changes."""
        from .changes import changes

        logs = range(len(self.circumstances.names))
        return tuple(tuple(changes(self.standard[self.circumstances.log == k])) for k in logs)

    @property
    def change_times(self) -> tuple[Array, ...]:
        """Of each log, s."""
        own = (self.start[self.circumstances.log == k] for k in range(len(self.changes)))
        return tuple(start[list(places)] for start, places in zip(own, self.changes, strict=True))

    @property
    def disagrees(self) -> bool:
        """Whether all stretches together are farther off than noise takes them, by an amount that counts."""
        size = np.maximum((self.value**2 - self.std**2).mean(), 0.0) ** 0.5
        is_sure = self.beyond.sum() > SURE * (2 * len(self.beyond)) ** 0.5
        return bool(is_sure and size > LEAST.get(self.coordinate, 0.0))


def wrench_residuals(fitted: Fitted) -> tuple[Residual, ...]:
    """Along the free directions."""
    scatter, f = fitted.scatter, fitted.scatter.mean.shape[1]
    found = Circumstances.of(scatter.middle, scatter.log, fitted.regressions, fitted.cart)
    return tuple(
        Residual(name, scatter.mean[:, i], scatter.std[:, i], scatter.start, SCATTER_BLOCK, found)
        for i, name in enumerate(DIRECTIONS[f])
    )


def lateral_residual(fitted: Fitted, final: Fitted) -> tuple[Residual, ...]:
    """How fast the axle goes sideways beyond what a model says; none where it may go any way, or no other than its
    rails'. The noise is as large as the final model leaves it."""
    rolls = final.cart.constraints.axle_x is not None and not final.cart.constraints.no_rotation
    record = Sideways.of(final.regressions, final.cart) if rolls else None
    if record is None or not len(record.moved):
        return ()
    excess = record.excess(record.moved - record.expected(final.regressions, final.cart))
    left = record.moved - record.expected(final.regressions, fitted.cart)
    std = np.sqrt(excess * np.diagonal(record.covariance))
    start, length = record.spans(final.regressions)
    found = Circumstances.of(start + length / 2, record.log, final.regressions, final.cart)
    return (Residual(LATERAL, left / length, std / length, start, BLOCK, found),)
