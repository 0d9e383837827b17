"""Planning: spread a desired planar wrench over the arms, with a proof. See `docs/architecture.md`."""

from __future__ import annotations

from .allocation import Allocation, allocate, build_allocation
from .contact_choice import SearchLimit
from .objectives import LoadShare, Objective, Smoothness, WeightedWrench
from .plan import Plan
from .planner import WrenchPlanner
from .quadratic_program import QPSolution, QuadraticProgram

__all__ = [
    "Allocation",
    "LoadShare",
    "Objective",
    "Plan",
    "QPSolution",
    "QuadraticProgram",
    "SearchLimit",
    "Smoothness",
    "WeightedWrench",
    "WrenchPlanner",
    "allocate",
    "build_allocation",
]
