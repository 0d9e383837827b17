"""Costs of objectives from outside are looked at before a solver sees them: one that isn't convex would be `optimal` at
its worst, with a proof, and numbers that are none would end in a solver's error."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from cartgrasp.arms import Arm
from cartgrasp.checks import check_kind
from cartgrasp.errors import UsageError

from .lexicographic import Lexicographic
from .objective import Cost, Objective

CONVEXITY_TOLERANCE = 1e-9  # of the largest eigenvalue: rounding of a coupling that is a product


def check_costs(objective: Objective, arms: Sequence[Arm]) -> None:
    """Refuses what is no convex cost of these arms at the first tick. The library's own are taken as read."""
    stages = (objective.first, objective.second) if isinstance(objective, Lexicographic) else (objective,)
    for stage in stages:
        if _is_from_outside(stage):
            what = f"objective: {type(stage).__name__}: cost"
            cost = stage.cost(arms, np.zeros(6 * len(arms)))
            check_kind(what, cost, Cost, "return Cost(weights, gradient)")
            _check(what, cost, 6 * len(arms) + (0 if cost.epigraph is None else len(cost.epigraph.lower)))


def _is_from_outside(objective: Objective | None) -> bool:
    """Whether it or a base of it is."""
    if objective is None:
        return False
    own = type(objective).__module__.startswith(f"{__package__}.")
    return not own or _is_from_outside(getattr(objective, "base", None))


def _check(what: str, cost: Cost, n: int) -> None:
    shapes = {"weights": (n,), "gradient": (n,)} | ({} if cost.coupling is None else {"coupling": (n, n)})
    for part, shape in shapes.items():
        values = getattr(cost, part)
        if not isinstance(values, np.ndarray) or values.shape != shape or values.dtype.kind != "f":
            raise UsageError(f"{what}: {part} is not an array {shape} of floats; give one number for each unknown")
        if not np.isfinite(values).all():
            raise UsageError(f"{what}: {part} has a number that is not finite")
    if (cost.weights < 0).any():
        raise UsageError(f"{what}: weights: {cost.weights.min():g} is negative, so nothing is best; give numbers >= 0")
    if cost.coupling is None:
        return
    eigenvalues = np.linalg.eigvalsh(cost.coupling)
    room = CONVEXITY_TOLERANCE * max(float(np.abs(cost.coupling).max()), float(eigenvalues[-1]))
    if np.abs(cost.coupling - cost.coupling.T).max() > room or eigenvalues[0] < -room:
        raise UsageError(f"{what}: coupling is not symmetric and positive semidefinite; give a sum of a @ a.T")
