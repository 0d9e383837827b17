"""`effects/external_push.py`: parameters start, duration, force, moment; the constant is `RISE_TIME`."""

from __future__ import annotations

from ..jit import compiled
from ..situation import EffectValues, KernelSituation, Parts
from ..smooth import smooth_step


@compiled
def wrench(at: KernelSituation, own: EffectValues, out: Parts) -> None:
    since, duration = at.time - own.parameters[0], own.parameters[1]
    on, on_slope = smooth_step(since, own.constants[0])
    off, off_slope = smooth_step(since - duration, own.constants[0])
    for i, k in ((0, 2), (2, 3)):
        strength = own.parameters[k]
        out.value[i] += (on - off) * strength
        out.by_parameters[i, 0] += (off_slope - on_slope) * strength
        out.by_parameters[i, 1] += off_slope * strength
        out.by_parameters[i, k] += on - off
