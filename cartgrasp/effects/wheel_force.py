"""What wheels do, which depends on where casters point.

A caster's heading follows from how its pivot moves (`kernels/casters.py`). It is one memory, whichever effects look at
it; at first it is taken to be ahead. Carts that list no casters have none.
"""

from __future__ import annotations

from ..wheels import WheelSet
from .compiled import CompiledForce


class WheelForce(CompiledForce):
    """A force effect with a kernel that acts at each wheel, along its heading or across."""

    drives_memory = False

    @property
    def memory_numbers(self) -> tuple[float, ...]:
        return ()

    def memory_names(self, wheels: WheelSet) -> tuple[str, ...]:
        count = len(wheels.pivots) if wheels.lists_casters else 0
        return tuple(f"caster{i + 1}.heading" for i in range(count))
