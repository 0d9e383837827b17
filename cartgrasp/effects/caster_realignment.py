"""Casters that swing round after a change of direction (physics.md; the paper's experiment E5).

A caster at pivot p trails its wheel by b. Its heading delta in {b} is a memory; the wheel does not slip
sideways at its patch p - b (cos delta, sin delta), so

    delta' = (v_p · n) / b - r,    n = (-sin delta, cos delta),    v_p = (u - y r, w + x r),

which for r = 0 is the trail model psi' = -(v/b) sin psi. Swivel friction T against delta' is balanced by a
side force F_n = -(T/b) sign(delta') n at the patch: the wrench on the cart. Its power is -T |delta'|, so it
never gives energy; along the motion it is the drag (T/b) |sin psi|. A swivel that has come to rest, in a steady turn
or on a straight line, is stuck, and keeps some torque of up to T until it is next turned: seconds.

The wheel's tyre scrubs: its patch resists turning on the floor, at r + delta' = (v_p · n) / b, with a torque S. That is
balanced by a side force -(S/b) sign(r + delta') n, and the floor's torque acts on the cart, too: together they are that
force at the pivot. In a steady turn a swivel rests, and a tyre scrubs on, which looks like a CoM that is farther ahead:
with a tenth to three tenths of T, by 10 cm.

A cart that lists no casters has one for all of them, `x` ahead of {b}'s origin. A search finds how far that is; that it
is ahead, and not behind, hardly shows.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

from ..wheels import DEFAULT_TRAIL, WheelSet
from .compiled import WheelForce
from .effect import Parameter

DEFAULT_SMOOTHING_RATE = 0.2
"""rad/s: usual `smoothing_rate`."""
MIN_SMOOTHING_RATE = 0.01
"""rad/s: Coulomb's friction has none; the smaller it is, the stiffer is the model."""
TYPICAL_CASTER_X = 0.8
"""m."""


@final
@dataclass(frozen=True)
class CasterRealignment(WheelForce):
    """Swivel friction `swivel_torque` (N·m, each) of casters with `trail` (m; 0: as listed in wheels), that stand `x`
    (m) ahead of where they are listed, and `scrub_torque` (N·m, each) of their tyres on the floor. Both fade where
    casters turn slower than `smoothing_rate` (rad/s)."""

    swivel_torque: float = 0.0
    trail: float = 0.0
    x: float = 0.0
    scrub_torque: float = 0.0
    smoothing_rate: float = DEFAULT_SMOOTHING_RATE

    name = "caster_realignment"
    parameters = (
        Parameter("swivel_torque", "N·m", typical=0.3, lower=0.0),
        Parameter("trail", "m", typical=0.01, lower=0.0, upper=1.0, estimated=False, grid=(DEFAULT_TRAIL,)),
        Parameter("x", "m", typical=0.3, lower=-10.0, upper=10.0, estimated=False, grid=(TYPICAL_CASTER_X,)),
        Parameter("scrub_torque", "N·m", typical=0.05, lower=0.0, optional=True),
        Parameter(
            "smoothing_rate",
            "rad/s",
            typical=0.1,
            lower=MIN_SMOOTHING_RATE,
            upper=1.0,
            absent=DEFAULT_SMOOTHING_RATE,
            optional=True,
            grid=(DEFAULT_SMOOTHING_RATE,),
        ),
    )
    drives_memory = True
    stuck_for = 4.0
    signature = "drag and yaw moment within some trails of travel after a reversal"

    def grids(self, wheels: WheelSet) -> tuple[tuple[float, ...], ...]:
        """Nobody looks for casters that are listed."""
        return ((),) * len(self.parameters) if wheels.is_caster.any() else super().grids(wheels)

    @property
    def memory_numbers(self) -> tuple[float, ...]:
        return self.trail, self.x

    def memory_names(self, wheels: WheelSet) -> tuple[str, ...]:
        return super().memory_names(wheels) if wheels.lists_casters else (f"{self.key}.heading",)
