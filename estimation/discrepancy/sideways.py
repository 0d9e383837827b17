"""What the wrenches can't show: how the axle moves across its wheels, read from the poses alone.

Between rows the axle goes sideways by `n · (p1 - p0)`, n at the mean heading. Summed over blocks, that is noise of the
poses at the blocks' ends, which neighbours share, and what constraint effects add to it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg import block_diag
from scipy.special import log_ndtr
from scipy.stats import chi2

from cartgrasp.effects import KNOWN_EFFECTS, ConstraintEffect, Effect
from cartgrasp.frames import Array
from cartgrasp.model import CartModel

from ..batch.wrench_regression import WrenchRegression
from ..log_noise import noise_floor
from .evidence import Finding
from .pushes import planar_wrench

BLOCK = 0.5
"""s."""
FAR = 6.0
"""Times the usual distance: a recorded heading that is farther from the smoothed one is an accident."""
LEAST_CREEP = 0.002
"""m/s, root mean square: less is in every bearing."""
BESIDE, ALL_THE_REST = 0.25, 0.8
"""Of the speed that an earlier effect explains: less is what every tyre gives at an angle, or what tyres that creep do
besides, of another form, if it is not so much of what they leave on stretches that no fit saw."""
SHARE_STD = 3.0
"""Of the usual size: the standard deviation of an effect's before data."""
NO_AMPLITUDES = np.zeros(0, dtype=int)


@dataclass(frozen=True)
class Sideways:
    """Of blocks (b,): metres to the left, their covariance, and the rows of `log` in which each begins and ends."""

    moved: Array
    covariance: Array
    log: np.ndarray
    rows: np.ndarray

    @classmethod
    def of(cls, regressions: Sequence[WrenchRegression], cart: CartModel) -> Sideways:
        moved, covariances, logs, rows = [], [], [], []
        for k, regression in enumerate(regressions):
            own, covariance, spans = _of_log(regression, cart)
            moved.append(own)
            covariances.append(covariance)
            logs.append(np.full(len(own), k))
            rows.append(spans)
        return cls(np.concatenate(moved), block_diag(*covariances), np.concatenate(logs), np.concatenate(rows))

    def expected(self, regressions: Sequence[WrenchRegression], cart: CartModel) -> Array:
        """What a cart's constraint effects make of it (b,)."""
        found = np.zeros(len(self.moved))
        for k, regression in enumerate(regressions):
            steps = np.append(np.diff(regression.motion.time), 0.0)
            travelled = np.append(0.0, np.cumsum(_velocity(regression, cart) * steps))
            own = self.log == k
            found[own] = travelled[self.rows[own, 1]] - travelled[self.rows[own, 0]]
        return found

    def spans(self, regressions: Sequence[WrenchRegression]) -> tuple[Array, Array]:
        """When each block begins and how long it lasts (b,), s."""
        ends = np.zeros(self.rows.shape)
        for k, regression in enumerate(regressions):
            own = self.log == k
            ends[own] = regression.motion.time[self.rows[own]]
        return ends[:, 0], ends[:, 1] - ends[:, 0]

    @cached_property
    def whitening(self) -> Array:
        """Of what is moved (b, b)."""
        return np.asarray(np.linalg.cholesky(np.linalg.inv(self.covariance)).T)

    def excess(self, left: Array) -> float:
        """How many times too small the noise variance is believed to be, 1 or more, where so much (b,) is left: what
        goes smoothly from block to block is no noise."""
        return max(1.0, noise_floor(self.whitening @ left) ** 2)


@dataclass(frozen=True)
class SidewaysTrial:
    """A constraint effect fitted to what is left of the sideways motion: its finding, how many times too small the
    noise is believed to be with it, its gain on blocks that the fit did not see (a share of what is left there), and
    the speed (m/s, root mean square) that it explains."""

    finding: Finding
    excess: float
    held_out_gain: float
    speed: float

    def is_worth(self, log_factor: float, gain: float, earlier: float) -> bool:
        """Beside an effect that explains a speed (m/s)."""
        if self.speed < BESIDE * earlier:
            gain = np.inf if _gives(self.finding.effect) else max(gain, ALL_THE_REST)
        return self.finding.log_factor > log_factor and self.held_out_gain > gain and self.speed > LEAST_CREEP


def sideways_trials(regressions: Sequence[WrenchRegression], cart: CartModel) -> list[SidewaysTrial]:
    """One for each constraint effect that the cart does not have, the most probable first."""
    if cart.constraints.axle_x is None:
        return []
    record = Sideways.of(regressions, cart)
    if len(record.moved) < 8:
        return []
    base = record.expected(regressions, cart)
    taken = {type(effect) for effect in cart.effects}
    found = []
    for kind in KNOWN_EFFECTS.values():
        if issubclass(kind, ConstraintEffect) and kind not in taken:
            usual = kind.usual("")
            column = record.expected(regressions, cart.with_effect(usual)) - base
            found.append((usual, column))
    if not found:
        return []
    root = record.whitening
    residual = root @ (record.moved - base)
    columns = [root @ column for _, column in found]
    excess = min(_excess(residual - c * (c @ residual) / max(float(c @ c), 1e-12)) for c in columns)
    usual_speed = [float(np.sqrt((column**2).mean())) / BLOCK for _, column in found]
    pairs = zip(found, columns, usual_speed, strict=True)
    trials = [_trial(usual, c, residual, excess, speed) for (usual, _), c, speed in pairs]
    return sorted(trials, key=lambda one: -one.finding.log_factor)


def _trial(usual: ConstraintEffect, column: Array, residual: Array, excess: float, speed: float) -> SidewaysTrial:
    information = float(column @ column) / excess
    pull = float(column @ residual) / excess
    variance = 1 / (information + SHARE_STD**-2)
    share, std = pull * variance, variance**0.5
    gain = 0.5 * pull * share
    factor = gain + 0.5 * np.log(variance / SHARE_STD**2)
    if usual.scaled(-1.0).values[0] == usual.parameters[0].absent or _gives(usual):
        factor += np.log(2) + float(log_ndtr(share / std))
    effect = usual.scaled(share)
    slope = np.abs(usual.scaled(share + std / 2).values - usual.scaled(share - std / 2).values)
    finding = Finding(effect, float(factor), gain, NO_AMPLITUDES, np.zeros(0), slope)
    return SidewaysTrial(finding, excess, _held_out_gain(column, residual, excess), abs(share) * speed)


def _gives(effect: Effect) -> bool:
    return isinstance(effect, ConstraintEffect) and effect.slip_compliance > 0


def _held_out_gain(column: Array, residual: Array, excess: float) -> float:
    """Every third block is left out of the fit."""
    kept = np.arange(len(residual)) % 3 == 2
    size = float(column[~kept] @ column[~kept])
    share = float(column[~kept] @ residual[~kept]) / size if size > 0 else 0.0
    before = float((residual[kept] ** 2).sum()) - excess * kept.sum()
    after = float(((residual - share * column)[kept] ** 2).sum()) - excess * kept.sum()
    return (before - after) / before if before > 0 else 0.0


def _excess(whitened: Array) -> float:
    return max(1.0, float(np.median(whitened**2)) / float(chi2.median(1)))


def _of_log(regression: WrenchRegression, cart: CartModel) -> tuple[Array, Array, np.ndarray]:
    motion, axle = regression.motion, float(cart.constraints.axle_x or 0.0)
    pose = regression.rows.pose
    seen = np.asarray(np.isfinite(pose[:, :2]).all(axis=1))
    linked = np.asarray(motion.linked & seen[:-1] & seen[1:])
    heading = _recorded_heading(regression)
    middle = (heading[:-1] + heading[1:]) / 2
    step = np.where(linked[:, None], np.diff(pose[:, :2], axis=0), 0.0)
    across = -np.sin(middle) * step[:, 0] + np.cos(middle) * step[:, 1] + axle * np.diff(motion.pose[:, 2])
    block = ((motion.time - motion.time[0]) // BLOCK).astype(int)
    first = np.flatnonzero(np.diff(block, prepend=-1))
    spans = np.column_stack([first[:-1], first[1:]])
    broken = np.append(0, np.cumsum(~linked))[spans]
    whole = np.flatnonzero(broken[:, 0] == broken[:, 1])
    total = np.append(0.0, np.cumsum(across))
    moved = total[spans[:, 1]] - total[spans[:, 0]]
    n = len(spans)
    duration = motion.time[spans[:, 1]] - motion.time[spans[:, 0]]
    noise = regression.row_noise
    slow = 0.0 if motion.slow is None else motion.slow.colour.position
    covariance = (noise.position**2 + slow**2) * (2 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1))
    turned = noise.heading * np.abs(motion.velocity[spans[:, 0], 0]) * duration
    covariance += np.diag(noise.slip**2 * duration + turned**2 * (motion.time[1] - motion.time[0]) / duration)
    return moved[whole], covariance[np.ix_(whole, whole)], spans[whole]


def _recorded_heading(regression: WrenchRegression) -> Array:
    """Of rows (n,): smoothed ones lean towards where the cart was believed to roll. They stand in for what is missing,
    or far from them."""
    smooth, recorded = regression.motion.pose[:, 2], regression.rows.pose[:, 2]
    off = (recorded - smooth + np.pi) % (2 * np.pi) - np.pi
    far = np.abs(off) > FAR * max(regression.row_noise.heading, float(np.nanmedian(np.abs(off))))
    return np.asarray(smooth + np.where(np.isfinite(off) & ~far, off, 0.0))


def _velocity(regression: WrenchRegression, cart: CartModel) -> Array:
    """Of the axle to the left (n,), m/s."""
    motion, axle = regression.motion, float(cart.constraints.axle_x or 0.0)
    memory = cart.memory_along(motion.pose, motion.velocity, motion.time)
    state = np.hstack([motion.pose, motion.velocity, memory])
    rate = cart.state_rate(state, planar_wrench(regression, cart), time=motion.time)
    heading = motion.pose[:, 2]
    return np.asarray(-np.sin(heading) * rate[:, 0] + np.cos(heading) * rate[:, 1] + axle * rate[:, 2])
