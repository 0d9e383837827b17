"""How a cart moved and where it was: what a residual, or a law, may follow."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np

from cartgrasp.frames import Array

from ...weak_form.motion import Motion

MIN_DIRECTED_SPEED = 0.02
"""Least speed (m/s) at which a motion has a direction."""


@dataclass(frozen=True)
class Covariates:
    """At some times (b,): time since the log's first row, s; way rolled forward less backward, and both together
    (`travelled`), m; heading, rad; forward speed, m/s; yaw rate, rad/s; place of {b} (b, 2), m; distance since the last
    reversal, m (infinite before the first)."""

    time: Array
    way: Array
    travelled: Array
    heading: Array
    speed: Array
    yaw_rate: Array
    place: Array
    since_reversal: Array

    @classmethod
    def along(cls, motion: Motion) -> Covariates:
        """Covariates at all times of a motion (n,)."""
        speed, travelled = motion.velocity[:, 0], motion.way
        yaw_rate = motion.velocity[:, -1] if motion.velocity.shape[1] > 1 else np.zeros(len(speed))
        way = np.append(0.0, np.cumsum(speed[:-1] * np.diff(motion.time)))
        since = since_reversal(speed, travelled)
        return cls(
            motion.time - motion.time[0], way, travelled, motion.pose[:, 2], speed, yaw_rate, motion.pose[:, :2], since
        )

    @property
    def x(self) -> Array:
        return self.place[:, 0]

    @property
    def y(self) -> Array:
        return self.place[:, 1]

    @classmethod
    def of(cls, time: Array, log: np.ndarray, motions: Sequence[Motion]) -> Covariates:
        """Covariates at times (b,), by the clock of the logs (b,) to which they belong; logs follow one another."""
        parts = [cls.along(motion).at(rows_at(motion, time[log == k])) for k, motion in enumerate(motions)]
        names = [field.name for field in fields(cls)]
        return cls(*(np.concatenate([getattr(part, name) for part in parts]) for name in names))

    def at(self, rows: np.ndarray) -> Covariates:
        return Covariates(*(getattr(self, field.name)[rows] for field in fields(self)))


def rows_at(motion: Motion, time: Array) -> np.ndarray:
    """The rows of a motion nearest to some times."""
    return np.asarray(np.clip(np.rint((time - motion.time[0]) / motion.step).astype(int), 0, len(motion.time) - 1))


def since_reversal(speed: Array, travelled: Array) -> Array:
    """Distance (n,) since the direction was another, from forward speeds (n,) and travelled distances (n,); infinite
    before it ever was."""
    rolls = np.flatnonzero(np.abs(speed) > MIN_DIRECTED_SPEED)
    turned = rolls[1:][np.diff(np.sign(speed[rolls])) != 0]
    last = np.searchsorted(turned, np.arange(len(speed)), side="right")
    return np.asarray(travelled - np.append(-np.inf, travelled[turned])[last])
