"""From the recorded wrenches of the arms to the reduced wrench `Sᵀ Σ G F` that moves the cart."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple, Self

import numpy as np

from cartgrasp.contacts import grasp_map_planar
from cartgrasp.frames import Array
from cartgrasp.model import CartModel
from cartgrasp.motion import Measurement

from .kernels.felt_wrench import MOST_FORCE
from .shallow import shallow


class SensedWrench(NamedTuple):
    """Reduced wrench (n_free,), its noise covariance, and its partials (n_free, p) by the parameters."""

    value: Array
    covariance: Array
    by_parameters: Array


class Hold(NamedTuple):
    """Where an arm holds, and what takes its wrench (6,) to the reduced one."""

    contact: list[float]
    reduced: Array


class Grip(NamedTuple):
    """Of n arms: what takes their wrenches (6 n,) to the reduced one, beside the noise of that, in `matrix` (f, 6 n +
    f); and room for these `wrenches`, with the `places` in it by arm."""

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
        self._no_grip = Grip(np.zeros((cart.constraints.n_free, cart.constraints.n_free)), np.zeros(0), {})
        self.corrects = bool(cart.sensor_effects)
        self.by_parameters = np.zeros((cart.constraints.n_free, len(cart.parameters)))

    def copy(self) -> Self:
        other = shallow(self)
        other._holds = dict(self._holds)
        return other

    def note_contacts(self, measurement: Measurement) -> None:
        for arm, contact in measurement.contacts.items():
            numbers, known = np.asarray(contact, dtype=float).tolist(), self._holds.get(arm)
            if (known is None or known.contact != numbers) and np.isfinite(numbers).all():
                reduced = self.cart.basis_b.T @ grasp_map_planar(numbers, self.yaws.get(arm, 0.0))
                self._holds[arm], self._grip = Hold(numbers, reduced), None

    def gripped(self, recorded: Mapping[str, Array], parameters: Array) -> Grip:
        """With the arms' wrenches, as they were, in it; and their reduced partials in `by_parameters`. Of no arms where
        an arm's wrench or contact is missing: the total is then not known."""
        if self._takes_all:
            self._note_arms(recorded)
        grip = self._grip = self._grip or self._gripped()
        for arm, place in grip.places.items():
            wrench = recorded.get(arm)
            if wrench is None:
                return self._no_grip
            place[:] = wrench
        if self.corrects and grip.places:
            self._correct(grip, parameters)
        return grip

    def sense(self, measurement: Measurement, parameters: Array) -> SensedWrench | None:
        """What all arms do together; None where that is not known."""
        grip = self.gripped(measurement.wrenches, parameters)
        n = len(grip.wrenches)
        if n == 0:
            return None
        value = grip.matrix[:, :n] @ grip.wrenches
        is_wrench = np.abs(value).sum() < MOST_FORCE
        return SensedWrench(value, grip.matrix[:, n:], self.by_parameters) if is_wrench else None

    def _correct(self, grip: Grip, parameters: Array) -> None:
        by = []
        for arm, place in grip.places.items():
            place[:], by_parameters = self.cart.corrected_wrench(arm, place.copy(), parameters)
            by.append(by_parameters)
        self.by_parameters = grip.matrix[:, : len(grip.wrenches)] @ np.concatenate(by)

    def _note_arms(self, recorded: Mapping[str, Array]) -> None:
        for arm in recorded:
            if arm not in self._arms:
                self._arms, self._grip = (*self._arms, arm), None

    def _gripped(self) -> Grip:
        """Of no arms where there is none, or a contact is not known."""
        holds = [self._holds.get(arm) for arm in self._arms]
        reduced = [hold.reduced for hold in holds if hold is not None]
        if len(reduced) < max(len(holds), 1):
            return self._no_grip
        noise = np.add.reduce([r @ self._noise @ r.T for r in reduced])
        wrenches = np.zeros(6 * len(reduced))
        return Grip(np.hstack([*reduced, noise]), wrenches, dict(zip(self._arms, wrenches.reshape(-1, 6), strict=True)))
