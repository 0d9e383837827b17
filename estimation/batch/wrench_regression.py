"""One log's information about the parameters: its wrenches regressed on its smoothed motion.

`z = w(pose, nu, memory, nu'; theta) + noise` holds at the smoothed motion with the noise `n + J e`, where e is what the
smoother missed. Generalised least squares with the covariance `R + J Σ Jᵀ` is what is left of the chain
`|e|² in Σ⁻¹ + |z - w - J e|² in R⁻¹` when e is taken out, and Σ⁻¹ is block tridiagonal. J is of the smoothed motion:
moved along with e, the regressors would take in the wrenches' noise.

A wrench may hold from its row to the next (its middle is half a step late), or be one sample: w is taken a share
`delay` of the step after its row, and that share is estimated too, as parameter p + 1. J stays at the usual share: a
delay that made more noise likely would look good.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from contextlib import contextmanager
from copy import copy
from dataclasses import replace
from functools import cached_property

import numpy as np

from cartgrasp.errors import DataError
from cartgrasp.frames import Array
from cartgrasp.logs import RunLog
from cartgrasp.logs.alignment import aligned
from cartgrasp.model import CartModel, InverseDynamics

from ..log_noise import noise_of_log
from ..noise import FilterNoise
from .block_tridiagonal import Factor
from .linearisation import Evidence, Linearisation
from .motion_smoother import smooth_motion
from .noise_colour import NoiseColour, with_noise_states
from .smooth_motion import SmoothMotion
from .wrench_record import WrenchRecord

BLOCK = 0.5
"""s: what is left of a right model is uncorrelated over longer times."""
FEWEST_ROWS = 50
"""Of a log that tells its own noise."""
DELAY, DELAY_STD = 0.25, 0.3
"""Steps: a sampled wrench has 0, a held one 0.5."""
STILL = 3.0
"""Standard deviations of the smoothed velocity within which a cart may stand still."""
LONGEST_STEP = 3.0
"""Times the usual step: over a longer one nobody knows what a wrench did."""
LATENESS_STEP = 1e-4
"""s."""
AVERAGED = ("position", "heading", "linear_velocity", "yaw_rate", "force", "moment")


class WrenchRegression:
    """A log, its motion smoothed once; looked at in pairs of rows, where that is asked for."""

    def __init__(self, log: RunLog, cart: CartModel, noise: FilterNoise | None, pairs: bool = False) -> None:
        thinned = log.thinned()
        self.cart, self.name, self.log, self.size = cart, log.name, log, 2 if pairs else 1
        if noise is None:
            noise = noise_of_log(thinned, cart) if len(thinned) >= FEWEST_ROWS else FilterNoise()
        self.noise = noise
        self.colour: NoiseColour | None = None
        self._is_wary = False
        self._loudness = np.ones((cart.constraints.n_free, cart.constraints.n_free))
        with self._sized():
            self._chain = smooth_motion(thinned, cart, noise)
            self.motion = self._chain.paired() if pairs else self._chain
            steps = np.diff(self.motion.time)
            steady = (
                self.motion.linked & (steps < LONGEST_STEP * np.median(steps)) if len(steps) else self.motion.linked
            )
            self._steady = np.append(steady, False)
            self._listen()

    @cached_property
    def rows(self) -> RunLog:
        """The log, as it is looked at."""
        return self._looked_at(self.log)

    def _looked_at(self, log: RunLog) -> RunLog:
        return log.thinned().paired() if self.size > 1 else log.thinned()

    @cached_property
    def row_noise(self) -> FilterNoise:
        """Of these rows."""
        mean = {name: getattr(self.noise, name) / self.size**0.5 for name in AVERAGED}
        return replace(self.noise, **mean)

    @property
    def usual_delay(self) -> tuple[float, float]:
        """By what share of a step wrenches are late, and the standard deviation of it. Aligned by whole samples, those
        of late sensors are so by what is left of the lateness."""
        late = float(np.mean([self.cart.lateness(arm) for arm in self.log.arms])) / self.step
        return (DELAY + np.ceil(late - 0.5) - late) / self.size, DELAY_STD / self.size

    @property
    def step(self) -> float:
        """Between rows of the log, s."""
        steps = np.diff(self.motion.time)
        return float(np.median(steps)) / self.size if len(steps) else np.inf

    def _listen(self) -> None:
        """Takes the wrenches as the cart's sensors are late."""
        rows = self._looked_at(aligned(self.log, self.cart))
        steps = np.diff(rows.time)
        record = WrenchRecord.of(rows, self.cart, self.row_noise)
        self._record = replace(record, covariance=record.covariance * self._loudness)
        self._neighbours = self._record.of_neighbours(float(np.median(steps)) if len(steps) else 1.0)
        self._know()

    def _know(self) -> None:
        """Puts together what is known before any wrench, of the motion and of slow noise."""
        self._known, chain = self.motion.information, self._chain
        if self.colour is not None and self.colour.remembers:
            usual = np.mean(self._record.covariance[self._record.seen], axis=0)
            self._known = with_noise_states(self._known, chain.linked, np.diff(chain.time), usual, self.colour)

    @property
    def _used(self) -> np.ndarray:
        return np.asarray(self._steady & self._record.seen)

    @contextmanager
    def _sized(self) -> Iterator[None]:
        """Numbers that are too large for arithmetic become an error of ours."""
        try:
            with np.errstate(over="raise", invalid="raise", divide="raise"):
                yield
        except (FloatingPointError, np.linalg.LinAlgError) as error:
            raise DataError(
                f"{self.name}: can't be identified from; look for numbers that are not in SI units"
            ) from error

    def evidence(self, parameters: Array, delay: float) -> Evidence:
        """What the log says about a step of `(parameters, delay)` from here."""
        used = np.flatnonzero(self._used)
        p = len(parameters) + 1
        if not len(used):
            return Evidence(*(np.zeros((0, p, p)), np.zeros((0, p))) * 2)
        with self._sized():
            return self._evidence(parameters, delay, used)

    def _evidence(self, parameters: Array, delay: float, used: np.ndarray) -> Evidence:
        line, noisier = self.linearised(parameters, delay, used), self.motion.noisier
        residual, by = self._residual(parameters, delay, used, self._inverse(self.cart, parameters, noisier)[1])
        off, off_by, p = (line.residual - residual)[..., None], by - line.by, by.shape[2]
        off_by[..., -1] = 0.0
        white = line.whitened(np.concatenate([line.by, line.residual[..., None], off_by, off], axis=2))
        found = line.by_block(line.by, white[..., : p + 1], BLOCK)
        lost = line.by_block(off_by, white[..., p + 1 :], BLOCK)
        blocks, noise = ((each[..., :p] + np.swapaxes(each[..., :p], 1, 2)) / 2 for each in (found, lost))
        return Evidence(blocks, found[..., p], noise, lost[..., p])

    def linearised(self, parameters: Array, delay: float, used: np.ndarray | None = None) -> Linearisation:
        """Around parameters (p,) and a delay, on rows `used` (all that can be, unless given)."""
        motion, cart = self.motion, self.cart
        used = np.flatnonzero(self._used) if used is None else used
        state, inverse = self._inverse(cart, parameters)
        by_node = np.concatenate(
            [inverse.by_state[..., : 3 + motion.velocity.shape[1]], inverse.by_acceleration], axis=2
        )
        residual, by = self._residual(parameters, delay, used, inverse)
        white = 1.0 if self.colour is None else self.colour.white
        covariance = white * self._record.covariance[used] + self._stuck(state, parameters)[used]
        if self._is_wary:
            covariance += self._record.rounded[used, :, None] ** 2 * np.eye(residual.shape[1])
        weights = np.linalg.inv(covariance)

        slopes = (1 - DELAY) * by_node[used], DELAY * by_node[used + 1]
        if self.size > 1:
            slopes = by_node[used] / 2, by_node[used] / 2
        by_motion, factor = self._joint(self.size * used, slopes, weights)
        return Linearisation(motion.time[used], self.size * used, residual, by, weights, by_motion, factor)

    def _residual(
        self, parameters: Array, delay: float, used: np.ndarray, inverse: InverseDynamics
    ) -> tuple[Array, Array]:
        """Of rows `used` (m,), (m, f), and its slopes (m, f, p + 1), from what the motion needs."""
        believed, after = self.cart.with_parameters(parameters), used + 1
        expected = _delayed(inverse.wrench, delay)
        recorded_by = self._neighbours.slopes(believed, expected)
        residual = self._record.reduced(believed)[used] - expected[used]
        late = inverse.wrench[after] - inverse.wrench[used]
        by = (1 - delay) * inverse.by_parameters[used] + delay * inverse.by_parameters[after] - recorded_by[used]
        return residual, np.concatenate([by, late[..., None]], axis=2)

    def _joint(
        self, nodes: np.ndarray, slopes: tuple[Array, Array], weights: Array
    ) -> tuple[tuple[Array, Array], Factor]:
        """Slopes by the states of the chain from `nodes` (m,) to the next, slow noise among them, and the factor of
        what wrenches and smoother know of these states."""
        f = weights.shape[1]
        beside = self.motion.information.diagonal.shape[1] - slopes[0].shape[2]
        if beside:
            nothing = np.zeros((len(nodes), f, beside))
            slopes = np.concatenate([slopes[0], nothing], axis=2), np.concatenate([slopes[1], nothing], axis=2)
        if self.colour is not None and self.colour.remembers:
            shares = (0.5, 0.5) if self.size > 1 else (1.0, 0.0)
            by_noise = (np.broadcast_to(share * np.eye(f), (len(nodes), f, f)) for share in shares)
            first, second = (np.concatenate(both, axis=2) for both in zip(slopes, by_noise, strict=True))
            slopes = first, second
        return slopes, self._known.with_pairs(nodes, *slopes, weights).factor()

    @property
    def usable(self) -> np.ndarray:
        """Rows (n - 1,) whose wrench holds until the next."""
        return np.asarray(self._used[:-1])

    @property
    def wrench_covariance(self) -> Array:
        """Of the reduced wrench's noise, (n, f, f)."""
        return self._record.covariance

    def reduced(self, cart: CartModel) -> Array:
        """The recorded wrench, corrected, along the free directions (n, f)."""
        return self._record.reduced(cart)

    def with_cart(self, cart: CartModel) -> WrenchRegression:
        """The same motion, for a cart with other effects and the same constraints."""
        other = copy(self)
        other.cart = cart
        if any(cart.lateness(arm) != self.cart.lateness(arm) for arm in self.log.arms):
            other._listen()
        return other

    def coloured(self, colour: NoiseColour | None) -> WrenchRegression:
        """The same, with wrench noise of another colour."""
        other = copy(self)
        other.colour = colour
        other._know()
        return other

    def wary(self) -> WrenchRegression:
        """The same, with less weight where wrenches jump: the smoothed motion rounds corners."""
        other = copy(self)
        other._is_wary = True
        return other

    def louder(self, factor: Array) -> WrenchRegression:
        """The same, with so many times the noise variance along each free direction (f,)."""
        other = copy(self)
        other._loudness = self._loudness * np.sqrt(np.outer(factor, factor))
        other._listen()
        return other

    def within(self, chosen: np.ndarray) -> WrenchRegression:
        """The same motion, with wrenches only where `chosen` (n,)."""
        other = copy(self)
        other._steady = self._steady & chosen
        return other

    def force_slopes(self, cart: CartModel, delay: float) -> Array:
        """Slopes (m, f, p) as in `linearised`, by the parameters of a cart that adds to this one, but for what they
        change at the sensors."""
        used, by = np.flatnonzero(self._used), self._inverse(cart, cart.parameters)[1].by_parameters
        return np.asarray((1 - delay) * by[used] + delay * by[used + 1])

    def bends(self) -> Array:
        """Second differences (m, f) of the wrench that the motion needs, on the rows of `linearised`: what a motion
        smoothed a little more or less would add."""
        return self._wrench_differences(2)

    def skews(self) -> Array:
        """Third differences: with the second ones, what a wrench taken between two rows lacks of one taken later."""
        return self._wrench_differences(3)

    def _wrench_differences(self, order: int) -> Array:
        wrench = self._inverse(self.cart, self.cart.parameters)[1].wrench
        found = np.zeros_like(wrench)
        found[1:-1] = np.diff(wrench, 2, axis=0)
        if order > 2:
            found = np.gradient(found, axis=0)
        return np.asarray(found[self._used])

    def sensor_slopes(self, cart: CartModel, delay: float) -> Array:
        """What `force_slopes` leaves out."""
        expected = _delayed(self._inverse(self.cart, self.cart.parameters)[1].wrench, delay)
        late = np.gradient(expected, self.motion.time, axis=0)[..., None] * lateness_slopes(cart, self.log.arms)
        return np.asarray(-(self._neighbours.slopes(cart, expected) + late)[self._used])

    def _inverse(
        self, cart: CartModel, parameters: Array, motion: SmoothMotion | None = None
    ) -> tuple[Array, InverseDynamics]:
        """States (n, ...) of a cart along the motion, or another one, and the inverse dynamics there."""
        motion = motion or self.motion
        memory = cart.memory_along(motion.pose, motion.velocity, motion.time, parameters)
        state = np.hstack([motion.pose, motion.velocity, memory])
        return state, cart.inverse(state, motion.acceleration, parameters, motion.time)

    def _stuck(self, state: Array, parameters: Array) -> Array:
        """Covariance (n, f, f) of Coulomb forces where the cart may stand still, for all that its smoothed velocity
        tells: they take whatever value holds things, and keep it for a while."""
        slow = state.copy()
        nu = state[:, self.cart.velocity_slice]
        slow[:, self.cart.velocity_slice] = np.sign(nu) * np.maximum(np.abs(nu) - STILL * self.motion.velocity_std, 0.0)
        forces = self.cart.basis_b.T @ self.cart.stiction(slow, parameters, self.motion.time)
        return np.asarray(forces @ np.swapaxes(forces, 1, 2) / min(BLOCK, self.step * self.size))


def _delayed(wrench: Array, delay: float) -> Array:
    """Wrenches (n, f) a share of a step after their rows."""
    found = wrench.copy()
    found[:-1] += delay * np.diff(wrench, axis=0)
    return found


def lateness_slopes(cart: CartModel, arms: Collection[str]) -> Array:
    """Of the mean lateness of arms by the parameters (p,)."""
    slopes = np.zeros(len(cart.parameters))
    for effect, where in cart.sensor_effects:
        share = np.mean([effect.concerns(arm) for arm in arms])
        for i, at in enumerate(range(where.start, where.stop)):
            more = effect.values + LATENESS_STEP * (np.arange(len(effect.values)) == i)
            slopes[at] = share * (effect.with_values(more).lateness - effect.lateness) / LATENESS_STEP
    return slopes
