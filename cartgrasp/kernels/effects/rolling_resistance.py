"""`effects/rolling_resistance.py`: parameter coefficient; a heading of each listed caster."""

from __future__ import annotations

from cartgrasp.frames import Array

from ..casters import heading_rates, settled_headings
from ..jit import compiled
from ..rolling import drag, hold
from ..situation import EffectValues, KernelSituation, Parts

memory_rate, settled = heading_rates, settled_headings


@compiled
def wrench(at: KernelSituation, own: EffectValues, out: Parts) -> None:
    for wheel in range(len(at.wheels)):
        unit = drag(at, own, wheel, own.parameters[0], out)
        for i in range(3):
            out.by_parameters[i, 0] -= unit[i] * at.loads[wheel]


@compiled
def stiction(at: KernelSituation, own: EffectValues, columns: Array) -> int:
    for wheel in range(len(at.wheels)):
        hold(at, own, wheel, own.parameters[0] * at.loads[wheel], columns)
    return 2 * len(at.wheels)
