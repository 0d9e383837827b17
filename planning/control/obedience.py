"""How much of what it is told each arm is felt to give, over the last moments."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from cartgrasp.frames import Array

MEMORY = 0.2
"""s, the time constant with which what was told and felt is forgotten."""
LOUD, LITTLE = 5.0, 0.25
"""N, rms of what is told, below which noise could be all that is felt; the share below which an arm gives little."""


@dataclass(frozen=True)
class Obedience:
    """By arm, means of told · felt and of told · told, N², of forces; and over how long (s)."""

    agreed: Mapping[str, float] = field(default_factory=dict)
    told: Mapping[str, float] = field(default_factory=dict)
    lasting: float = 0.0

    def after(self, told: Mapping[str, Array], felt: Mapping[str, Array], duration: float) -> Obedience:
        """So many s later, in which arms were told to give wrenches (6,) in {a}, and felt to."""
        kept = math.exp(-duration / MEMORY)
        agreed, loud = dict(self.agreed), dict(self.told)
        for arm in felt.keys() & told.keys():
            fx, fy, fz = told[arm][:3].tolist()
            x, y, z = np.asarray(felt[arm], dtype=float)[:3].tolist()
            agreed[arm] = kept * agreed.get(arm, 0.0) + (1.0 - kept) * (fx * x + fy * y + fz * z)
            loud[arm] = kept * loud.get(arm, 0.0) + (1.0 - kept) * (fx * fx + fy * fy + fz * fz)
        return Obedience(agreed, loud, self.lasting + duration)

    @cached_property
    def idle(self) -> Mapping[str, float]:
        """The arms that give little, with the share that they are felt to give."""
        if self.lasting < MEMORY:
            return {}
        shares = {arm: self.agreed[arm] / told for arm, told in self.told.items() if told > LOUD**2}
        return {arm: share for arm, share in shares.items() if share < LITTLE}
