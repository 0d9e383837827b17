"""From the recorded wrenches of the arms to the reduced wrench `Sᵀ Σ G F` that moves the cart."""

from __future__ import annotations

import copy
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np

from cartgrasp.contacts import grasp_map_planar
from cartgrasp.frames import Array
from cartgrasp.model import CartModel
from cartgrasp.motion import Measurement

MOST_FORCE = 1e6
"""N, N·m: more is no wrench, nor is NaN."""


@dataclass(frozen=True)
class SensedWrench:
    """Reduced wrench (n_free,), its noise covariance, and its partials (n_free, p) by the parameters."""

    value: Array
    covariance: Array
    by_parameters: Array


@dataclass(frozen=True)
class Hold:
    """Where an arm holds, what takes its wrench (6,) to the reduced one, and the noise of that."""

    contact: list[float]
    reduced: Array
    covariance: Array


class WrenchSensing:
    """Knows the arms, and remembers where they hold."""

    def __init__(self, cart: CartModel, arms: Sequence[str] | None, yaws: Mapping[str, float], noise: Array) -> None:
        self.cart, self.yaws, self._noise = cart, dict(yaws), noise
        self._arms = None if arms is None else tuple(arms)
        self._seen: tuple[str, ...] = ()
        self._holds: dict[str, Hold] = {}
        self._corrects = bool(cart.sensor_effects)
        n = cart.constraints.n_free
        self._calm, self._sure = np.zeros(n), np.zeros((n, n))
        self._nothing = np.zeros((n, len(cart.parameters)))

    def copy(self) -> Self:
        other = copy.copy(self)
        other._holds = dict(self._holds)
        return other

    def note_contacts(self, measurement: Measurement) -> None:
        for arm, contact in measurement.contacts.items():
            point = np.asarray(contact, dtype=float)
            numbers = point.tolist()
            known = self._holds.get(arm)
            if (known is None or known.contact != numbers) and np.isfinite(point).all():
                reduced = self.cart.basis_b.T @ grasp_map_planar(point, self.yaws.get(arm, 0.0))
                self._holds[arm] = Hold(numbers, reduced, reduced @ self._noise @ reduced.T)

    def sense(self, measurement: Measurement, parameters: Array) -> SensedWrench | None:
        """None where an arm's wrench or contact is missing: the total is then not known."""
        arms = self._arms or tuple(dict.fromkeys((*self._seen, *measurement.wrenches)))
        self._seen = arms
        value, covariance, by_parameters = self._calm, self._sure, self._nothing
        for arm in arms:
            recorded, hold = measurement.wrenches.get(arm), self._holds.get(arm)
            if recorded is None or hold is None:
                return None
            true = np.asarray(recorded, dtype=float)
            if self._corrects:
                true, true_by_parameters = self.cart.corrected_wrench(arm, true, parameters)
                by_parameters = by_parameters + hold.reduced @ true_by_parameters
            value, covariance = value + hold.reduced @ true, covariance + hold.covariance
        if not arms or not all(abs(number) < MOST_FORCE for number in value.tolist()):
            return None
        return SensedWrench(value, covariance, by_parameters)
