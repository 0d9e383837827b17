"""What is believed of each measured cart at first: a rail, a round wrong mass, some drag in proportion to speed."""

from __future__ import annotations

from dataclasses import replace

from cartgrasp.constraints import RollingConstraints
from cartgrasp.effects import ViscousDrag
from cartgrasp.inertia import Inertia
from cartgrasp.model import CartModel


def on_a_rail(name: str, mass: float, drag: float) -> CartModel:
    """Of so many kg and N·s/m. Where nothing turns, the centre of mass and the moment of inertia are of no account."""
    rail = RollingConstraints(0.0, no_rotation=True)
    return CartModel(Inertia(mass, (0.0, 0.0), 1.0), rail, (ViscousDrag(linear=drag),), name=name)


WHEELCHAIR = on_a_rail("wheelchair", 110.0, 2.0)
CAR = on_a_rail("car", 300.0, 10.0)
EMPS = on_a_rail("EMPS axis", 80.0, 100.0)
INCLINE = on_a_rail("dynamics cart", 0.5, 0.02)
"""No force was recorded, so its mass is taken as given."""


def guessed(cart: CartModel, mass: float) -> CartModel:
    """The same, believed to have another mass (kg)."""
    return cart.with_inertia(replace(cart.inertia, mass=mass))
