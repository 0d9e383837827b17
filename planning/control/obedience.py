"""How much of what it is told each arm is felt to give, over the last moments; and which arms give little.

An arm that gives little is told no more than `PROBE` until it is felt to give that: what was meanwhile to be given
would all come at once when it is back.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from cartgrasp.contacts import ContactWrenches
from cartgrasp.frames import Array

MEMORY = 0.2
"""s, the time constant with which what was told and felt is forgotten."""
LOUD, LITTLE = 5.0, 0.25
"""N, rms of what is told, below which noise could be all that is felt; the share below which an arm gives little."""
PROBE, BACK = 5.0, 0.5
"""N; the share of it from which on an arm is back. One that is told less than half of this is no longer known to give
little."""


@dataclass(frozen=True)
class Obedience:
    """By arm, means of told · felt and of told · told, N², of forces; over how long (s); and the arms that give little,
    with the share that they are felt to give."""

    agreed: Mapping[str, float] = field(default_factory=dict)
    told: Mapping[str, float] = field(default_factory=dict)
    lasting: float = 0.0
    idle: Mapping[str, float] = field(default_factory=dict)

    def after(self, told: Mapping[str, Array], felt: Mapping[str, Array], duration: float) -> Obedience:
        """So many s later, in which arms were told to give wrenches (6,) in {a}, and felt to."""
        kept = math.exp(-duration / MEMORY)
        agreed, loud = dict(self.agreed), dict(self.told)
        for arm in felt.keys() & told.keys():
            fx, fy, fz = told[arm][:3].tolist()
            x, y, z = np.asarray(felt[arm], dtype=float)[:3].tolist()
            agreed[arm] = kept * agreed.get(arm, 0.0) + (1.0 - kept) * (fx * x + fy * y + fz * z)
            loud[arm] = kept * loud.get(arm, 0.0) + (1.0 - kept) * (fx * fx + fy * fy + fz * fz)
        return Obedience(agreed, loud, self.lasting + duration, self._idle(agreed, loud))

    def _idle(self, agreed: Mapping[str, float], loud: Mapping[str, float]) -> Mapping[str, float]:
        if self.lasting < MEMORY:
            return {}
        found = {}
        for arm, told in loud.items():
            least, share = (PROBE / 2.0, BACK) if arm in self.idle else (LOUD, LITTLE)
            if told > least**2 and abs(agreed[arm]) < share * told:  # a sensor of the other sign feels it, too
                found[arm] = agreed[arm] / told
        return found


def probed(given: ContactWrenches, idle: Collection[str]) -> ContactWrenches:
    """With no more than that of idle arms."""
    if not idle:
        return given
    wrenches = {name: probing(one) if name in idle else one for name, one in given.wrenches.items()}
    return replace(given, wrenches=wrenches)


def probing(wrench: Array) -> Array:
    """A wrench (6,) of which the force is `PROBE` at most."""
    force = float(np.linalg.norm(wrench[:3]))
    return wrench if force <= PROBE else PROBE / force * wrench
