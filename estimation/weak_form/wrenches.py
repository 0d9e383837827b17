"""The recorded wrenches of a log on a motion's grid, without what is faster than that.

Between samples they go along cubics: on straight lines what swings at ω would be too small by (ω dt)²/12, and so would
a cart's mass, by 1.2 % at 3 Hz and 50 samples a second.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import CubicHermiteSpline

from cartgrasp.contacts import grasp_map_planar
from cartgrasp.effects.effect import HAND_AT_REST
from cartgrasp.frames import Array
from cartgrasp.logs import RunLog
from cartgrasp.model import CartModel

from ..log_noise.sample_step import usual_step
from .motion import MAX_GAP_STEPS, Motion

MIN_WRENCH_DENSITY, MIN_COVARIANCE_RATIO = 1e-4, 1e-9
"""Smallest density (N/√Hz, N·m/√Hz), and share of a covariance: they keep wrenches without noise, and points without an
arm, solvable."""
MAX_SENSOR_DELAY = 0.25
"""Lateness (s) that is more than that of any sensor that is asked about."""
WHOLE_GRID = slice(None)
"""Slice of all points of a grid."""


class Densities(NamedTuple):
    """Noise densities: their roots for the arms' wrenches (arms, 6), and that of other noise of the reduced wrench (n,
    f)."""

    arms: Array
    others: Array | None

    def scaled(self, size: float) -> Densities:
        """Densities with other noise that is `size` times as large."""
        return self if self.others is None else self._replace(others=size**2 * self.others)

    def at(self, part: slice) -> Densities:
        """Densities at a part of the times."""
        return self if self.others is None else self._replace(others=self.others[part])


@dataclass(frozen=True, eq=False)
class GridWrenches:
    """Contact points (arms, n, 3) with planar grasp maps (arms, n, 3, 6) and wrenches in {a} (arms, n, 6) at times (n,)
    of a motion; where motion and contacts are seen (`held`, (n,)), where all is (`seen`, (n,)), and where it would be,
    however late sensors are (`ahead`, (n,))."""

    arms: tuple[str, ...]
    motion: Motion
    contacts: Array
    grasps: Array
    recorded: Array
    held: np.ndarray
    seen: np.ndarray
    ahead: np.ndarray

    @classmethod
    def on(cls, log: RunLog, motion: Motion, delay: ArrayLike = 0.0) -> GridWrenches:
        """Wrenches of a log on a motion's grid, from sensors that tell what they felt `delay` (s; of each arm, or of
        all) ago."""
        shape, held = (len(log.arms), len(motion.time)), motion.seen.copy()
        contacts = np.zeros((*shape, 3))
        for i, arm in enumerate(log.arms.values()):
            contacts[i], own = _held(log.time, arm.contact, motion.time)
            held &= own
        grasps = np.array([grasp_map_planar(own) for own in contacts]).reshape(*shape, 3, 6)
        whole = cls(tuple(log.arms), motion, contacts, grasps, np.zeros((*shape, 6)), held, held, held).late(log, 0.0)
        ahead = _before_none(whole.seen, round(MAX_SENSOR_DELAY / motion.step)) if log.arms else held
        return replace(whole, ahead=ahead).late(log, delay)

    def late(self, log: RunLog, delay: ArrayLike) -> GridWrenches:
        """Wrenches of the same log, from sensors that tell what they felt `delay` (s; of each arm, or of all) ago."""
        recorded, seen = np.zeros_like(self.recorded), self.held.copy()
        delays = np.broadcast_to(delay, len(log.arms)).tolist()
        for i, (arm, own) in enumerate(zip(log.arms.values(), delays, strict=True)):
            known = np.isfinite(arm.wrench).all(axis=1)
            recorded[i], near = _on_grid(log.time[known] - own, arm.wrench[known], self.motion.time, self.motion.step)
            seen &= near
        return replace(self, recorded=recorded, seen=seen)

    def corrected(self, cart: CartModel, arm: int, recorded: Array, part: slice = WHOLE_GRID) -> tuple[Array, Array]:
        """The true wrench (n, 6) behind what an arm recorded (n, 6) at times of a part of the grid, and its partials by
        the parameters (n, 6, p)."""
        hand = HAND_AT_REST
        if cart.feels_motion:
            motion = self.motion.of_body(cart)
            hand = cart.hand_motion(motion.velocity[part], motion.smooth_acceleration[part], self.contacts[arm][part])
        return cart.corrected_wrench(self.arms[arm], recorded, hand=hand)

    def planar(self, cart: CartModel, part: slice = WHOLE_GRID) -> Array:
        """The true planar wrench on the cart (n, 3) in {b} behind what is recorded."""
        if not cart.sensor_effects:
            return self._as_recorded[part]
        own = (self.corrected(cart, arm, each[part], part)[0] for arm, each in enumerate(self.recorded))
        return self._summed(own, part)

    @cached_property
    def _as_recorded(self) -> Array:
        return self._summed(self.recorded, WHOLE_GRID)

    def _summed(self, wrenches: Iterable[Array], part: slice) -> Array:
        """Planar wrench (n, 3) of all arms on the cart in {b}, from each arm's (n, 6)."""
        value = np.zeros((len(self.motion.time[part]), 3))
        for grasp, wrench in zip(self.grasps, wrenches, strict=True):
            value += (grasp[part] @ wrench[..., None])[..., 0]
        return value

    def recorded_share(
        self, cart: CartModel, known: Densities, acting: Densities, part: slice = WHOLE_GRID
    ) -> Array | None:
        """Matrices (n, f, f) that take rows from the noise of what acts to the `known` noise, where sensors are not as
        they should be. What is left is then compared in recorded wrenches, whose noise is known (Deming's regression).
        None where nothing changes."""
        if not cart.sensor_effects:
            return None
        pairs = (cart.basis_b.T @ self.grasps[:, part], known.at(part)), (self._felt(cart, part), acting.at(part))
        recorded, true = (np.linalg.cholesky(_covariance(*pair)) for pair in pairs)
        return np.asarray(recorded @ np.linalg.inv(true))

    def _felt(self, cart: CartModel, part: slice) -> Array:
        """Maps (arms, n, f, 6) from a change of an arm's recorded wrench to that of the reduced wrench that acts."""
        unit, none = np.eye(6), np.zeros((6, 6))
        maps = [(cart.corrected_wrench(arm, unit)[0] - cart.corrected_wrench(arm, none)[0]).T for arm in self.arms]
        return np.asarray(cart.basis_b.T @ self.grasps[:, part] @ np.reshape(maps, (-1, 1, 6, 6)))

    def slopes(self, cart: CartModel, expected: Array, densities: Densities, part: slice = WHOLE_GRID) -> Array:
        """Slopes (n, f, p) of the reduced wrench by the parameters of the cart's sensor effects, at the wrenches that
        are most likely behind those recorded where a model expects (n, f) of them. By a gain or an angle they are in
        proportion to wrenches: to recorded ones, they would have their noise, and all that the model lacks, on both
        sides. What is left of the noise goes with no balance's."""
        f = expected.shape[1]
        found = np.zeros((len(expected), f, len(cart.parameters)))
        if not cart.sensor_effects:
            return found
        felt, variances = self._felt(cart, part), _variances(densities.arms)
        missing = expected - self.planar(cart, part) @ cart.basis_b
        share = np.linalg.solve(_covariance(felt, densities.at(part)), missing[..., None])
        for arm, (recorded, own) in enumerate(zip(self.recorded, variances, strict=True)):
            nearest = recorded[part] + own * (np.swapaxes(felt[arm], 1, 2) @ share)[..., 0]
            found += cart.basis_b.T @ self.grasps[arm][part] @ self.corrected(cart, arm, nearest, part)[1]
        return found


def _variances(densities: Array) -> Array:
    return np.asarray(densities**2 + MIN_WRENCH_DENSITY**2)


def _covariance(reduced: Array, densities: Densities) -> Array:
    """Covariance (n, f, f) of the sum of the arms' noise through reduced maps (arms, n, f, 6) and of other noise."""
    found = np.einsum("anfi,ai,angi->nfg", reduced, _variances(densities.arms), reduced)
    least = MIN_COVARIANCE_RATIO * np.trace(found, axis1=1, axis2=2) + MIN_WRENCH_DENSITY**2
    others = np.zeros(found.shape[1]) if densities.others is None else densities.others
    return np.asarray(found + (least[:, None] + others)[:, None] * np.eye(found.shape[1]))


def _on_grid(time: Array, values: Array, grid: Array, step: float) -> tuple[Array, np.ndarray]:
    """Values (n, k) at points of a grid, without what is faster than its `step`; and where samples are near (n,)."""
    if len(time) < 2:
        return np.zeros((len(grid), values.shape[1])), np.zeros(len(grid), dtype=bool)
    native = usual_step(time)
    edges = np.clip(np.append(grid - step / 2, grid[-1] + step / 2), time[0], time[-1])
    covered = np.diff(edges)
    curve = CubicHermiteSpline(time, values, _slopes(time, values))
    mean = np.diff(curve.antiderivative()(edges), axis=0) / np.maximum(covered, 1e-12)[:, None]
    after = np.clip(np.searchsorted(time, grid), 1, len(time) - 1)
    near = (time[after] - time[after - 1] <= MAX_GAP_STEPS * max(native, step)) & (covered > 0.4 * step)
    return np.where(near[:, None], _of_means(mean, near), 0.0), np.asarray(near)


def _slopes(time: Array, values: Array) -> Array:
    """Slopes (n, k) at samples: of the straight line between their neighbours. Any that is nearer to one of these takes
    its noise for a slope, the more the nearer that is."""
    before, after = np.maximum(np.arange(len(time)) - 1, 0), np.minimum(np.arange(len(time)) + 1, len(time) - 1)
    return np.asarray((values[after] - values[before]) / (time[after] - time[before])[:, None])


def _of_means(mean: Array, known: np.ndarray) -> Array:
    """Values (n, k) in the middle of cells with such means: these take step²/24 of the second derivative away."""
    inner = known[:-2] & known[1:-1] & known[2:]
    value = mean.copy()
    value[1:-1] -= np.where(inner[:, None], np.diff(mean, 2, axis=0), 0.0) / 24
    return value


def _held(time: Array, contact: Array, grid: Array) -> tuple[Array, np.ndarray]:
    """Contact points (n, 3): the last that was seen holds; and where there was one."""
    known = np.flatnonzero(np.isfinite(contact).all(axis=1))
    if not len(known):
        return np.zeros((len(grid), 3)), np.zeros(len(grid), dtype=bool)
    last = np.searchsorted(time[known], grid + 1e-9) - 1
    return contact[known[np.maximum(last, 0)]], last >= 0


def _before_none(seen: np.ndarray, count: int) -> np.ndarray:
    """Where (n,) what comes is seen, too, up to `count` points ahead."""
    unseen = np.append(0, np.cumsum(~np.append(seen, np.zeros(count, dtype=bool))))
    return np.asarray(unseen[count + 1 :] == unseen[: len(seen)])
