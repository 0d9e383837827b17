"""`effects/payload_change.py`: parameters time, mass, x, y."""

from __future__ import annotations

from cartgrasp.frames import Array

from ..jit import compiled
from ..situation import EffectValues


@compiled
def phi_change(time: float, own: EffectValues, out: tuple[Array, Array]) -> None:
    phi, by_own = out
    mass, x, y = own.parameters[1], own.parameters[2], own.parameters[3]
    if not time >= own.parameters[0]:
        return
    shape = (1.0, x, y, x**2 + y**2)
    for i in range(4):
        phi[i] += mass * shape[i]
        by_own[i, 1] += shape[i]
    by_own[1, 2] += mass
    by_own[2, 3] += mass
    by_own[3, 2] += 2.0 * mass * x
    by_own[3, 3] += 2.0 * mass * y
