"""`cartgrasp plan PROBLEM.yaml`."""

from __future__ import annotations

from pathlib import Path

from planning import Plan
from planning.plan import INVALID_INPUT
from planning.problem.problem_file import read_problem

from ..errors import UsageError
from .output import print_json, print_table


def run(path: Path, as_json: bool) -> int:
    problem = read_problem(path)
    plan = problem.plan()
    if as_json:
        print_json(plan.as_dict())
    elif plan.status != INVALID_INPUT:
        _print(plan)
    if plan.status == INVALID_INPUT:
        raise UsageError(f"{path}: {plan.message}")
    return 0 if plan.is_usable else 1


def _print(plan: Plan) -> None:
    wrenches, contacts = plan.wrenches, plan.contacts
    if plan.status != "optimal":
        print(f"{plan.status}: {plan.certificate.words if plan.certificate else plan.message}")
        if plan.nearest is None:
            return
        if plan.missing:
            print(
                "left out of what is asked: " + ", ".join(f"{row} {value:.4g}" for row, value in plan.missing.items())
            )
        fx, fy, tau = plan.nearest.wrench
        print(f"nearest feasible wrench on the cart: fx {fx:.4g} N, fy {fy:.4g} N, moment {tau:.4g} N·m")
        wrenches, contacts = plan.nearest.wrenches, plan.nearest.contacts
    rows = [
        [name, " ".join(f"{v:.3f}" for v in contacts[name]), *(f"{v:.3f}" for v in wrench)]
        for name, wrench in wrenches.items()
    ]
    columns = ["arm", "contact (m)", "fx (N)", "fy", "fz", "tx (N·m)", "ty", "tz"]
    print_table("Wrench of each arm in its contact frame", columns, rows, left=2)
    if plan.is_usable:
        print(f"effort {plan.effort:.6g}; active: {', '.join(plan.active) or 'no limit'}")
        if plan.cart_wrench is not None and plan.wheel_side_force is not None:
            fx, fy, tau = plan.cart_wrench
            beside = f"the fixed wheels take {plan.wheel_side_force:.4g} N to their left"
            if plan.wheel_loads is not None:
                beside += f", wheels carry {', '.join(f'{load:.4g}' for load in plan.wheel_loads)} N"
            print(f"on the cart: fx {fx:.4g} N, fy {fy:.4g} N, moment {tau:.4g} N·m; {beside}")
        if plan.switched:
            print(f"hold elsewhere than before: {', '.join(plan.switched)}")
        residuals = {} if plan.residuals is None else plan.residuals.as_dict()
        print("residuals: " + ", ".join(f"{name} {value:.1e}" for name, value in residuals.items()))
        if plan.margins:
            name = min(plan.margins, key=lambda limit: plan.margins[limit])
            print(f"smallest margin: {plan.margins[name]:.4g} to {name}")
        print(f"solved in {1e6 * plan.solve_time:.0f} µs by {plan.solver}")
