"""Quadratic drag, of air and of soft tyres.

    F = -coefficient * |v| v,    v = (u, w)

which is `-coefficient * u |u|` where the fixed wheels keep w at 0.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

from .compiled import CompiledForce
from .effect import Parameter


@final
@dataclass(frozen=True)
class QuadraticDrag(CompiledForce):
    """Drag `coefficient |v|²` against the velocity of {b}'s origin."""

    coefficient: float = 0.0

    name = "quadratic_drag"
    parameters = (Parameter("coefficient", "N·s²/m²", typical=3.0, lower=0.0),)
    signature = "forward force that grows with the square of speed"
