"""`objective` of `PROBLEM.yaml`: named terms, each of which adds to the effort by the arms' weights."""

from __future__ import annotations

from collections.abc import Sequence

from cartgrasp.arms import Arm
from cartgrasp.model import CartModel

from ..allocation.allocation_template import AllocationTemplate
from ..objectives import Nothing, Objective, WeightedWrench
from .problem_schema import ADDITIONS, ObjectiveEntry
from .refusing import Refuse, refusing


def objective_of(entry: ObjectiveEntry, of: tuple[CartModel, Sequence[Arm]], refuse: Refuse) -> Objective:
    """What a term has against its numbers, or against this cart and these arms, is refused at its key."""
    in_order = sorted(ADDITIONS, key=lambda key: ADDITIONS[key].adds_unknowns)
    stated = {key: dict(values) for key in in_order if (values := getattr(entry, key)) is not None}
    if not (entry.effort or stated):
        raise refuse(["objective", "effort"], "without the effort nothing is left to minimise; add another term")
    objective: Objective = WeightedWrench() if entry.effort else Nothing()
    for key, values in stated.items():
        with refusing(refuse, "objective", key):
            objective = ADDITIONS[key](**values, base=objective)  # type: ignore[call-arg]  # a dataclass
            AllocationTemplate.of(*of, objective)
    return objective
