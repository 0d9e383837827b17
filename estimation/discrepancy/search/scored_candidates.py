"""What a search tried, and what came of it."""

from __future__ import annotations

from dataclasses import dataclass

from cartgrasp.effects import Effect
from cartgrasp.effects.effect import Gate

from .laws import Law
from .model import Model
from .plausibility import UBIQUITOUS_EFFECTS


@dataclass(frozen=True)
class Refit:
    """An effect of the cart file has another size than it says."""

    effect: Effect

    @property
    def name(self) -> str:
        return self.effect.name

    @property
    def key(self) -> str:
        return f"{self.effect.key} refitted"


@dataclass(frozen=True, eq=False)
class ScoredCandidate:
    """A candidate with its gain, and the model with it where it was refitted, with the gain's standard error, the gain
    beside what the forms of others may leave (None: there are no others), of what is met once, beside noise that
    drifts as what is left does, and of what repeats, beside noise that wanders about its period."""

    candidate: Effect | Law | Refit
    gain: float
    tried: int
    model: Model | None = None
    error: float = 0.0
    beside_forms: float | None = None
    beside_drift: float | None = None
    beside_neighbours: float | None = None

    @property
    def own_gain(self) -> float:
        """The part of the gain that neither another effect's form makes, nor what drifts."""
        return min(one for one in (self.gain, self.beside_forms, self.beside_drift) if one is not None)

    def repeats(self, least: float) -> bool:
        """Whether it gains enough beside noise that wanders about its period; so does what has none."""
        return self.beside_neighbours is None or self.beside_neighbours >= least

    @property
    def key(self) -> str:
        return self.candidate.key

    @property
    def gate(self) -> Gate:
        """When and where it acts."""
        return self.candidate.gate if isinstance(self.candidate, Effect) else Gate.ALWAYS

    @property
    def is_usual(self) -> bool:
        """Whether every cart has it, or every chain of sensors."""
        return isinstance(self.candidate, Effect) and self.candidate.name in UBIQUITOUS_EFFECTS

    @property
    def numbers(self) -> int:
        if isinstance(self.candidate, Law):
            return self.candidate.size + 2
        if isinstance(self.candidate, Refit):
            return 0
        return len(self.candidate.parameters)


@dataclass(frozen=True, eq=False)
class SearchStep:
    """What was tried, best first; the one that was added (None: none was worth it); and what of the score the form of
    others may have left."""

    attempts: tuple[ScoredCandidate, ...]
    added: ScoredCandidate | None
    form_error: float = 0.0
