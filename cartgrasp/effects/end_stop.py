"""Something fixed that the cart runs against and comes back from: a bumper, a wall, the end of a rail.

It stands at x = `position` of {s} (a rail is laid along x), where it stops {b}'s origin, and lets the cart be at
smaller x (`side` 1) or at larger x (`side` -1). With the depth d = side (x - position), either of two:

- `restitution` e of 0 or more: the touch is too short to be seen, and d' becomes -e d' at once where d passes 0
  (`bounce.py`, which whoever integrates a motion calls). Energy falls by 1 - e² of what the motion against it has.
- `stiffness` k and `damping` c: a force of k d + c d' while d > 0 and that is positive: a stop pushes and never pulls.
  A free mass m is in touch for pi sqrt(m / k) without damping.

The force begins over a depth h (`SMOOTHING_DEPTH`), with s(d) = (1 + tanh(d / h)) / 2, and ends as smoothly:

    f = s(d) (q + sqrt(q² + (k h)²)) / 2,    q = k (integral of s) + c d'.

It is learned from impacts, not from a balance of forces, so nothing of it is estimated with the rest.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import final

from .compiled import CompiledForce
from .effect import Parameter, Wall

SMOOTHING_DEPTH = 0.001
"""m: the force begins within twice this, which is less than a bumper of rubber gives under its own weight."""
NO_RESTITUTION = -1.0
"""As a restitution: d' stays as it is."""


@final
@dataclass(frozen=True)
class EndStop(CompiledForce):
    """At `position` (m, along x of {s}), seen from `side`; it throws back a share `restitution` of the speed at once,
    or is a spring of `stiffness` (N/m) with `damping` (N·s/m)."""

    position: float = 0.0
    side: float = 1.0
    restitution: float = NO_RESTITUTION
    stiffness: float = 0.0
    damping: float = 0.0

    name = "end_stop"
    parameters = (
        Parameter("position", "m", typical=1.0, estimated=False),
        Parameter("side", "-", typical=1.0, lower=-1.0, upper=1.0, absent=1.0, estimated=False),
        Parameter("restitution", "-", typical=0.5, lower=-1.0, upper=1.0, absent=NO_RESTITUTION, estimated=False),
        Parameter("stiffness", "N/m", typical=1e4, lower=0.0, estimated=False),
        Parameter("damping", "N·s/m", typical=100.0, lower=0.0, estimated=False),
    )
    signature = "the motion turns round at once, at one place"
    constants = (SMOOTHING_DEPTH,)
    searched = False

    @property
    def wall(self) -> Wall | None:
        return Wall(self.position, math.copysign(1.0, self.side), self.restitution) if self.restitution >= 0 else None

    def quickness(self, mass: float) -> float:
        return math.sqrt(self.stiffness / mass) + self.damping / mass
