"""From the recorded wrenches of the arms to the reduced wrench `Sᵀ Σ G F` that moves the cart."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple, Self

import numpy as np

from cartgrasp.contacts import grasp_map_planar
from cartgrasp.frames import Array
from cartgrasp.model import CartModel
from cartgrasp.motion import Measurement

from .kernels.wrench_limits import MOST_FORCE
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
    """Of all arms: what takes their n wrenches (6 n,) to the reduced one, and the noise of that."""

    reduced: Array
    covariance: Array


class WrenchSensing:
    """Knows the arms, and remembers where they hold."""

    def __init__(self, cart: CartModel, arms: Sequence[str] | None, yaws: Mapping[str, float], noise: Array) -> None:
        self.cart, self.yaws, self._noise = cart, dict(yaws), noise
        self._takes_all, self._arms = arms is None, tuple(arms or ())
        self._holds: dict[str, Hold] = {}
        self._grip: Grip | None = None
        self._corrects = bool(cart.sensor_effects)
        self._nothing = np.zeros((cart.constraints.n_free, len(cart.parameters)))

    def copy(self) -> Self:
        other = shallow(self)
        other._holds = dict(self._holds)
        return other

    def note_contacts(self, measurement: Measurement) -> None:
        for arm, contact in measurement.contacts.items():
            point = np.asarray(contact, dtype=float)
            numbers = point.tolist()
            known = self._holds.get(arm)
            if (known is None or known.contact != numbers) and np.isfinite(point).all():
                reduced = self.cart.basis_b.T @ grasp_map_planar(point, self.yaws.get(arm, 0.0))
                self._holds[arm], self._grip = Hold(numbers, reduced), None

    def sense(self, measurement: Measurement, parameters: Array) -> SensedWrench | None:
        """None where an arm's wrench or contact is missing: the total is then not known."""
        recorded, true = measurement.wrenches, []
        if self._takes_all:
            self._note_arms(recorded)
        for arm in self._arms:
            wrench = recorded.get(arm)
            if wrench is None:
                return None
            true.append(wrench)
        grip = self._grip = self._grip or self._gripped()
        if grip is None:
            return None
        by_parameters = self._nothing
        if self._corrects:
            corrected = [
                self.cart.corrected_wrench(arm, np.asarray(wrench), parameters)
                for arm, wrench in zip(self._arms, true, strict=True)
            ]
            true = [wrench for wrench, _ in corrected]
            by_parameters = grip.reduced @ np.concatenate([by for _, by in corrected])
        value = grip.reduced @ np.concatenate(true)
        is_wrench = sum(map(abs, value.tolist())) < MOST_FORCE
        return SensedWrench(value, grip.covariance, by_parameters) if is_wrench else None

    def _note_arms(self, recorded: Mapping[str, Array]) -> None:
        for arm in recorded:
            if arm not in self._arms:
                self._arms, self._grip = (*self._arms, arm), None

    def _gripped(self) -> Grip | None:
        """None where there is no arm, or a contact is not known."""
        holds = [self._holds.get(arm) for arm in self._arms]
        reduced = [hold.reduced for hold in holds if hold is not None]
        if len(reduced) < max(len(holds), 1):
            return None
        return Grip(np.hstack(reduced), np.add.reduce([r @ self._noise @ r.T for r in reduced]))
