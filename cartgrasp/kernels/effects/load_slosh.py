"""`effects/load_slosh.py`: parameters mass, frequency, damping; memory displacement, speed."""

from __future__ import annotations

import math

from cartgrasp.frames import Array

from ..jit import compiled
from ..situation import SWINGING_ROW, EffectValues, KernelSituation, Parts


@compiled
def wrench(at: KernelSituation, own: EffectValues, out: Parts) -> None:
    mass = own.parameters[0]
    pull, by_stretch, by_rate, by_frequency, by_damping = _pull(at, own)
    out.value[0] += mass * pull
    out.value[SWINGING_ROW] += mass
    out.by_parameters[SWINGING_ROW, 0] += 1.0
    out.by_velocity[0, 0] -= mass * by_rate
    out.by_memory[0, 0] += mass * by_stretch
    out.by_memory[0, 1] += mass * by_rate
    out.by_parameters[0, 0] += pull
    out.by_parameters[0, 1] += mass * by_frequency
    out.by_parameters[0, 2] += mass * by_damping


@compiled
def memory_rate(at: KernelSituation, own: EffectValues, out: Parts) -> None:
    pull, by_stretch, by_rate, by_frequency, by_damping = _pull(at, own)
    out.value[0] += own.memory[1] - at.velocity[0]
    out.by_velocity[0, 0] -= 1.0
    out.by_memory[0, 1] += 1.0
    out.value[1] -= pull
    out.by_velocity[1, 0] += by_rate
    out.by_memory[1, 0] -= by_stretch
    out.by_memory[1, 1] -= by_rate
    out.by_parameters[1, 1] -= by_frequency
    out.by_parameters[1, 2] -= by_damping


@compiled
def settled(at: KernelSituation, own: EffectValues, memory: Array) -> None:
    """It goes along with the cart."""
    memory[0], memory[1] = 0.0, at.velocity[0]


@compiled
def _pull(at: KernelSituation, own: EffectValues) -> tuple[float, float, float, float, float]:
    """Force on the cart for each kg, and its partials by displacement, by its rate, by frequency and by damping."""
    omega, damping = 2.0 * math.pi * own.parameters[1], own.parameters[2]
    stretch, rate = own.memory[0], own.memory[1] - at.velocity[0]
    by_frequency = 2.0 * math.pi * (2.0 * omega * stretch + 2.0 * damping * rate)
    pull = omega**2 * stretch + 2.0 * damping * omega * rate
    return pull, omega**2, 2.0 * damping * omega, by_frequency, 2.0 * omega * rate
