"""Viscous drag: N(q, qd) of (4), the paper's sigma."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

from .compiled import CompiledForce
from .effect import Parameter


@final
@dataclass(frozen=True)
class ViscousDrag(CompiledForce):
    """Force `-linear (u, w)` and moment `-angular r`."""

    linear: float = 0.0
    angular: float = 0.0

    name = "viscous_drag"
    parameters = (
        Parameter("linear", "N·s/m", typical=5.0, lower=0.0),
        Parameter("angular", "N·m·s/rad", typical=2.0, lower=0.0),
    )
    signature = "forward force in proportion to speed, yaw moment in proportion to yaw rate"
