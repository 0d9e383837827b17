"""Blocks that came before the parameters were known well enough to work them out are taken in once more, later.

Load times friction is no linear function of the parameters, and while both are hardly known, what a row leaves out
(`FilteredRow.curvature`) may be many times its noise: a first push, half of what a straight run can teach, would be
worth nothing. So what was believed before the first such block is kept, with all blocks since. Once they can be worked
out, they are taken in anew from there, in their order, since neighbours share what is wrong with the motion between
them; what comes out replaces what the first look gave.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..kernels.filtered_row import FilteredRow
from .filtered_row import Block
from .regression_belief import RegressionBelief

BLURRED = 0.1
"""Curvature, as a share of the noise of a row, up to which it is worked out well enough."""
MOST_WAITING = 60
"""Blocks after which they are worked out as well as may be."""
AT_ONCE = 3
"""Blocks that are looked at again with each new one."""


@dataclass(frozen=True)
class SecondLook:
    """`belief` has taken in what is no longer among the blocks `left`; None stands for a gap. It is `due` once they
    can be worked out."""

    belief: RegressionBelief
    left: tuple[Block | None, ...] = ()
    due: bool = False

    def and_then(self, block: Block | None) -> SecondLook:
        """With another block to come, or a gap."""
        return replace(self, left=(*self.left, block))

    @property
    def is_over(self) -> bool:
        return self.due and not self.left


def blur(row: FilteredRow) -> float:
    """Curvature by the row's own noise, where it is largest: an eigenvalue."""
    scale = np.sqrt(np.diagonal(row.noise))
    root = np.linalg.inv(np.linalg.cholesky(row.noise / np.outer(scale, scale))) / scale
    return float(np.linalg.eigvalsh(root @ row.curvature @ root.T)[-1])
