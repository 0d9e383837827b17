"""When a load was taken to have changed."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

RESET_HOLD_OFF = 1.5
"""s after another load in which it is called changed, and none is looked for again. After a push, or what was not told
apart, the next surprise is looked at at once."""
MAX_RESETS, RESET_WINDOW = 3, 20.0
"""So many in so long (s), and it is the model that does not fit. That is said for a hold-off longer, in which it may
show again: else a model that never fits would be called sound for a moment."""


@dataclass(frozen=True)
class Resets:
    """Those that are remembered, and the time `now` (s) where there are any; with that of the last load."""

    times: tuple[float, ...] = ()
    now: float = -math.inf
    load: float = -math.inf

    def at(self, time: float) -> Resets:
        """Later, with nothing new."""
        if not self.times:
            return self
        return replace(self, times=tuple(t for t in self.times if time - t < RESET_WINDOW + RESET_HOLD_OFF), now=time)

    def one_more(self, time: float, *, is_load: bool = True) -> Resets:
        """Now; or a push, which says as much against a model, and changes no load."""
        return Resets((*self.times, time), time, time if is_load else self.load)

    @property
    def are_allowed(self) -> bool:
        return sum(self.now - t < RESET_WINDOW for t in self.times) < MAX_RESETS and not self.has_new_load

    @property
    def are_too_many(self) -> bool:
        """For a model that fits."""
        return len(self.times) >= MAX_RESETS

    @property
    def has_new_load(self) -> bool:
        """Since a short while."""
        return self.now - self.load < RESET_HOLD_OFF
