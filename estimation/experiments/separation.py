"""How many standard deviations apart a motion puts two beliefs of a cart (Box and Hill, 1967; Atkinson and Fedorov,
1975).

With d (n,) what two beliefs expect otherwise of the recorded rows, over their noise, J the slopes of what the second
expects by the cart's parameters, and P their covariance after the logs so far, were the first one true:

    z² = dᵀ (I + J P Jᵀ)⁻¹ d.

By so much the second belief's fit of old rows and new gets worse (twice the log of the likelihood). Sums over the parts
of a motion give it: with A = J P^½,  z² = dᵀd - (Aᵀd)ᵀ (I + AᵀA)⁻¹ Aᵀd.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import block_diag

from cartgrasp.contacts import grasp_map_planar
from cartgrasp.frames import Array
from cartgrasp.information import WrenchNoise, reduced_noise
from cartgrasp.model import CartModel
from cartgrasp.rigid_body import regressor_b

from .manoeuvres import MANOEUVRE_TIME_STEP, Piece, Place, path, sampled

DELAY_PARAMETER_STEP = 1e-4
"""The step in a sensor effect's parameter for finite differences of its lateness."""
MIN_SIMULATED_WRENCH_NOISE, MIN_SIMULATED_POSE_NOISE = 1e-2, 1e-5
"""N and N·m; m: simulated sensors may have no noise at all."""
LATERAL_SPEED_WINDOW = 0.5
"""s: over which poses tell the speed across the wheels."""


@dataclass(frozen=True, eq=False)
class Belief:
    """A cart fitted to the logs so far, and a root (p, n) of the covariance of its parameters."""

    cart: CartModel
    root: Array


@dataclass(frozen=True, eq=False)
class Hands:
    """Where each arm holds, (3,) in {b}; how noisy its sensor and the poses (m) are; the share of the wrench by which
    any model is wrong, otherwise in each piece."""

    contacts: Mapping[str, Array]
    noise: WrenchNoise
    position: float = 5e-4
    form: float = 0.0

    def shared(self, cart: CartModel, reduced: Array) -> dict[str, Array]:
        """Wrenches (n, 6) of the arms, the least that give a reduced one (n, f)."""
        maps = [cart.basis_b.T @ grasp_map_planar(contact) for contact in self.contacts.values()]
        whole = reduced @ np.linalg.pinv(np.hstack(maps)).T
        return dict(zip(self.contacts, np.split(whole, len(maps), axis=-1), strict=True))

    def weights(self, cart: CartModel) -> Array:
        """What rows (f, or f + 1 with the speed across the wheels) are multiplied by, (c, c)."""
        noise = replace(
            self.noise, **{k: max(getattr(self.noise, k), MIN_SIMULATED_WRENCH_NOISE) for k in ("force", "moment")}
        )
        root = np.linalg.cholesky(np.linalg.inv(reduced_noise(cart, list(self.contacts.values()), noise))).T
        across = LATERAL_SPEED_WINDOW / (
            np.sqrt(2.0 * noise.rate * LATERAL_SPEED_WINDOW) * max(self.position, MIN_SIMULATED_POSE_NOISE)
        )
        weights = block_diag(root, across) if _is_seen_across(cart) else root
        return np.asarray((self.noise.rate * MANOEUVRE_TIME_STEP) ** 0.5 * weights)


@dataclass(frozen=True, eq=False)
class Trace:
    """What a belief expects of a piece: rows (n,) over their noise, their slopes by the root's directions (n, k), what
    a model is wrong by (n,), and where the cart then rests."""

    rows: Array
    slopes: Array
    form: Array
    end: Place


@dataclass(frozen=True, eq=False)
class Evidence:
    """The sums of the head of this file."""

    square: float
    mixed: Array
    slopes: Array

    @classmethod
    def none(cls, rival: Belief) -> Evidence:
        k = rival.root.shape[1]
        return cls(0.0, np.zeros(k), np.zeros((k, k)))

    def more(self, truth: Trace, rival: Trace) -> Evidence:
        """The sums with another piece added."""
        size = float(np.linalg.norm(truth.form))
        unit = truth.form / size if size else truth.form
        shrink = 1.0 - 1.0 / math.sqrt(1.0 + size * size)  # rows whose noise has the form's in it, whitened
        d, slopes = truth.rows - rival.rows, rival.slopes
        d, slopes = d - shrink * unit * (unit @ d), slopes - shrink * np.outer(unit, unit @ slopes)
        return Evidence(self.square + float(d @ d), self.mixed + slopes.T @ d, self.slopes + slopes.T @ slopes)

    @property
    def deviations(self) -> float:
        known = np.eye(len(self.mixed)) + self.slopes
        return math.sqrt(max(self.square - float(self.mixed @ np.linalg.solve(known, self.mixed)), 0.0))


def traced(belief: Belief, piece: Piece, begin: Place, hands: Hands, weights: Array) -> Trace:
    """What a belief expects that sensors record: the reduced wrench that is required, less what recorded wrenches that
    are as large stand for beside themselves, and the speed across the wheels."""
    cart = belief.cart
    since, velocity_b, rates_b = sampled(piece)
    nu, nu_rate = (cart.constraints.free_velocity(part) for part in (velocity_b, rates_b))
    pose, end = path(nu @ cart.basis_b.T, begin.pose)
    time = begin.time + since
    memory = cart.memory_along(pose, nu, time, first=begin.memory)
    state = np.hstack([pose, nu, memory])
    wrench, by_parameters = cart.inverse_by_parameters(state, nu_rate, time=time)
    late = np.gradient(wrench, MANOEUVRE_TIME_STEP, axis=0)
    value = wrench - late * np.mean([cart.lateness(arm) for arm in hands.contacts])
    slopes = by_parameters - late[..., None] * _lateness_slopes(cart, hands.contacts)
    for arm, recorded in hands.shared(cart, wrench).items():
        reduced = cart.basis_b.T @ grasp_map_planar(hands.contacts[arm])
        hand = cart.hand_motion(nu, nu_rate, np.asarray(hands.contacts[arm]))
        true, by = cart.corrected_wrench(arm, recorded, hand=hand)
        value -= (true - recorded) @ reduced.T
        slopes -= reduced @ by
    if _is_seen_across(cart):
        value = np.column_stack([value, _across(cart, nu, nu_rate)])
        slopes = np.concatenate([slopes, np.zeros((len(value), 1, slopes.shape[2]))], axis=1)
    rows, by_root = (value @ weights.T).ravel(), (weights @ slopes @ belief.root).reshape(value.size, -1)
    return Trace(rows, by_root, hands.form * rows, Place(end, memory[-1], begin.time + piece.duration))


def _is_seen_across(cart: CartModel) -> bool:
    return cart.constraints.n_rows == 1


def _across(cart: CartModel, nu: Array, nu_rate: Array) -> Array:
    """The speed (n,) of the axle across {b}: by the wheels' angle, and by their creep under the side force of the
    body."""
    phi, across = cart.inertia.phi, np.append(cart.rolling.across_b, 0.0)
    side = regressor_b(nu @ cart.basis_b.T, nu_rate @ cart.basis_b.T) @ phi @ across
    return np.asarray(np.sin(cart.rolling.angle) * nu[:, 0] - cart.slip_compliance * np.abs(nu[:, 0]) * side)


def _lateness_slopes(cart: CartModel, arms: Collection[str]) -> Array:
    """Partials (p,) of the arms' mean lateness by the cart's parameters."""
    slopes = np.zeros(len(cart.parameters))
    for effect, where in cart.sensor_effects:
        share = np.mean([effect.concerns(arm) for arm in arms])
        moved = (effect.with_values(effect.values + step) for step in DELAY_PARAMETER_STEP * np.eye(len(effect.values)))
        slopes[where] = [share * (one.lateness - effect.lateness) / DELAY_PARAMETER_STEP for one in moved]
    return slopes
