"""Rolling resistance: each wheel drags against its own rolling in proportion to its load (physics.md).

A fixed wheel rolls along {b}'s x, a caster that the cart lists along its own heading (`WheelForce`): while it
swings round after a reversal it drags less, and turns the cart. Loads are the static ones (`wheels.py`), so the force
depends on m, m dx and m dy too.

The coefficient of a wheel is a lever over its radius: 2.2 mm for hard rubber on concrete, 2.4 on tile, 3.3 on asphalt
and 4.5 on industrial carpet (Al-Eisawi et al., Applied Ergonomics 30, 1999, 235-245); so 0.02 for 0.2 m wheels.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

from .compiled import WheelForce
from .effect import Parameter


@final
@dataclass(frozen=True)
class RollingResistance(WheelForce):
    """Drag `coefficient * load` at each wheel, independent of speed."""

    coefficient: float = 0.0

    name = "rolling_resistance"
    parameters = (Parameter("coefficient", "-", typical=0.02, lower=0.0, upper=1.0, is_by_mass=True),)
    signature = "a step of the forward force where the cart changes direction, flat in speed"
