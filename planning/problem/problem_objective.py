"""`objective` of `PROBLEM.yaml`: named terms, each of which adds to the effort by the arms' weights."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from cartgrasp.arms import Arm
from cartgrasp.errors import FileError, UsageError
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

Refuse = Callable[[list[str | int], str], FileError]


def objective_of(entry: ObjectiveEntry, of: tuple[CartModel, Sequence[Arm]], refuse: Refuse) -> Objective:
    """What a term has against its numbers, or against this cart and these arms, is refused at its key."""
    objective: Objective = WeightedWrench() if entry.effort else Nothing()
    terms = _terms(entry)
    if not (entry.effort or terms):
        raise refuse(["objective", "effort"], "without the effort nothing is left to minimise; add another term")
    for key, add in terms:
        try:
            objective = add(objective)
            AllocationTemplate.of(*of, objective)
        except UsageError as error:
            raise refuse(["objective", key], str(error)) from error
    return objective


def _terms(entry: ObjectiveEntry) -> list[tuple[str, Callable[[Objective], Objective]]]:
    """Those that are stated, with what puts each on a base; the one with an unknown of its own last."""
    terms: list[tuple[str, Callable[[Objective], Objective]]] = []
    if (smooth := entry.smoothness) is not None:
        terms.append(("smoothness", lambda base: Smoothness(smooth.rate, base)))
    if (share := entry.load_share) is not None:
        terms.append(("load_share", lambda base: LoadShare(share.shares, share.weight, base)))
    if (torque := entry.least_joint_torque) is not None:
        terms.append(("least_joint_torque", lambda base: LeastJointTorque(torque.weight, base)))
    if (sideways := entry.least_side_force) is not None:
        terms.append(("least_side_force", lambda base: LeastSideForce(sideways.weight, base)))
    if (inner := entry.least_internal_force) is not None:
        x, y, z = inner.axis
        terms.append(("least_internal_force", lambda base: LeastInternalForce(inner.weight, (x, y, z), base)))
    if (worst := entry.worst_arm) is not None:
        terms.append(("worst_arm", lambda base: WorstArm(worst.weight, base)))
    return terms
