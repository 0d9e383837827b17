"""From the recorded wrenches of the arms to the reduced wrench `Sᵀ Σ G F` that moves the cart."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from cartgrasp.contacts import grasp_map_planar
from cartgrasp.frames import Array
from cartgrasp.model import CartModel
from cartgrasp.motion import Measurement


@dataclass(frozen=True)
class SensedWrench:
    """Reduced wrench (n_free,), its noise covariance, and its partials (n_free, p) by the parameters."""

    value: Array
    covariance: Array
    by_parameters: Array


class WrenchSensing:
    """Knows the arms, and remembers where they hold."""

    def __init__(self, cart: CartModel, arms: Sequence[str] | None, yaws: Mapping[str, float], noise: Array) -> None:
        self.cart, self.yaws, self._noise = cart, dict(yaws), noise
        self._arms = None if arms is None else tuple(arms)
        self._seen: tuple[str, ...] = ()
        self._contacts: dict[str, Array] = {}

    def note_contacts(self, measurement: Measurement) -> None:
        for arm, contact in measurement.contacts.items():
            point = np.asarray(contact, dtype=float)
            if np.isfinite(point).all():
                self._contacts[arm] = point

    def sense(self, measurement: Measurement, parameters: Array) -> SensedWrench | None:
        """None where an arm's wrench or contact is missing: the total is then not known."""
        arms = self._arms or tuple(dict.fromkeys((*self._seen, *measurement.wrenches)))
        self._seen = arms
        basis = self.cart.basis_b
        n = basis.shape[1]
        value, covariance = np.zeros(n), np.zeros((n, n))
        by_parameters = np.zeros((n, len(parameters)))
        for arm in arms:
            recorded = measurement.wrenches.get(arm)
            contact = self._contacts.get(arm)
            if recorded is None or contact is None or not np.isfinite(recorded).all():
                return None
            true, true_by_parameters = self.cart.corrected_wrench(arm, np.asarray(recorded, float), parameters)
            reduced = basis.T @ grasp_map_planar(contact, self.yaws.get(arm, 0.0))
            value += reduced @ true
            covariance += reduced @ self._noise @ reduced.T
            by_parameters += reduced @ true_by_parameters
        return SensedWrench(value, covariance, by_parameters) if arms else None
