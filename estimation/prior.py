"""What is believed before the first push, in physical units."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from cartgrasp.errors import UsageError
from cartgrasp.frames import Array
from cartgrasp.inertia import N_PHI, physical_jacobian
from cartgrasp.model import CartModel

PHYSICAL_NAMES = ("mass", "com_x", "com_y", "inertia")
PHYSICAL_UNITS = ("kg", "m", "m", "kg·m²")


@dataclass(frozen=True)
class Prior:
    """Standard deviations of the first guess: mass and inertia as shares of their values, CoM in m; effects'
    parameters as a share of their value, but at least their typical size. `known` names what is not estimated
    (full parameter names, or an effect's key for all of its parameters)."""

    mass: float = 0.4
    com: float = 0.2
    inertia: float = 0.8
    effects: float = 0.5
    known: frozenset[str] = frozenset()
    std: Mapping[str, float] = field(default_factory=dict)

    def free(self, cart: CartModel) -> np.ndarray:
        """Indices of the parameters (p,) that are estimated."""
        names = report_names(cart)
        unknown = self.known - set(names) - {e.key for e in cart.effects}
        if unknown:
            raise UsageError(f"prior: {', '.join(sorted(unknown))} is no parameter; they are {', '.join(names)}")
        fixed = [name in self.known for name in names[:N_PHI]]
        if any(fixed) and not all(fixed):
            raise UsageError("prior: mass, com_x, com_y and inertia are known together or estimated together")
        for effect in cart.effects:
            for parameter, key in zip(effect.parameters, effect.keys, strict=True):
                fixed.append(key in self.known or effect.key in self.known or not parameter.estimated)
        if cart.constraints.no_rotation:
            fixed[1:N_PHI] = [True] * (N_PHI - 1)
        return np.flatnonzero(~np.array(fixed))

    def covariance(self, cart: CartModel) -> Array:
        """Covariance (p, p) of the parameters `(phi | effects' values)`."""
        deviations = self.deviations(cart)
        covariance = np.diag(deviations**2)
        from_physical = np.linalg.inv(physical_jacobian(cart.inertia.phi))
        covariance[:N_PHI, :N_PHI] = from_physical @ np.diag(deviations[:N_PHI] ** 2) @ from_physical.T
        return covariance

    def deviations(self, cart: CartModel) -> Array:
        """Standard deviations (p,) of mass, CoM, inertia and the effects' values."""
        body = cart.inertia
        deviations = [self.mass * body.mass, self.com, self.com, self.inertia * body.about_com]
        for effect in cart.effects:
            for parameter, value in zip(effect.parameters, effect.values, strict=True):
                deviations.append(max(self.effects * abs(value), parameter.typical))
        names = report_names(cart)
        for name, std in self.std.items():
            if name not in names:
                raise UsageError(f"prior: {name} is no parameter; they are {', '.join(names)}")
            deviations[names.index(name)] = std
        return np.array(deviations)


def report_names(cart: CartModel) -> tuple[str, ...]:
    """Names under which the parameters are reported: mass, com_x, com_y, inertia, EFFECT.PARAMETER."""
    return PHYSICAL_NAMES + cart.parameter_names[N_PHI:]


def report_units(cart: CartModel) -> tuple[str, ...]:
    return PHYSICAL_UNITS + tuple(p.unit for effect in cart.effects for p in effect.parameters)
