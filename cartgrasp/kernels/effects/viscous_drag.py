"""`effects/viscous_drag.py`: parameters linear, angular."""

from __future__ import annotations

from ..jit import compiled
from ..situation import EffectValues, KernelSituation, Parts


@compiled
def wrench(at: KernelSituation, own: EffectValues, out: Parts) -> None:
    for i in range(3):
        which = i // 2
        damping = own.parameters[which]
        out.value[i] -= damping * at.velocity[i]
        out.by_velocity[i, i] -= damping
        out.by_parameters[i, which] -= at.velocity[i]
