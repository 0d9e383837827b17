"""What a closed-loop run leaves behind."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from ..frames import Array
from ..logs.run_log import RunLog
from ..model import CartModel


@dataclass(frozen=True)
class Series:
    """A parameter over time: estimate and standard deviation (n,), truth (n,) where it is known, unit."""

    value: Array
    std: Array
    truth: Array | None
    unit: str

    def at(self, rows: slice) -> Series:
        return Series(self.value[rows], self.std[rows], None if self.truth is None else self.truth[rows], self.unit)


@dataclass(frozen=True)
class RunRecord:
    """One closed-loop run, n control steps.

    `log` holds what was measured; poses (n, 3) of {b} in {s} and speeds (n, n_free) are the truth and the
    reference; `wrenches` what each arm really gave, (n, 6) in {a}; `parameters` the estimates by contract name
    (`mass`, `com_x`, `com_y`, `inertia`, `EFFECT.PARAMETER`), empty without estimation; `identifiable` says at the end
    which of them the motion has taught; `statuses` one word a plan, `healths` one an estimate; `com_covariance`
    (n, 2, 2), m², is that of the estimated CoM in {b}, where it is known; `words` are what the controller says that it
    does, each with the time (s) from which on.
    """

    log: RunLog
    cart: CartModel
    pose: Array
    velocity: Array
    reference_pose: Array
    reference_velocity: Array
    wrenches: Mapping[str, Array]
    parameters: Mapping[str, Series]
    caster_headings: Array | None
    statuses: tuple[str, ...]
    identifiable: Mapping[str, bool] = field(default_factory=dict)
    com_covariance: Array | None = None
    healths: tuple[str, ...] = ()
    words: tuple[tuple[float, str], ...] = ()

    @property
    def time(self) -> Array:
        return self.log.time

    @property
    def tracking_error(self) -> Array:
        """Distance of {b}'s origin from the reference, (n,), m."""
        difference = self.pose[:, :2] - self.reference_pose[:, :2]
        return np.asarray(np.hypot(difference[:, 0], difference[:, 1]))
