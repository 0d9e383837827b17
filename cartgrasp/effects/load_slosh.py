"""Part of the load that swings along x on the cart: liquid in a tank, a crate on soft ground, a hanging bag.

A part ms of the cart's mass m is on a spring and damper, with its displacement s against the cart and its own forward
speed v along {b}'s x as memory, and omega = 2 pi frequency, zeta = damping:

    s' = v - u,    v' = -pull,    pull = omega² s + 2 zeta omega (v - u),
    m u' + ... = F_x + ms (pull + u'),

at {b}'s origin. phi is of the whole cart, with its load at rest on it: so are its weight on the wheels and on a slope,
its CoM, and its inertia along y and against rotation. Along x a slow push moves m, since pull + u' vanishes then, and a
sudden one m - ms. Where motion is solved for, at most 95 % of the inertia along x of the free cart (m, where the CoM is
at y = 0) swings, whatever a fit tries. Left out: where the weight of what swings goes, and its speed across.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np

from ..frames import Array
from ..wheels import WheelSet
from .compiled import CompiledForce
from .effect import Parameter

FREQUENCY_GRID, DAMPING_GRID = (0.4, 0.6, 0.85, 1.2, 1.7, 2.4), (0.05, 0.2)


@final
@dataclass(frozen=True)
class LoadSlosh(CompiledForce):
    """`mass` (kg), a part of the cart's, swings at `frequency` (Hz, with the cart held) and the share `damping` of
    critical damping.

    It begins at rest on the cart: s = 0, v = u.
    """

    mass: float = 0.0
    frequency: float = 1.0
    damping: float = 0.05

    name = "load_slosh"
    parameters = (
        Parameter("mass", "kg", typical=3.0, lower=0.0),
        Parameter(
            "frequency", "Hz", typical=0.5, lower=0.05, upper=20.0, absent=1.0, estimated=False, grid=FREQUENCY_GRID
        ),
        Parameter("damping", "-", typical=0.05, lower=0.0, upper=2.0, absent=0.05, estimated=False, grid=DAMPING_GRID),
    )
    signature = "a forward force that swings on at one frequency after each change of speed"

    @property
    def memory_numbers(self) -> tuple[float, ...]:
        return self.frequency, self.damping

    def memory_names(self, wheels: WheelSet) -> tuple[str, ...]:
        return (f"{self.key}.displacement", f"{self.key}.speed")

    def first_memory(self, wheels: WheelSet, velocity_b: Array) -> Array:
        return np.array([0.0, velocity_b[0]])

    def memory_spread(self, wheels: WheelSet) -> Array:
        return np.array([0.01, 0.05])
