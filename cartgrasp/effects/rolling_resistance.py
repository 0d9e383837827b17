"""Rolling resistance: each wheel drags against its own rolling in proportion to its load (physics 16).

A fixed wheel rolls along {b}'s x, a caster along the velocity of its pivot. Loads are the static ones
(`wheels.py`), so the force depends on m, m dx and m dy too.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, final

from .compiled import CompiledForce
from .effect import Parameter


@final
@dataclass(frozen=True)
class RollingResistance(CompiledForce):
    """Drag `coefficient * load` at each wheel, independent of speed."""

    coefficient: float = 0.0

    name: ClassVar[str] = "rolling_resistance"
    parameters: ClassVar[tuple[Parameter, ...]] = (Parameter("coefficient", "-", typical=0.02, lower=0.0, upper=1.0),)
    signature: ClassVar[str] = "a step of the forward force where the cart changes direction, flat in speed"
