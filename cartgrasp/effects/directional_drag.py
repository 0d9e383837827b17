"""Viscous drag that differs between forward and backward: a skewed caster, a brush, a ratcheting bearing.

    fx = -(forward * p + backward * (1 - p)) u,    p = (1 + sign u) / 2

It is continuous, since it is 0 at rest either way.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

from .compiled import CompiledForce
from .effect import Parameter


@final
@dataclass(frozen=True)
class DirectionalDrag(CompiledForce):
    """Drag `forward u` or `backward u` (N·s/m), added to `viscous_drag`; one may be below 0 where that one's
    `linear` makes up for it."""

    forward: float = 0.0
    backward: float = 0.0

    name = "directional_drag"
    parameters = (
        Parameter("forward", "N·s/m", typical=2.0),
        Parameter("backward", "N·s/m", typical=2.0),
    )
    signature = "forward force in proportion to speed, with another slope when rolling backward"
