"""No cost at all, as `Lexicographic` may want it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from cartgrasp.arms import Arm
from cartgrasp.frames import Array

from .objective import Cost, Objective


class Nothing(Objective):
    """Costs nothing: a base for an objective that is to stand alone."""

    @property
    def looks_back(self) -> bool:
        return False

    def cost(self, arms: Sequence[Arm], previous: Array) -> Cost:
        return Cost(np.zeros(6 * len(arms)), np.zeros(6 * len(arms)))
