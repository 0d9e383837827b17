"""What each stage of a horizon costs with each choice of grips: one certified QP for each, or the reason why not.

A grip says which candidate of an arm holds, or `NO_CONTACT`: the arm is on its way to another and gives no wrench. The
programs of one choice of grips differ in the wrench alone, so each choice keeps one warm planner.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from cartgrasp.arms import Arm
from cartgrasp.errors import UsageError
from cartgrasp.frames import Array
from cartgrasp.model import CartModel

from ..planner import WrenchPlanner
from ..quadratic_program import EQUALITY_TOLERANCE, INFEASIBLE, OPTIMAL

NO_CONTACT = -1


@dataclass(frozen=True, eq=False)
class StageEfforts:
    """Effort (stages, choices) of each choice of grips (choices, n), infinite where there is none; no effort is below
    `bounds`, zero where no solver gave a verified answer. `solved` counts programs."""

    grips: Array
    efforts: Array
    bounds: Array
    solved: int


def stage_efforts(
    cart: CartModel, arms: Sequence[Arm], wrenches: Array, min_hand_distance: float = 0.0
) -> StageEfforts:
    """For planar wrenches (stages, 3) in {b}, and every choice of grips of all arms."""
    points = candidate_points(arms)
    choices = [range(NO_CONTACT, len(candidates)) for candidates in points.values()]
    grips = np.array(list(product(*choices)))
    asked, stage = np.unique(wrenches, axis=0, return_inverse=True)
    table = []
    for row in grips:
        holding = [(arm, grip) for arm, grip in zip(arms, row, strict=True) if grip != NO_CONTACT]
        if not holding:
            idle = np.abs(asked @ cart.basis_b).max(axis=1) <= EQUALITY_TOLERANCE
            table.append([np.where(idle, 0.0, np.inf)] * 2)
            continue
        planner = WrenchPlanner(cart, [arm for arm, _ in holding], min_hand_distance=min_hand_distance)
        held = {arm.name: points[arm.name][grip] for arm, grip in holding}
        table.append(list(np.array([_effort(planner, wrench, held) for wrench in asked]).T))
    efforts, bounds = (np.array(part).T[stage] for part in zip(*table, strict=True))
    return StageEfforts(grips, efforts, bounds, len(asked) * (len(grips) - 1))


def candidate_points(arms: Sequence[Arm]) -> dict[str, Array]:
    """Candidate points (m, 3) by arm; a schedule is made over points."""
    for arm in arms:
        if arm.contacts.segments:
            raise UsageError(f"schedule: arm {arm.name} may hold anywhere on a segment; list points of it instead")
    return {arm.name: np.array(arm.contacts.points) for arm in arms}


def _effort(planner: WrenchPlanner, wrench: Array, held: Mapping[str, Array]) -> tuple[float, float]:
    """The effort of a wrench (3,), and its bound."""
    plan = planner.plan(wrench, contacts=held)
    if plan.status == OPTIMAL and plan.effort is not None and plan.residuals is not None:
        gap = plan.residuals.gap * max(1.0, plan.effort)
        return plan.effort, max(0.0, plan.effort - gap)
    return np.inf, np.inf if plan.status == INFEASIBLE else 0.0
