"""`effects/directional_drag.py`: parameters forward, backward."""

from __future__ import annotations

from ..jit import compiled
from ..situation import EffectValues, KernelSituation, Parts
from ..smooth import smooth_sign


@compiled
def wrench(at: KernelSituation, own: EffectValues, out: Parts) -> None:
    forward, backward, u = own.parameters[0], own.parameters[1], at.velocity[0]
    sign, slope = smooth_sign(u, at.smoothing_speed)
    share = (1.0 + sign) / 2.0
    damping = forward * share + backward * (1.0 - share)
    out.value[0] -= damping * u
    out.by_velocity[0, 0] -= damping + (forward - backward) * slope / 2.0 * u
    out.by_parameters[0, 0] -= share * u
    out.by_parameters[0, 1] -= (1.0 - share) * u
