"""What a model leaves of each coordinate: means over stretches, their standard deviations, and the circumstances."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse import csr_array

from cartgrasp.frames import Array

from ...weak_form.balances import Balances
from ...weak_form.whitening import Whitening
from ..search.model import Model, by_log
from .changes import changes
from .circumstances import Circumstances

LATERAL_VELOCITY = "lateral_velocity"
RESIDUAL_DIRECTIONS = {
    1: ("forward_force",),
    2: ("forward_force", "yaw_moment"),
    3: ("forward_force", "side_force", "yaw_moment"),
}
"""Coordinates of the residual wrench, by the number of free directions."""
MIN_CREEP_SPEED = 0.002
"""Least root mean square beyond noise (m/s) that is a disagreement: less is in every bearing."""
RESIDUAL_UNITS = {"forward_force": "N", "side_force": "N", "yaw_moment": "N·m", LATERAL_VELOCITY: "m/s"}
MEAN_STRETCH_INTERVAL = 0.5
"""Duration (s) of the stretches of means, where rows come as often as that."""
FINE_ROW_STEP = 0.1
"""Step (s) from row to row, where a figure shows each."""
STRETCH_EDGE_TOLERANCE = 1e-6
"""Tolerance as a share of a stretch: rows at its very begin are in it."""
RESIDUAL_EXCESS_SIGMAS = 3.0
"""Standard deviations of what noise makes of the squares."""


@dataclass(frozen=True)
class Residual:
    """Residual of one coordinate: means (b,) over stretches that begin at `start` (b,) and last for `duration` (s), and
    their standard deviations (b,)."""

    coordinate: str
    value: Array
    std: Array
    start: Array
    duration: float
    circumstances: Circumstances

    @property
    def unit(self) -> str:
        return RESIDUAL_UNITS[self.coordinate]

    @property
    def standard(self) -> Array:
        return self.value / self.std

    @cached_property
    def beyond(self) -> Array:
        """Square of each stretch (b,), in standard deviations, less that of noise. Noise alone makes some negative, and
        their sum about zero."""
        return self.standard**2 - 1.0

    @cached_property
    def changes(self) -> tuple[tuple[int, ...], ...]:
        """Places among each log's stretches at which the residual's size changes."""
        logs = range(len(self.circumstances.names))
        return tuple(tuple(changes(self.standard[self.circumstances.log == k])) for k in logs)

    @property
    def size(self) -> float:
        """Root mean square beyond noise, each stretch as much as it is known: of one in which the cart was held,
        nothing is."""
        return float(max(self.beyond.sum() / (self.std**-2.0).sum(), 0.0) ** 0.5)

    @property
    def disagrees(self) -> bool:
        """Whether all stretches together are farther off than noise takes them, by an amount that counts."""
        is_sure = self.beyond.sum() > RESIDUAL_EXCESS_SIGMAS * (2 * len(self.beyond)) ** 0.5
        return bool(is_sure and self.size > (MIN_CREEP_SPEED if self.coordinate == LATERAL_VELOCITY else 0.0))


def residuals(model: Model, noise: Model) -> tuple[Residual, ...]:
    """Residuals that `model` leaves of every coordinate, with standard deviations by `noise`, whose rows' noise is
    believed."""
    duration = max(MEAN_STRETCH_INTERVAL, *(balances.row_step for balances in model.logs))
    return _residuals(model, noise, model.logs, duration)


def fine_residuals(model: Model, noise: Model) -> tuple[Residual, ...]:
    """Residuals of single rows, as fine as any, whatever the model was fitted to."""
    logs = with_fine_rows(model.logs)
    return _residuals(model, noise, logs, max(balances.row_step for balances in logs))


def with_fine_rows(logs: Sequence[Balances]) -> tuple[Balances, ...]:
    """Balances with rows as fine as any."""
    return tuple(balances.every(FINE_ROW_STEP) for balances in logs)


def _residuals(model: Model, noise: Model, logs: tuple[Balances, ...], duration: float) -> tuple[Residual, ...]:
    left = by_log(model.residual_on(logs), logs)
    parts = [_means(*each, duration) for each in zip(logs, left, noise.noise.whitenings(logs), strict=True)]
    log = np.repeat(np.arange(len(parts)), [len(first) for first, _, _ in parts])
    start, value, std = (np.concatenate(each) for each in zip(*parts, strict=True))
    found = Circumstances.of(start + duration / 2, log, logs, model.cart)
    names = (*RESIDUAL_DIRECTIONS[model.cart.constraints.n_free], LATERAL_VELOCITY)
    return tuple(Residual(names[i], value[:, i], std[:, i], start, duration, found) for i in range(value.shape[1]))


def _means(balances: Balances, left: Array, whitening: Whitening, duration: float) -> tuple[Array, Array, Array]:
    """Begins (b,) of one log's stretches with rows, means (b, c) of raw rows (k, c) over test functions' weights, and
    standard deviations of these. Neighbours overlap, so their noise is theirs together."""
    is_fine = duration < 2 * balances.row_step
    first = float(balances.time[0]) - duration / 2 if is_fine else float(balances.motion.time[0])
    weight = balances.integrated(np.ones(len(balances.motion.time)))
    place = (balances.time - first) / duration + STRETCH_EDGE_TOLERANCE
    number, stretch = np.unique(place.astype(int), return_inverse=True)
    share = 1.0 / np.bincount(stretch)[stretch] / weight
    mean = csr_array((share, (stretch, np.arange(len(weight)))), shape=(len(number), len(weight)))
    return first + duration * number, np.asarray(mean @ left), whitening.deviations(mean)
