"""One log's information about the parameters: its wrenches regressed on its smoothed motion.

`z = w(pose, nu, memory, nu'; theta) + noise` holds at the smoothed motion with the noise `n + J e`, where e is what the
smoother missed. Generalised least squares with the covariance `R + J Σ Jᵀ` is what is left of the chain
`|e|² in Σ⁻¹ + |z - w - J e|² in R⁻¹` when e is taken out, and Σ⁻¹ is block tridiagonal. J is of the smoothed motion:
moved along with e, the regressors would take in the wrenches' noise.

A wrench may hold from its row to the next (its middle is half a step late), or be one sample: w is taken a share
`delay` of the step after its row, and that share is estimated too, as parameter p + 1.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cartgrasp.errors import DataError
from cartgrasp.frames import Array
from cartgrasp.logs import RunLog
from cartgrasp.logs.alignment import aligned
from cartgrasp.model import CartModel

from ..log_noise import noise_of_log
from ..noise import FilterNoise
from .block_tridiagonal import BlockTridiagonal
from .motion_smoother import smooth_motion
from .wrench_record import WrenchRecord

BLOCK = 0.5
"""s: what is left of a right model is uncorrelated over longer times."""
FEWEST_BLOCKS = 12
FEWEST_ROWS = 50
"""Of a log that tells its own noise."""
STILL = 3.0
"""Standard deviations of the smoothed velocity within which a cart may stand still."""
LONGEST_STEP = 3.0
"""Times the usual step: over a longer one nobody knows what a wrench did."""
OUTLYING = 4.0
"""Times its share of the scatter that a stretch may have with full weight."""


@dataclass(frozen=True)
class Evidence:
    """Around some parameters and delay: of each stretch of time the information (b, p + 1, p + 1) and the pull
    (b, p + 1) on them. Where the model is right, pulls are independent, with the information as covariance."""

    blocks: Array
    pulls: Array

    def part(self, which: np.ndarray) -> Evidence:
        """About some of the parameters."""
        return Evidence(self.blocks[:, which[:, None], which], self.pulls[:, which])

    def weighed(self, background: Array) -> tuple[Array, Array, float]:
        """Information and pull, with less weight for stretches that contradict themselves, and how many times as large
        as believed the noise variance is, where it matters: the pulls' scatter against the information, in the metric
        of the information with its background; 1 or more."""
        n, p = self.pulls.shape
        if n < FEWEST_BLOCKS:
            return self.blocks.sum(axis=0) if n else np.zeros((p, p)), self.pulls.sum(axis=0), 1.0
        metric = np.linalg.inv(self.blocks.sum(axis=0) + background)
        expected, scatter = self._scatter(metric)
        ratio = scatter / np.maximum(expected, 1e-12)
        usual = max(1.0, float(np.median(ratio)))
        weights = np.minimum(1.0, OUTLYING * usual / np.maximum(ratio, 1e-12))
        kept = Evidence(weights[:, None, None] * self.blocks, weights[:, None] * self.pulls)
        information = kept.blocks.sum(axis=0)
        expected, scatter = kept._overlapping()._scatter(np.linalg.inv(information + background))
        taught = float(expected.sum())
        excess = float(scatter.sum()) / taught * n / max(n - taught, 1.0) if taught > 0 else 1.0
        return information, kept.pulls.sum(axis=0), max(1.0, excess)

    def _overlapping(self) -> Evidence:
        """Of neighbours together: what is left of a jolt between them has one sign before it, and the other after."""
        return Evidence((self.blocks[1:] + self.blocks[:-1]) / 2, (self.pulls[1:] + self.pulls[:-1]) / 2**0.5)

    def _scatter(self, metric: Array) -> tuple[Array, Array]:
        """Of each stretch, what is expected and what is there."""
        expected = np.einsum("ij,bji->b", metric, self.blocks)
        return expected, np.einsum("bi,ij,bj->b", self.pulls, metric, self.pulls)


class WrenchRegression:
    """A log, its motion smoothed once."""

    def __init__(self, log: RunLog, cart: CartModel, noise: FilterNoise | None) -> None:
        thinned = aligned(log, cart).thinned()
        self.cart, self.name = cart, log.name
        if noise is None:
            noise = noise_of_log(thinned, cart) if len(thinned) >= FEWEST_ROWS else FilterNoise()
        try:
            with np.errstate(over="raise", invalid="raise", divide="raise"):
                self._record = WrenchRecord.of(thinned, cart, noise)
                self.motion = smooth_motion(thinned, cart, noise)
        except (FloatingPointError, np.linalg.LinAlgError) as error:
            raise _too_large(log.name) from error
        steps = np.diff(thinned.time)
        steady = self.motion.linked & (steps < LONGEST_STEP * np.median(steps)) if len(steps) else self.motion.linked
        self._used = np.append(steady, False) & self._record.seen

    def evidence(self, parameters: Array, delay: float) -> Evidence:
        """What the log says about a step of `(parameters, delay)` from here."""
        used = np.flatnonzero(self._used)
        p = len(parameters) + 1
        if not len(used):
            return Evidence(np.zeros((0, p, p)), np.zeros((0, p)))
        try:
            with np.errstate(over="raise", invalid="raise"):
                return self._evidence(parameters, delay, used)
        except (FloatingPointError, np.linalg.LinAlgError) as error:
            raise _too_large(self.name) from error

    def _evidence(self, parameters: Array, delay: float, used: np.ndarray) -> Evidence:
        motion, cart = self.motion, self.cart
        n, d = motion.state.shape
        state = np.hstack([motion.pose, motion.velocity, self._memory(parameters)])
        inverse = cart.inverse(state, motion.acceleration, parameters, motion.time)
        by_node = np.concatenate(
            [inverse.by_state[..., : 3 + motion.velocity.shape[1]], inverse.by_acceleration], axis=2
        )
        recorded, recorded_by = self._record.reduced(cart, parameters)
        after = used + 1
        residual = recorded[used] - (1 - delay) * inverse.wrench[used] - delay * inverse.wrench[after]
        late = inverse.wrench[after] - inverse.wrench[used]
        by = (1 - delay) * inverse.by_parameters[used] + delay * inverse.by_parameters[after] - recorded_by[used]
        by = np.concatenate([by, late[..., None]], axis=2)
        weights = np.linalg.inv(self._record.covariance[used] + self._stuck(state, parameters)[used])

        f = recorded.shape[1]
        first, second = np.zeros((n - 1, f, d)), np.zeros((n - 1, f, d))
        first[used], second[used] = (1 - delay) * by_node[used], delay * by_node[after]
        all_weights = np.zeros((n - 1, f, f))
        all_weights[used] = weights
        joint = motion.information + BlockTridiagonal.of_pairs(first, second, all_weights)
        factor = joint.factor()

        sides = np.concatenate([by, residual[..., None]], axis=2)
        weighted = weights @ sides
        through = np.zeros((n, d, sides.shape[2]))
        np.add.at(through, used, np.swapaxes(first[used], 1, 2) @ weighted)
        np.add.at(through, after, np.swapaxes(second[used], 1, 2) @ weighted)
        missed = factor.solve(through)
        weighted = weighted - weights @ (first[used] @ missed[used] + second[used] @ missed[after])
        found = _by_block(motion.time[used], np.swapaxes(by, 1, 2) @ weighted)
        information = (found[..., :-1] + np.swapaxes(found[..., :-1], 1, 2)) / 2
        return Evidence(information, found[..., -1])

    def _memory(self, parameters: Array) -> Array:
        """Of the effects, run along the smoothed motion."""
        cart, motion = self.cart, self.motion
        memory = np.tile(cart.state()[cart.memory_slice], (len(motion.time), 1))
        if not memory.shape[1]:
            return memory
        state = cart.state(motion.pose[0], motion.velocity[0])
        for i, step in enumerate(np.diff(motion.time)):
            memory[i] = state[cart.memory_slice]
            rate = cart.inverse(state, motion.acceleration[i], parameters, motion.time[i])
            faster = motion.velocity[i + 1] - motion.velocity[i]
            by_memory = rate.memory_rate_by_state[:, cart.memory_slice]
            change = rate.memory_rate + rate.memory_rate_by_state[:, cart.velocity_slice] @ faster / 2
            coupled = (by_memory - np.diag(np.diagonal(by_memory))).any(axis=1)
            moved = memory[i] + np.where(
                coupled, _swung(change, by_memory, step), _faded(rate.memory_rate, np.diagonal(by_memory), step)
            )
            state = np.concatenate([motion.pose[i + 1], motion.velocity[i + 1], moved])
        memory[-1] = state[cart.memory_slice]
        return memory

    def _stuck(self, state: Array, parameters: Array) -> Array:
        """Covariance (n, f, f) of Coulomb forces where the cart may stand still, for all that its smoothed velocity
        tells: they take whatever value holds things, and keep it for a while."""
        slow = state.copy()
        nu = state[:, self.cart.velocity_slice]
        slow[:, self.cart.velocity_slice] = np.sign(nu) * np.maximum(np.abs(nu) - STILL * self.motion.velocity_std, 0.0)
        forces = self.cart.basis_b.T @ self.cart.stiction(slow, parameters, self.motion.time)
        samples = max(1.0, BLOCK / float(np.median(np.diff(self.motion.time))))
        return np.asarray(samples * forces @ np.swapaxes(forces, 1, 2))


def _faded(rate: Array, growth: Array, step: float) -> Array:
    """What memories (k,) change by in a step, each with its own `growth`: they may be stiff."""
    gain = np.expm1(np.minimum(growth * step, 1.0)) / np.where(growth == 0, 1.0, growth)
    return np.asarray(np.where(np.abs(growth * step) > 1e-9, gain, step) * rate)


def _swung(rate: Array, by_memory: Array, step: float) -> Array:
    """The same for those that drive one another, from the rate in the middle of the step: what swings loses nothing."""
    return np.asarray(step * np.linalg.solve(np.eye(len(rate)) - step / 2 * by_memory, rate))


def _by_block(time: Array, parts: Array) -> Array:
    """Sums over stretches of `BLOCK` seconds."""
    _, where = np.unique((time - time[0]) // BLOCK, return_inverse=True)
    sums = np.zeros((where.max() + 1, *parts.shape[1:]))
    np.add.at(sums, where, parts)
    return sums


def _too_large(name: str) -> DataError:
    return DataError(f"{name}: can't be identified from; look for numbers that are not in SI units")
