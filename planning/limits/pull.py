"""Hands that hold less when they pull, as a hook does: -fx <= bound."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np

from cartgrasp.arms import Arm
from cartgrasp.checks import MAX_FLOAT, number

from .limit import Limit, LimitRows


@final
@dataclass(frozen=True)
class Pull(Limit):
    """A hand pulls with `bound` (N) at most, against its x; it pushes with what else it can give."""

    bound: float

    def __post_init__(self) -> None:
        number("pull: bound", self.bound, 0.0, MAX_FLOAT, "give N")

    def rows(self, arm: Arm) -> LimitRows:
        row = np.array([[-1.0, 0.0, 0.0, 0.0, 0.0, 0.0]])
        return LimitRows(rows=row, limits=np.array([self.bound]), names=("pull upper",))
