"""One fixed wheel drags more than the other: a yaw moment whenever the cart rolls.

    fx = -Σ F_i sign(u - y_i r),    tau = Σ y_i F_i sign(u - y_i r),    Σ F_i = force,    Σ y_i F_i = moment

over the two outermost fixed wheels, at y_i, each of which drags against its own rolling. Where the cart lists no two,
all is one drag against u. A wheel at (0, y) that drags by F more is `force = F`, `moment = y F`: a tight left wheel
turns a cart that rolls forward to the left.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, final

import numpy as np

from ..wheels import WheelSet
from .compiled import CompiledForce
from .effect import Parameter

LEAST_LEVER = 0.4
"""Of half the track: with a shorter one, both wheels drag."""
SHORTEST_LEVER = 0.05
"""m, where the track is not known."""
LONGEST_LEVER = 2.0
"""Of half the track: no wheel stands farther out, for all that is known of its drag."""


@final
@dataclass(frozen=True)
class WheelDragImbalance(CompiledForce):
    """Drag `force` (N) and yaw moment `moment` (N·m, positive: to the left when rolling forward)."""

    force: float = 0.0
    moment: float = 0.0

    name: ClassVar[str] = "wheel_drag_imbalance"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("force", "N", typical=3.0, lower=0.0),
        Parameter("moment", "N·m", typical=1.0),
    )
    signature: ClassVar[str] = "a yaw moment, flat in speed, that changes sign with the direction of rolling"

    def implausible(self, wheels: WheelSet, fastest: float) -> str:
        fixed = wheels.positions[~wheels.is_caster]
        half = float(np.ptp(fixed[:, 1])) / 2 if len(fixed) > 1 else 0.0
        lever = abs(self.moment) / max(self.force, 1e-9)
        if lever < max(LEAST_LEVER * half, SHORTEST_LEVER):
            return f"its moment is that of a lever of {lever:.2f} m, so that both wheels drag alike"
        if lever > LONGEST_LEVER * half > 0:
            return f"its moment is that of a lever of {lever:.2f} m, where no wheel is"
        return ""
