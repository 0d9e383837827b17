"""The manoeuvre that would tell effects apart that look alike on a log.

On each of some motions, without noise: what one effect does to the recorded wrenches, and how much of that neither the
other effect, at any size, nor other parameters of the cart could do.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from cartgrasp.contacts import grasp_map_planar
from cartgrasp.effects import Effect
from cartgrasp.effects.effect import Gate
from cartgrasp.frames import Array
from cartgrasp.information import WrenchNoise, reduced_noise
from cartgrasp.model import CartModel

from ..teaching_motions import DURATION, PERIOD, SPEED, TeachingMotion, teaching_motions
from .candidates import amplitudes_of, families, is_of_motion
from .isolability import SHOWN

ENOUGH = 0.7
"""Of the best motion's deviations: a simpler one with so many is told."""
FAST = np.array([0.2, 0.6, 1.2])
"""m/s."""
RIDGE = 1e-12
LATENESS_STEP = 1e-4
"""Of a parameter of a sensor effect."""


@dataclass(frozen=True)
class Manoeuvre:
    """What to do, and by how many deviations an effect and the others differ then, at least."""

    says: str
    deviations: float


@dataclass(frozen=True)
class Hands:
    """Where each arm holds, (3,) in {b}, and how noisy its sensor is."""

    contacts: Mapping[str, Array]
    noise: WrenchNoise

    def shared(self, cart: CartModel, reduced: Array) -> dict[str, Array]:
        """Wrenches (n, 6) of the arms, the least that give a reduced one (n, f)."""
        maps = [cart.basis_b.T @ grasp_map_planar(contact) for contact in self.contacts.values()]
        whole = reduced @ np.linalg.pinv(np.hstack(maps)).T
        return dict(zip(self.contacts, np.split(whole, len(maps), axis=-1), strict=True))


def separating(cart: CartModel, key: str, others: Sequence[str], hands: Hands) -> Manoeuvre | None:
    """For an effect of the cart, by its key, and the names of others; None where no usual motion would do, or one of
    them acts at a time, at a place, or on the speed across the wheels."""
    added = next(effect for effect in cart.effects if effect.key == key)
    without = replace(cart, effects=tuple(effect for effect in cart.effects if effect.key != key))
    rivals = [rivals_named(name, without, hands) for name in others]
    if not rivals or not all(rivals) or added.gate is not Gate.ALWAYS or is_of_motion(type(added)):
        return None
    every = [one for group in rivals for one in group]
    known = [(motion, _apart(motion, without, added, every, hands)) for motion in _motions(cart)]
    most = max(deviations for _, deviations in known)
    if most < SHOWN:
        return None
    least = max(ENOUGH * most, SHOWN)
    return next(Manoeuvre(motion.says, deviations) for motion, deviations in known if deviations >= least)


def rivals_named(name: str, cart: CartModel, hands: Hands) -> list[Effect]:
    """All variants of an effect that acts all the time, and on forces."""
    every = (effect for family in families(cart, list(hands.contacts)) for effect in family.variants)
    return [one for one in every if one.name == name and one.gate is Gate.ALWAYS and not is_of_motion(type(one))]


def _motions(cart: CartModel) -> list[TeachingMotion]:
    """That a cart can follow, from the simplest on: those that teach parameters, and some along two headings and at two
    speeds."""
    time = np.arange(0.0, DURATION, PERIOD)
    wave, zero = np.sin(2 * np.pi * time / 3.0), np.zeros_like(time)
    half = np.where((time > 5.0) & (time < 7.0), 0.0, 1.0)
    turn = np.where(half > 0, 0.0, np.pi / 4 * np.sin(np.pi * (time - 5.0) / 2.0) * np.pi / 2)
    levels = np.repeat(np.concatenate([FAST, -FAST]), len(time) // 6)
    smooth = np.convolve(np.pad(levels, 12, mode="edge"), np.ones(25) / 25, "valid")
    motions = [
        *teaching_motions(),
        TeachingMotion(
            "roll straight at three steady speeds up to a brisk walk, forwards and backwards",
            np.stack([smooth, zero, zero], 1),
        ),
        TeachingMotion(
            "push forwards and backwards along one heading, turn by a quarter, and again",
            np.stack([SPEED * wave * half, zero, turn], 1),
        ),
    ]
    held = np.eye(3) - cart.basis_b @ np.linalg.pinv(cart.basis_b)
    return [motion for motion in motions if np.allclose(motion.twist_b @ held, 0.0, atol=1e-9)]


def _apart(motion: TeachingMotion, without: CartModel, added: Effect, rivals: Sequence[Effect], hands: Hands) -> float:
    """Deviations by which an effect differs from any of its rivals, be these of any size."""
    plain, base = _traced(motion, without, hands)
    here = _traced(motion, without.with_effect(added), hands)[0] - plain
    root = np.linalg.cholesky(np.linalg.inv(reduced_noise(without, list(hands.contacts.values()), hands.noise)))
    scale = (hands.noise.rate * PERIOD) ** 0.5
    found = []
    for rival in rivals:
        slopes = _traced(motion, without.with_effect(rival), hands)[1]
        columns = np.concatenate([base, slopes[..., base.shape[2] + amplitudes_of(rival)], here[..., None]], axis=2)
        sides = scale * (root.T @ columns).reshape(-1, columns.shape[2])
        size = np.linalg.norm(sides[:, :-1], axis=0)
        unit = sides[:, :-1][:, size > RIDGE] / size[size > RIDGE]
        left = sides[:, -1] - unit @ np.linalg.lstsq(unit, sides[:, -1], rcond=1e-9)[0]
        found.append(float(np.linalg.norm(left)))
    return min(found)


def _traced(motion: TeachingMotion, cart: CartModel, hands: Hands) -> tuple[Array, Array]:
    """The reduced wrench (n, f) that is required, less what recorded wrenches that are as large stand for beside
    themselves; and its slopes (n, f, p) by the cart's parameters."""
    time, state, acceleration = motion.along(cart)
    inverse = cart.inverse(state, acceleration, time=time)
    late = np.gradient(inverse.wrench, PERIOD, axis=0)
    value = inverse.wrench - late * np.mean([cart.lateness(arm) for arm in hands.contacts])
    slopes = inverse.by_parameters - late[..., None] * _lateness_slopes(cart, hands.contacts)
    for arm, recorded in hands.shared(cart, inverse.wrench).items():
        reduced = cart.basis_b.T @ grasp_map_planar(hands.contacts[arm])
        hand = cart.hand_motion(state[:, cart.velocity_slice], acceleration, np.asarray(hands.contacts[arm]))
        true, by = cart.corrected_wrench(arm, recorded, hand=hand)
        value -= (true - recorded) @ reduced.T
        slopes -= reduced @ by
    return value, slopes


def _lateness_slopes(cart: CartModel, arms: Collection[str]) -> Array:
    """Of the mean lateness of arms by the parameters (p,)."""
    slopes = np.zeros(len(cart.parameters))
    for effect, where in cart.sensor_effects:
        share = np.mean([effect.concerns(arm) for arm in arms])
        moved = (effect.with_values(effect.values + step) for step in LATENESS_STEP * np.eye(len(effect.values)))
        slopes[where] = [share * (one.lateness - effect.lateness) / LATENESS_STEP for one in moved]
    return slopes
