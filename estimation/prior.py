"""What is believed before the first push, in physical units."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from cartgrasp.checks import MAX_NUMBER, check_kind, check_known, listed, number, positive
from cartgrasp.first_guess import PHYSICAL_NAMES
from cartgrasp.frames import Array
from cartgrasp.inertia import N_PHI, physical_jacobian
from cartgrasp.model import CartModel

PHYSICAL_UNITS = ("kg", "m", "m", "kg·m²")
KNOWN_STD_RATIO = 1e-3
"""Share of a usual deviation, for what is known of a body whose mass is not: only its moments enter linearly."""


@dataclass(frozen=True)
class Prior:
    """How sure the first guess is. What a cart's file says of it counts as if it stood here.

    Args:
        mass: Standard deviation as a share of the value.
        com: Standard deviation of each coordinate, m.
        inertia: Standard deviation as a share of the value.
        effects: The same of each effect's parameters, but at least their typical size.
        slope: Of the rise over run of a floor along x and y, where the cart has no `floor_slope`. Online no floor is
            taken for level, but with 0.
        known: What is not estimated: names of parameters, or an effect's key for all of its own.
        std: Other standard deviations by name, in the parameter's unit.

    Raises:
        UsageError: A deviation is negative, not finite, or 0, which `effects` and `slope` alone may be. A name that the
            cart does not have is refused at use.

    Example:
        >>> import cartgrasp as cg
        >>> from estimation import CartFilter, Prior
        >>> cart = cg.load_cart("cart.yaml")
        >>> prior = Prior(known={"inertia"}, std={"mass": 2.0})
        >>> prior.deviations(cart)[0], prior.held(cart)[:4].tolist()  # mass, CoM x and y, inertia
        (np.float64(2.0), [False, False, False, True])
    """

    mass: float = 0.4
    com: float = 0.2
    inertia: float = 0.8
    effects: float = 0.5
    slope: float = 0.007
    known: frozenset[str] = frozenset()
    std: Mapping[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        cure = "give one standard deviation; what is sure stands under `known`"
        for name in ("mass", "com", "inertia"):
            positive(f"prior: {name}", getattr(self, name), MAX_NUMBER, cure)
        for name in ("effects", "slope"):
            number(f"prior: {name}", getattr(self, name), 0.0, MAX_NUMBER, "give one standard deviation")
        form = 'write known={"mass"}, a set of names'
        object.__setattr__(self, "known", frozenset(listed("prior: known", self.known, str, form)))
        check_kind("prior: std", self.std, Mapping, "write {'mass': 2.0}")
        for name, std in self.std.items():
            positive(f"prior: std of {name}", std, MAX_NUMBER, cure)

    def free(self, cart: CartModel) -> np.ndarray:
        """Indices of the parameters (p,) `(phi | effects' values)` that are estimated. Of a body of which only a part
        is known, what is known is as good as sure (`deviations`). What is optional, and absent or nonlinear, is
        not."""
        each = ((p, v) for effect in cart.effects for p, v in zip(effect.parameters, effect.values, strict=True))
        unasked = [p.optional and (value == p.absent or bool(p.grid)) for p, value in each]
        fixed = self.held(cart) | np.array([False] * N_PHI + unasked)
        if not fixed[:N_PHI].all():
            fixed[1:N_PHI] = cart.constraints.no_rotation
        return np.flatnonzero(~fixed)

    def held(self, cart: CartModel) -> np.ndarray:
        """Which of the reported parameters (p,) are known, are never estimated, or can't enter."""
        names = report_names(cart)
        unknown = self.known - set(names) - {e.key for e in cart.effects}
        check_known("prior: known", sorted(unknown), names)
        known = self.known.union(cart.first_guess.known)
        fixed = [name in known for name in names[:N_PHI]]
        for effect in cart.effects:
            for parameter, key in zip(effect.parameters, effect.keys, strict=True):
                fixed.append(key in known or effect.key in known or not parameter.estimated)
        if cart.constraints.no_rotation:
            fixed[1:N_PHI] = [True] * (N_PHI - 1)
        return np.array(fixed)

    def covariance(self, cart: CartModel) -> Array:
        """Covariance (p, p) of the parameters `(phi | effects' values)`."""
        deviations = self.deviations(cart)
        covariance = np.diag(deviations**2)
        from_physical = np.linalg.inv(physical_jacobian(cart.inertia.phi))
        own = deviations[:N_PHI].copy()
        if self._is_sure(cart)[0]:
            own[0] *= KNOWN_STD_RATIO  # a known mass moves no moment
        covariance[:N_PHI, :N_PHI] = from_physical @ np.diag(own**2) @ from_physical.T
        return covariance

    def deviations(self, cart: CartModel) -> Array:
        """Standard deviations (p,) of mass, CoM, inertia and the effects' values."""
        body = cart.inertia
        deviations = [self.mass * body.mass, self.com, self.com, self.inertia * body.about_com]
        for effect in cart.effects:
            for parameter, value in zip(effect.parameters, effect.values, strict=True):
                deviations.append(max(self.effects * abs(value), parameter.typical))
        names = report_names(cart)
        told = {name: std for name, std in cart.first_guess.std if name in names}
        check_known("prior: std", self.std, names)
        for name, std in {**told, **self.std}.items():
            deviations[names.index(name)] = std
        found = np.array(deviations)
        found[1:N_PHI] *= np.where(self._is_sure(cart)[1:], KNOWN_STD_RATIO, 1.0)
        return found

    def _is_sure(self, cart: CartModel) -> np.ndarray:
        """Which of a body's numbers (4,) are known where not all are."""
        known = self.known.union(cart.first_guess.known)
        sure = np.array([name in known for name in PHYSICAL_NAMES])
        return np.zeros(N_PHI, dtype=bool) if sure.all() else sure


def report_names(cart: CartModel) -> tuple[str, ...]:
    """Names under which the parameters are reported: mass, com_x, com_y, inertia, EFFECT.PARAMETER."""
    return PHYSICAL_NAMES + cart.parameter_names[N_PHI:]


def report_units(cart: CartModel) -> tuple[str, ...]:
    return PHYSICAL_UNITS + tuple(p.unit for effect in cart.effects for p in effect.parameters)
