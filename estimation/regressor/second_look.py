"""Blocks that came before the parameters were known well enough to work them out: the rest of them is taken in later.

Load times friction is no linear function of the parameters, and while both are hardly known, what a row leaves out
(`curvature_noise`) may be many times its noise: a first push, half of what a straight run can teach, would be worth
nothing. So a row's likelihood is taken in as two powers of it: at once as much as its curvature lets through, and the
rest, of exponent `left`, worked out anew around parameters that are known better by then.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from cartgrasp.frames import Array

from .filtered_row import FilteredRow, Recorded
from .motion_tracker import Stretch

BLURRED = 0.3
"""Curvature, as a share of the noise of a row, up to which it is worked out well enough."""
MOST_WAITING = 40
"""Blocks: six seconds."""
AT_ONCE = 2
"""Blocks that are looked at again with each new one."""


@dataclass(frozen=True)
class Block:
    """What a row is worked out from: smoothed motion of n moments, memory (n, k), and wrenches (n - 1)."""

    motion: Stretch
    memory: Array
    recorded: Sequence[Recorded]


@dataclass(frozen=True)
class Waiting:
    """A block with the exponent of its likelihood that is left to be taken in."""

    block: Block
    left: float


def blur(row: FilteredRow, curvature: Array) -> float:
    """Curvature (f, f) by the row's own noise, where it is largest."""
    return float(np.linalg.eigvals(np.linalg.solve(row.noise, curvature)).real.max())


def left_after(blurred: float) -> float:
    """The exponent left of a likelihood whose noise was taken to be `1 + blurred` times as large."""
    return blurred / (1.0 + blurred)


def rest_of(row: FilteredRow, curvature: Array, left: float) -> FilteredRow:
    """The row to the power `left`."""
    return replace(row, noise=row.noise / left + curvature, feigned=left * row.feigned)
