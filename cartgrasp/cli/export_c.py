"""`cartgrasp export-c PROBLEM.yaml --out DIR`."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from planning.embedded import EmbeddedProblem, check_free, export_c
from planning.objectives import WeightedWrench
from planning.problem.problem_file import Problem, read_problem

from ..errors import UsageError
from ..frames import Array
from .output import print_json, say


def run(path: Path, out: Path, as_json: bool) -> int:
    problem = read_problem(path)
    check_free(out)
    if problem.relax > 0:
        raise UsageError(f"{path}: relax: C plans don't relax; leave the key out")
    contacts, chosen = _contacts(problem, path)
    if not isinstance(problem.objective, WeightedWrench):
        raise UsageError(f"{path}: objective: C plans have the least effort by the arms' weights; leave the key out")
    for key, value in (("confidence", problem.confidence), ("motion", problem.estimate)):
        if value is not None:
            raise UsageError(f"{path}: {key}: C plans are for a known cart at rest; leave the key out")
    try:
        embedded = EmbeddedProblem.of(problem.cart, problem.arms, contacts, problem.cart_limits)
    except UsageError as error:
        raise UsageError(f"{path}: {error}") from error
    export_c(embedded, out, problem.wrench)
    if chosen:
        say(f"contacts are the best for this problem's wrench: {', '.join(chosen)} may hold at others too")
    if as_json:
        arms = {name: {"contact": point.tolist(), "chosen": name in chosen} for name, point in contacts.items()}
        print_json({"folder": str(out), "arms": arms})
    else:
        print(f"wrote {out}; build and try it: make -C {out} check")
    return 0


def _contacts(problem: Problem, path: Path) -> tuple[Mapping[str, Array], list[str]]:
    """A point for each arm, and which arms had a choice."""
    sets = {arm.name: arm.contacts for arm in problem.arms}
    chosen = [name for name, contacts in sets.items() if contacts.segments or len(contacts.points) > 1]
    if not chosen:
        return {name: contacts.first for name, contacts in sets.items()}, []
    plan = problem.plan()
    if plan.is_usable:
        return plan.contacts, chosen
    if plan.nearest is not None:
        return plan.nearest.contacts, chosen
    why = plan.certificate.words if plan.certificate else plan.message
    raise UsageError(f"{path}: no contacts can be chosen for its wrench ({why}); give each arm one contact")
