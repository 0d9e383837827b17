"""Coulomb friction between a hand and what it holds."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .checks import number
from .errors import UsageError

EXACT = "exact"
MAX_FRICTION = 100.0


@dataclass(frozen=True)
class Friction:
    """Coulomb friction at a contact whose normal is {a}'s x; the arm only pushes (fx >= 0).

    `sides` is the number of sides of the pyramid inscribed in the cone, with edges at 2 pi k / sides from y,
    or "exact" for the cone itself.
    """

    mu: float
    sides: int | str = 4

    def __post_init__(self) -> None:
        object.__setattr__(self, "mu", number("friction: mu", self.mu, 0.0, MAX_FRICTION))
        if self.sides != EXACT and not (isinstance(self.sides, int | np.integer) and 3 <= self.sides <= 256):
            raise UsageError(f'friction: sides: {self.sides!r} is neither a whole number of 3 to 256 nor "exact"')
        object.__setattr__(self, "sides", self.sides if self.sides == EXACT else int(self.sides))
