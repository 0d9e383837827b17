"""What may be tried in a window to learn: contacts of all arms, and small deviations; and what each costs at least.

The family is finite: every choice of the arms' points, and every pair of a wave along and a wave across from a short
list of swings and amplitudes. Everything here is computed for the whole family at once.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from cartgrasp.arms import Arm
from cartgrasp.errors import UsageError
from cartgrasp.frames import Array
from cartgrasp.information import WrenchNoise
from cartgrasp.model import CartModel
from cartgrasp.roles import ReferencePath

from ..allocation.allocation_template import AllocationTemplate
from ..contacts.contact_regions import DISTANCE_TOLERANCE, hand_distance
from ..schedule.stage_efforts import candidate_points
from .deviation import Deviation, Wave, deviated, steady_part

WINDOW_SAMPLE_INTERVAL = 0.1  # s, of the samples at which a window is judged
MIN_WEAVE_SPEED = 0.1  # m/s: a slower cart is not made to weave
MIN_WEAVE_DURATION = 0.8  # s: there is no time to weave in less
AMPLITUDE_FRACTIONS = (1.0, 0.5, 0.25, 0.125)
SWING_COUNTS = (0, 1, 2)
MIN_WRENCH_STD = 1e-3
"""N and N·m: sensors are not taken to be better."""


@dataclass(frozen=True, eq=False)
class Motions:
    """M ways to drive through a window (the first is the reference's own), at T samples: the regressors (M, T, k, p)
    and the reduced wrenches (M, T, k) that they need."""

    deviations: tuple[Deviation | None, ...]
    regressors: Array
    needed: Array

    @property
    def samples(self) -> int:
        return int(self.needed.shape[1])


def motions(reference: ReferencePath, cart: CartModel, window: tuple[float, float], offset: float) -> Motions:
    """The reference in a window, and its deviations by at most `offset` (m) along and across."""
    start, stop = window
    n = max(1, round((stop - start) / WINDOW_SAMPLE_INTERVAL))
    times = start + (np.arange(n) + 0.5) * (stop - start) / n
    references = [reference.at(time) for time in times]
    poses, velocity, acceleration = (
        np.array([getattr(r, name) for r in references]) for name in ("pose_sb", "velocity", "acceleration")
    )
    choices: list[Deviation | None] = [None, *_deviations(reference, cart, window, offset)]
    velocities, accelerations = np.tile(velocity, (len(choices), 1, 1)), np.tile(acceleration, (len(choices), 1, 1))
    headings = np.tile(poses[:, 2], (len(choices), 1))
    if len(choices) > 1:
        offsets = np.array([choice.offsets(times) for choice in choices if choice is not None])
        turned, velocities[1:], accelerations[1:] = deviated(velocity, acceleration, offsets)
        headings[1:] += turned
    state = np.tile(cart.state(), (len(choices), n, 1))
    state[..., :2], state[..., 2], state[..., cart.velocity_slice] = poses[:, :2], headings, velocities
    if cart.memory_names:  # which has settled to the motion with which the window begins
        settled = cart.settled_memory(state[:, 0], cart.parameters, times[0])
        for way, first in zip(state, settled, strict=True):
            way[:, cart.memory_slice] = cart.memory_along(way[:, :3], way[:, cart.velocity_slice], times, first=first)
    needed, regressors = cart.inverse_by_parameters(state, accelerations, time=times)
    keeps_on = (velocities[..., 0] * velocity[:, 0] >= 0).all(axis=1)
    kept = tuple(choice for choice, fine in zip(choices, keeps_on, strict=True) if fine)
    return Motions(kept, regressors[keeps_on], needed[keeps_on])


def as_sensed(noise: WrenchNoise) -> WrenchNoise:
    """The noise, at least that of the best sensors: exact wrenches would teach everything at once."""
    return WrenchNoise(max(noise.force, MIN_WRENCH_STD), max(noise.moment, MIN_WRENCH_STD), noise.rate)


def contact_choices(arms: Sequence[Arm], min_hand_distance: float) -> Array:
    """Every choice (J, n, 3) of the arms' points that keeps the hands apart."""
    choices = np.array(list(product(*candidate_points(arms).values())))
    choices = choices[hand_distance(choices) >= min_hand_distance - DISTANCE_TOLERANCE]
    if not len(choices):
        raise UsageError(f"min_hand_distance: no choice of points keeps the hands {min_hand_distance:g} m apart")
    return np.asarray(choices)


@dataclass(frozen=True, eq=False)
class FreeSplit:
    """The split of a reduced wrench over arms at contacts (J, n, 3) that holds no internal force: of all wrenches with
    that effect, the one of least effort when no limit binds, `F = W⁻¹ Aᵀ (A W⁻¹ Aᵀ)⁻¹ w` with A = Sᵀ [G_1 … G_n]."""

    matrix: Array
    weights: Array

    @classmethod
    def of(cls, template: AllocationTemplate, choices: Array) -> FreeSplit:
        weights = template.effort_weights
        if not (weights > 0).all():
            raise UsageError("excitation: an arm has a weight of 0, so the split without internal force is not unique")
        rows = template.contact_rows(choices)
        return cls(np.moveaxis(rows, 1, 2).reshape(len(rows), rows.shape[2], -1), weights)

    def efforts(self, needed: Array) -> Array:
        """Mean over samples (M, J) of the effort of reduced wrenches (M, T, k); limits can only add to it."""
        gram = np.linalg.inv((self.matrix / self.weights) @ np.swapaxes(self.matrix, -1, -2))
        return np.asarray(np.einsum("mti,jik,mtk->mj", needed, gram, needed) / needed.shape[1])

    def wrenches(self, choice: int, needed: Array) -> Array:
        """(T, 6n) of reduced wrenches (T, k)."""
        matrix = self.matrix[choice]
        spread = (matrix / self.weights).T @ np.linalg.inv((matrix / self.weights) @ matrix.T)
        return np.asarray(needed @ spread.T)


def _deviations(
    reference: ReferencePath, cart: CartModel, window: tuple[float, float], offset: float
) -> list[Deviation]:
    """In the window's longest steady part, where there is one in which the cart drives long and fast enough."""
    if offset <= 0 or cart.constraints.n_rows != 1:
        return []
    start, stop = steady_part(reference, *window)
    slowest = min(abs(reference.at(time).velocity[0]) for time in (start, (start + stop) / 2, stop))
    if stop - start < MIN_WEAVE_DURATION or slowest < MIN_WEAVE_SPEED:
        return []
    sizes = [offset * share for share in AMPLITUDE_FRACTIONS]
    along = [Wave(), *(Wave(sign * size, swings) for size in sizes for swings in SWING_COUNTS[:2] for sign in (1, -1))]
    across = [Wave(), *(Wave(sign * size, swings) for size in sizes for swings in SWING_COUNTS for sign in (1, -1))]
    return [Deviation(start, stop - start, *pair) for pair in list(product(along, across))[1:]]
