"""One objective first, and among all that are best by it, the best by a second."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from cartgrasp.arms import Arm
from cartgrasp.checks import check_kind
from cartgrasp.errors import UsageError
from cartgrasp.frames import Array

from .objective import Cost, Objective


@dataclass(frozen=True)
class Lexicographic(Objective):
    """`first` decides, contacts too; `second` decides what `first` leaves open (give `first` the base `Nothing()`,
    or it leaves nothing open). A second program is solved for it (planning/allocation/second_stage.py)."""

    first: Objective
    second: Objective

    def __post_init__(self) -> None:
        for one in (self.first, self.second):
            check_kind("lexicographic", one, Objective, "write Lexicographic(WorstArm(), WeightedWrench())")
        if isinstance(self.first, Lexicographic) or isinstance(self.second, Lexicographic):
            raise UsageError("lexicographic: an order of two; neither may be an order itself")

    @property
    def looks_back(self) -> bool:
        return self.first.looks_back or self.second.looks_back

    def cost(self, arms: Sequence[Arm], previous: Array) -> Cost:
        """The first's."""
        return self.first.cost(arms, previous)

    def second_cost(self, arms: Sequence[Arm], previous: Array) -> Cost:
        """Over the unknowns of the first's program."""
        second = self.second.cost(arms, previous)
        if second.epigraph is not None and self.first.cost(arms, previous).epigraph is None:
            raise UsageError("lexicographic: the second objective has an unknown of its own (WorstArm); put it first")
        return second
