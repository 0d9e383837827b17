"""The default of the contract."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from cartgrasp.arms import Arm
from cartgrasp.frames import Array

from .objective import Cost, Objective


class WeightedWrench(Objective):
    """The effort: the sum of each arm's `weights` times component squared, over arms and axes (N², without a ½)."""

    @property
    def looks_back(self) -> bool:
        return False

    def cost(self, arms: Sequence[Arm], previous: Array) -> Cost:
        weights = np.concatenate([arm.weights for arm in arms])
        return Cost(weights, np.zeros(len(weights)))
