"""One fixed wheel drags more than the other: a yaw moment whenever the cart rolls.

    fx = -Σ F_i sign(u - y_i r),    tau = Σ y_i F_i sign(u - y_i r),    Σ F_i = force,    Σ y_i F_i = moment

over the two outermost fixed wheels, at y_i, each of which drags against its own rolling. Where the cart lists no two,
all is one drag against u. A wheel at (0, y) that drags by F more is `force = F`, `moment = y F`: a tight left wheel
turns a cart that rolls forward to the left.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

from .compiled import CompiledForce
from .effect import Parameter


@final
@dataclass(frozen=True)
class WheelDragImbalance(CompiledForce):
    """Drag `force` (N) and yaw moment `moment` (N·m, positive: to the left when rolling forward)."""

    force: float = 0.0
    moment: float = 0.0

    name = "wheel_drag_imbalance"
    parameters = (
        Parameter("force", "N", typical=3.0, lower=0.0),
        Parameter("moment", "N·m", typical=1.0),
    )
    signature = "a yaw moment, flat in speed, that changes sign with the direction of rolling"
