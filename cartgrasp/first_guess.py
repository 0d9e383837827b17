"""How sure a cart's numbers are before any data: what its file says of its first guess."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from .checks import MAX_NUMBER, listed, positive
from .errors import UsageError

PHYSICAL_NAMES = ("mass", "com_x", "com_y", "inertia")
"""Under which a body's numbers are told to people."""


@dataclass(frozen=True)
class FirstGuess:
    """Standard deviations by name (`mass`, `com_x`, `com_y`, `inertia`, `EFFECT.PARAMETER`; in each one's unit), and
    names that are known for sure and not estimated (or an effect's key, for all of its parameters)."""

    std: tuple[tuple[str, float], ...] = ()
    known: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        form = 'write std=(("mass", 2.0), …)'
        pairs = tuple(self.std.items() if isinstance(self.std, Mapping) else self.std)
        for pair in pairs:
            if not isinstance(pair, tuple) or len(pair) != 2 or not isinstance(pair[0], str):
                raise UsageError(f"first guess: std: {pair!r} is no name with its deviation; {form}")
            positive(f"first guess: std of {pair[0]}", pair[1], MAX_NUMBER, "what is sure stands under `known`")
        object.__setattr__(self, "std", pairs)
        form = 'write known=("mass",), names'
        object.__setattr__(self, "known", listed("first guess: known", self.known, str, form))
