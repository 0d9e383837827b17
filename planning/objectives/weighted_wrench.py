"""The default of the contract: `sum weight component²` over arms and axes, without a ½."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from cartgrasp.arms import Arm
from cartgrasp.frames import Array

from .objective import Cost, Objective


class WeightedWrench(Objective):
    @property
    def looks_back(self) -> bool:
        return False

    def cost(self, arms: Sequence[Arm], previous: Array) -> Cost:
        weights = np.concatenate([arm.weights for arm in arms])
        return Cost(weights, np.zeros(len(weights)))
