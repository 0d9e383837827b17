"""`objective` of `PROBLEM.yaml`: named terms, each of which adds to the effort by the arms' weights."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from cartgrasp.arms import Arm
from cartgrasp.model import CartModel

from ..allocation.allocation_template import AllocationTemplate
from ..objectives import (
    LeastInternalForce,
    LeastJointTorque,
    LeastSideForce,
    LoadShare,
    Nothing,
    Objective,
    Smoothness,
    WeightedWrench,
    WorstArm,
)
from .problem_schema import ObjectiveEntry
from .refusing import Refuse, refusing

TERMS: Mapping[str, Callable[..., Objective]] = {
    "smoothness": Smoothness,
    "load_share": LoadShare,
    "least_joint_torque": LeastJointTorque,
    "least_side_force": LeastSideForce,
    "least_internal_force": LeastInternalForce,
    "worst_arm": WorstArm,
}
"""In the order in which they are put on a base: the one with an unknown of its own last."""


def objective_of(entry: ObjectiveEntry, of: tuple[CartModel, Sequence[Arm]], refuse: Refuse) -> Objective:
    """What a term has against its numbers, or against this cart and these arms, is refused at its key."""
    stated = {key: dict(values) for key in TERMS if (values := getattr(entry, key)) is not None}
    if not (entry.effort or stated):
        raise refuse(["objective", "effort"], "without the effort nothing is left to minimise; add another term")
    objective: Objective = WeightedWrench() if entry.effort else Nothing()
    for key, values in stated.items():
        with refusing(refuse, "objective", key):
            objective = TERMS[key](**values, base=objective)
            AllocationTemplate.of(*of, objective)
    return objective
