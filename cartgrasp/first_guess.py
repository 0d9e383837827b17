"""How sure a cart's numbers are before any data: what its file says of its first guess."""

from __future__ import annotations

from dataclasses import dataclass

PHYSICAL_NAMES = ("mass", "com_x", "com_y", "inertia")
"""Under which a body's numbers are told to people."""


@dataclass(frozen=True)
class FirstGuess:
    """Standard deviations by name (`mass`, `com_x`, `com_y`, `inertia`, `EFFECT.PARAMETER`; in each one's unit), and
    names that are known for sure and not estimated (or an effect's key, for all of its parameters)."""

    std: tuple[tuple[str, float], ...] = ()
    known: tuple[str, ...] = ()
