"""From the recorded wrenches of the arms to the reduced wrench `Sᵀ Σ G F` that moves the cart.

Where sensors feel how hands move, what they record depends on the acceleration that the wrench makes. Corrected ones
are affine in it, `W = W0 + W1 nu'`, and so is the cart's `nu' = a0 + A W`: with the motion known, `W` follows without
a derivative of anything measured, and its slopes by the parameters with those of the cart's own.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple, Self

import numpy as np

from cartgrasp.contacts import grasp_map_planar
from cartgrasp.effects.effect import HAND_AT_REST, HandMotion
from cartgrasp.frames import Array
from cartgrasp.model import CartModel
from cartgrasp.motion import Measurement
from cartgrasp.shallow_copy import shallow_copy
from cartgrasp.wheels import GRAVITY

from .kernels.measured_wrench import MAX_WRENCH, WRENCH_HOLD_TIME

UNUSED_COMPONENTS = slice(2, 5)
"""The unused components of a wrench: fz, tx and ty push no planar cart, and no sensor effect mixes them into what
does."""

MAX_WRENCH_JUMP_RATIO = 0.3
"""Largest jump of the wrenches (N and N·m) from sample to sample, as a share of the cart's weight."""


class SensedWrench(NamedTuple):
    """Reduced wrench (n_free,), its noise covariance, and its partials (n_free, p) by the parameters."""

    value: Array
    covariance: Array
    by_parameters: Array


class Hold(NamedTuple):
    """Where an arm holds, also as it was given, and what takes its wrench (6,) to the reduced one."""

    told: list[float]
    contact: list[float]
    reduced: Array


class Moving(NamedTuple):
    """A state (n,) of the cart and its time (s)."""

    state: Array
    time: float


class Grip(NamedTuple):
    """The grip of n arms. `matrix` (f, 6 n + f) takes their wrenches (6 n,) to the reduced one, with the noise of that
    beside it. `wrenches` is room for them, with the `places` in it by arm."""

    matrix: Array
    wrenches: Array
    places: dict[str, Array]


class WrenchSensing:
    """Knows the arms, and remembers where they hold."""

    def __init__(self, cart: CartModel, arms: Sequence[str] | None, yaws: Mapping[str, float], noise: Array) -> None:
        self.cart, self.yaws, self._noise = cart, dict(yaws), noise
        self._takes_all, self._arms = arms is None, tuple(arms or ())
        self._holds: dict[str, Hold] = {}
        self._grip: Grip | None = None
        self._last: dict[str, tuple[float, Array]] = {}  # by arm: when, and what it recorded
        self._accepted, self._doubted = (
            list[float](),
            list[float](),
        )  # fx, fy and tz (3 n,): the last, and those that jumped
        self._farthest = MAX_WRENCH_JUMP_RATIO * GRAVITY * cart.inertia.mass
        self._no_grip = Grip(np.zeros((cart.constraints.n_free, cart.constraints.n_free)), np.zeros(0), {})
        self.corrects, self.feels_motion = bool(cart.sensor_effects), cart.feels_motion
        self.by_parameters = np.zeros((cart.constraints.n_free, len(cart.parameters)))

    def copy(self) -> Self:
        other = shallow_copy(self)
        other._holds, other._last = dict(self._holds), dict(self._last)
        return other

    def note_contacts(self, measurement: Measurement) -> None:
        for arm, contact in measurement.contacts.items():
            told = contact.tolist() if isinstance(contact, np.ndarray) else list(contact)
            known = self._holds.get(arm)
            if known is None or told != known.told:
                self._hold(arm, told)

    def _hold(self, arm: str, told: list[float]) -> None:
        x, y, z = map(float, told)
        if not math.isfinite(x + y):
            return
        contact, known = [x, y, z if math.isfinite(z) else 0.0], self._holds.get(arm)
        if known is not None and known.contact == contact:
            return
        reduced = self.cart.basis_b.T @ grasp_map_planar(contact, self.yaws.get(arm, 0.0))
        self._holds[arm], self._grip = Hold(told, contact, reduced), None

    def gripped(self, measurement: Measurement, parameters: Array, moving: Moving | None = None) -> Grip:
        """The grip with the arms' wrenches in it, as they were felt; their reduced partials are in `by_parameters`. It
        has no arms where an arm's wrench or contact is missing, or jumps beyond belief: the total is then not known. A
        wrench that is NaN stays so. Arms may come in samples of their own: a wrench is held for as long as all of them
        are. `moving` is the cart where sensors feel it (None: at rest)."""
        recorded = measurement.wrenches
        if self._takes_all:
            self._note_arms(recorded)
        grip = self._grip = self._grip or self._new_grip()
        if len(grip.places) > 1 and recorded:
            recorded = self._held(measurement.time, recorded)
        for arm, place in grip.places.items():
            wrench = recorded.get(arm)
            if wrench is None:
                return self._no_grip
            place[:] = wrench
        numbers = grip.wrenches.tolist()
        if not math.isfinite(sum(numbers)):
            for place in grip.places.values():
                place[UNUSED_COMPONENTS] = np.nan_to_num(place[UNUSED_COMPONENTS], posinf=0.0, neginf=0.0)
            numbers = grip.wrenches.tolist()
        if self._has_jumped([*numbers[0::6], *numbers[1::6], *numbers[5::6]]):
            return self._no_grip
        if self.corrects and grip.places:
            if moving is not None and self.feels_motion:
                self._correct_moving(grip, parameters, moving)
            else:
                self._correct(grip, parameters)
        return grip

    def _held(self, time: float, recorded: Mapping[str, Array]) -> Mapping[str, Array]:
        """With what other arms recorded last, where that was not long ago."""
        for arm, wrench in recorded.items():
            self._last[arm] = time, np.array(wrench, dtype=float)
        return {arm: wrench for arm, (since, wrench) in self._last.items() if time - since <= WRENCH_HOLD_TIME}

    def _has_jumped(self, recorded: list[float]) -> bool:
        """Whether fx, fy and tz of the arms (3 n,) went further than hands do from one sample to the next. What the
        next sample confirms is no spike; where one is missing, the last that was there counts."""
        if not math.isfinite(sum(recorded)):
            return False
        before, self._accepted = self._accepted, recorded
        if len(before) != len(recorded) or not (jump := math.dist(recorded, before)) > self._farthest:
            return False
        doubted, self._doubted = self._doubted, recorded
        if len(doubted) == len(recorded) and math.dist(recorded, doubted) < 0.5 * jump:
            return False
        self._accepted = before
        return True

    def sense(self, measurement: Measurement, parameters: Array, moving: Moving | None = None) -> SensedWrench | None:
        """What all arms do together; None where that is not known."""
        grip = self.gripped(measurement, parameters, moving)
        n = len(grip.wrenches)
        if n == 0:
            return None
        value = grip.matrix[:, :n] @ grip.wrenches
        is_wrench = np.abs(value).sum() < MAX_WRENCH
        return SensedWrench(value, grip.matrix[:, n:], self.by_parameters) if is_wrench else None

    def _correct(self, grip: Grip, parameters: Array) -> None:
        wrenches, self.by_parameters = self._corrected(grip, parameters, {})
        grip.wrenches[:] = wrenches

    def _correct_moving(self, grip: Grip, parameters: Array, moving: Moving) -> None:
        cart, reduce = self.cart, grip.matrix[:, : len(grip.wrenches)]
        nu = moving.state[cart.velocity_slice]
        f = len(nu)
        still, *unit = (
            reduce @ self._corrected(grip, parameters, self._hands(grip, nu, rate))[0]
            for rate in (np.zeros(f), *np.eye(f))
        )
        by_rate = np.array([one - still for one in unit]).T
        push = np.zeros(3)
        flow = cart.rate(moving.state, push, parameters, moving.time)
        own = cart.velocity_slice
        by_wrench = flow.by_wrench[own] @ cart.rolling.along_b.T
        solved = np.linalg.inv(np.eye(f) - by_rate @ by_wrench)
        reduced = solved @ (still + by_rate @ flow.value[own])
        flow = cart.rate(moving.state, cart.planar_wrench(reduced), parameters, moving.time)
        wrenches, by_parameters = self._corrected(grip, parameters, self._hands(grip, nu, flow.value[own]))
        grip.wrenches[:] = wrenches
        self.by_parameters = solved @ (by_parameters + by_rate @ flow.by_parameters[own])

    def _hands(self, grip: Grip, nu: Array, nu_rate: Array) -> dict[str, HandMotion]:
        return {
            arm: self.cart.hand_motion(nu, nu_rate, np.array(self._holds[arm].contact), self.yaws.get(arm, 0.0))
            for arm in grip.places
        }

    def _corrected(self, grip: Grip, parameters: Array, hands: Mapping[str, HandMotion]) -> tuple[Array, Array]:
        """The arms' wrenches (6 n,), and the reduced wrench's partials (f, p) while nothing else changes."""
        found, by = [], []
        for arm, place in grip.places.items():
            wrench, by_parameters = self.cart.corrected_wrench(arm, place, parameters, hands.get(arm, HAND_AT_REST))
            found.append(wrench)
            by.append(by_parameters)
        return np.concatenate(found), grip.matrix[:, : len(grip.wrenches)] @ np.concatenate(by)

    def _note_arms(self, recorded: Mapping[str, Array]) -> None:
        for arm in recorded:
            if arm not in self._arms:
                self._arms, self._grip = (*self._arms, arm), None

    def _new_grip(self) -> Grip:
        """The grip of all arms, with zero wrenches; one of no arms where there is none, or where a contact is not
        known."""
        holds = [self._holds.get(arm) for arm in self._arms]
        reduced = [hold.reduced for hold in holds if hold is not None]
        if len(reduced) < max(len(holds), 1):
            return self._no_grip
        noise = np.add.reduce([r @ self._noise @ r.T for r in reduced])
        wrenches = np.zeros(6 * len(reduced))
        return Grip(np.hstack([*reduced, noise]), wrenches, dict(zip(self._arms, wrenches.reshape(-1, 6), strict=True)))
