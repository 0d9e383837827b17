"""True carts that are drawn, each by its own seed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...errors import CartgraspError, UsageError
from ...first_guess import PHYSICAL_NAMES
from ...inertia import N_PHI, Inertia, physical_from_phi
from ...model import CartModel

UNIFORM, NORMAL = "uniform", "normal"
MAX_DRAWS = 1000


@dataclass(frozen=True)
class Drawn:
    """A parameter by its contract name: uniform between low and high, or normal of a mean and a deviation."""

    parameter: str
    law: str
    numbers: tuple[float, float]

    def __post_init__(self) -> None:
        low, high = self.numbers
        if self.law == UNIFORM and not low <= high:
            raise UsageError(f"uniform: [{low:g}, {high:g}] ends below where it begins")
        if self.law == NORMAL and not high >= 0:
            raise UsageError(f"normal: its standard deviation {high:g} is negative")

    def draw(self, random: np.random.Generator) -> float:
        first, second = self.numbers
        return float(random.uniform(first, second) if self.law == UNIFORM else random.normal(first, second))


def parameter_names(cart: CartModel) -> tuple[str, ...]:
    return PHYSICAL_NAMES + cart.parameter_names[N_PHI:]


def drawn_values(drawn: Sequence[Drawn], cart: CartModel, random: np.random.Generator) -> dict[str, float]:
    """A value for each; what together is no cart is drawn again."""
    for _ in range(MAX_DRAWS):
        values = {one.parameter: one.draw(random) for one in drawn}
        if _is_cart(cart, values):
            return values
    raise UsageError(f"drawn: none of {MAX_DRAWS} draws is a cart: mass and inertia > 0, effects within their bounds")


def with_values(cart: CartModel, values: dict[str, float]) -> CartModel:
    """The cart with these parameters."""
    own = [*physical_from_phi(cart.inertia.phi).tolist(), *cart.parameters[N_PHI:].tolist()]
    told = [values.get(name, value) for name, value in zip(parameter_names(cart), own, strict=True)]
    mass, com_x, com_y, about_com = told[: len(PHYSICAL_NAMES)]
    inertia = Inertia(mass, (com_x, com_y), about_com)
    return cart.with_parameters(np.concatenate([inertia.phi, told[len(PHYSICAL_NAMES) :]]))


def _is_cart(cart: CartModel, values: dict[str, float]) -> bool:
    """The drawn values themselves: a model that is given what no effect can be takes the nearest that it can."""
    try:
        with_values(cart, values)
    except CartgraspError:
        return False
    own = [p for effect in cart.effects for p in effect.parameters]
    bounds = {name: (p.lower, p.upper) for name, p in zip(cart.parameter_names[N_PHI:], own, strict=True)}
    return all(low <= values.get(name, low) <= high for name, (low, high) in bounds.items())
