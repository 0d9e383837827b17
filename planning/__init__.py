"""Planning: spread a desired planar wrench over the arms, with a proof. See `docs/architecture.md`."""

from __future__ import annotations

from typing import TYPE_CHECKING

from cartgrasp.lazy_names import lazy_names

if TYPE_CHECKING:
    from .allocation.allocation import Allocation, allocate, build_allocation
    from .contacts.contact_choice import SearchLimit
    from .limits import InternalForce, Skid, TipOver
    from .objectives import (
        LeastInternalForce,
        LeastJointTorque,
        Lexicographic,
        LoadShare,
        Nothing,
        Objective,
        Smoothness,
        WeightedWrench,
        WorstArm,
    )
    from .plan import Plan
    from .planner import WrenchPlanner
    from .quadratic_program import QPSolution, QuadraticProgram

__all__ = [
    "Allocation",
    "InternalForce",
    "LeastInternalForce",
    "LeastJointTorque",
    "Lexicographic",
    "LoadShare",
    "Nothing",
    "Objective",
    "Plan",
    "QPSolution",
    "QuadraticProgram",
    "SearchLimit",
    "Skid",
    "Smoothness",
    "TipOver",
    "WeightedWrench",
    "WorstArm",
    "WrenchPlanner",
    "allocate",
    "build_allocation",
]

_HOMES = {
    "allocation.allocation": "Allocation allocate build_allocation",
    "contacts.contact_choice": "SearchLimit",
    "limits": "InternalForce Skid TipOver",
    "objectives": "LeastInternalForce LeastJointTorque Lexicographic LoadShare Nothing Objective Smoothness "
    "WeightedWrench WorstArm",
    "plan": "Plan",
    "planner": "WrenchPlanner",
    "quadratic_program": "QPSolution QuadraticProgram",
}

__getattr__, __dir__ = lazy_names(globals(), _HOMES)
