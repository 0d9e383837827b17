"""Planning: references, the tracking law, and a desired planar wrench spread over the arms, with a proof."""

from __future__ import annotations

from typing import TYPE_CHECKING

from cartgrasp.lazy_names import lazy_names

if TYPE_CHECKING:
    from .allocation.allocation import Allocation, allocate, build_allocation
    from .contact_sources.choosing import Choosing
    from .contacts.contact_choice import SearchLimit
    from .control.caution import Caution
    from .control.controller import Controller
    from .control.hand import RegraspTimes
    from .control.rejection import Rejection
    from .embedded import EmbeddedProblem, export_c
    from .excitation.excitation_choice import Allowance, ExcitationChooser
    from .excitation.excitation_plan import plan_excitation
    from .limits import (
        CartLimit,
        CartRows,
        FloorLimit,
        FloorRows,
        InternalForce,
        Limit,
        LimitRows,
        Pull,
        PushedCart,
        SideForce,
        Skid,
        TipOver,
    )
    from .objectives import (
        LeastInternalForce,
        LeastJointTorque,
        LeastSideForce,
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
    from .polytopes.wrench_polytope import WrenchPolytope
    from .quadratic_program import QPSolution, QuadraticProgram
    from .references import PathReference, Stretch, chain, pause, speed_change, straight, turn
    from .schedule.schedule import Grip, Horizon, RegraspCost, plan_schedule
    from .tracking import DirectTracker, Gains, SteeringTracker, build_tracker

__all__ = [
    "Allocation",
    "Allowance",
    "CartLimit",
    "CartRows",
    "Caution",
    "Choosing",
    "Controller",
    "DirectTracker",
    "EmbeddedProblem",
    "ExcitationChooser",
    "FloorLimit",
    "FloorRows",
    "Gains",
    "Grip",
    "Horizon",
    "InternalForce",
    "LeastInternalForce",
    "LeastJointTorque",
    "LeastSideForce",
    "Lexicographic",
    "Limit",
    "LimitRows",
    "LoadShare",
    "Nothing",
    "Objective",
    "PathReference",
    "Plan",
    "Pull",
    "PushedCart",
    "QPSolution",
    "QuadraticProgram",
    "RegraspCost",
    "RegraspTimes",
    "Rejection",
    "SearchLimit",
    "SideForce",
    "Skid",
    "Smoothness",
    "SteeringTracker",
    "Stretch",
    "TipOver",
    "WeightedWrench",
    "WorstArm",
    "WrenchPlanner",
    "WrenchPolytope",
    "allocate",
    "build_allocation",
    "build_tracker",
    "chain",
    "export_c",
    "pause",
    "plan_excitation",
    "plan_schedule",
    "speed_change",
    "straight",
    "turn",
]

_HOMES = {
    "allocation.allocation": "Allocation allocate build_allocation",
    "contact_sources.choosing": "Choosing",
    "contacts.contact_choice": "SearchLimit",
    "control.caution": "Caution",
    "control.rejection": "Rejection",
    "control.controller": "Controller",
    "control.hand": "RegraspTimes",
    "embedded": "EmbeddedProblem export_c",
    "excitation.excitation_choice": "Allowance ExcitationChooser",
    "excitation.excitation_plan": "plan_excitation",
    "limits": "CartLimit CartRows FloorLimit FloorRows InternalForce Limit LimitRows Pull PushedCart SideForce Skid "
    "TipOver",
    "objectives": "LeastInternalForce LeastJointTorque LeastSideForce Lexicographic LoadShare Nothing Objective "
    "Smoothness WeightedWrench WorstArm",
    "plan": "Plan",
    "planner": "WrenchPlanner",
    "quadratic_program": "QPSolution QuadraticProgram",
    "references": "PathReference Stretch chain pause speed_change straight turn",
    "schedule.schedule": "Grip Horizon RegraspCost plan_schedule",
    "tracking": "DirectTracker Gains SteeringTracker build_tracker",
    "polytopes.wrench_polytope": "WrenchPolytope",
}

__getattr__, __dir__ = lazy_names(globals(), _HOMES)
