"""Exact choice of contacts beside its convex relaxation in cvxpy, and how far apart they are."""

from __future__ import annotations

import numpy as np

from cartgrasp import Arm
from cartgrasp.frames import Array
from cartgrasp.friction import Friction
from planning import WrenchPlanner
from planning.contacts.contact_relaxation import relax_contact_choice

from .measuring import interleave
from .report import Result, Table, number, timed_table
from .scene import CART

PROBLEMS, POINTS = 60, 6
OURS, RELAXED = "WrenchPlanner.plan", "cvxpy, convex relaxation"
NOTE = f"""{PROBLEMS} drawn problems with {POINTS} points an arm, boxes, and a friction pyramid on half of the arms.
`gap` is (effort - bound) / max(1, effort), of the exact choice over the relaxation's bound, where a choice is feasible.
The planner is made and warmed up before."""


def run(rounds: int) -> Result:
    return Result("Convex relaxation of the contact choice", NOTE, tuple(_compare(n, rounds) for n in (1, 2)))


def _compare(n_arms: int, rounds: int) -> Table:
    random = np.random.default_rng(n_arms)
    problems = [_drawn(random, n_arms) for _ in range(PROBLEMS)]
    planners = [WrenchPlanner(CART, arms) for arms, _ in problems]
    gaps, agree = [], 0
    for planner, (arms, wrench) in zip(planners, problems, strict=True):
        planner.warm_up()
        plan, relaxed = planner.plan(wrench), relax_contact_choice(CART, arms, wrench)
        if plan.status == "optimal":
            gaps.append(relaxed.gap(plan.effort))
            agree += gaps[-1] < 1e-3
    run = interleave(
        {
            OURS: lambda k: planners[k % PROBLEMS].plan(problems[k % PROBLEMS][1]),
            RELAXED: lambda k: relax_contact_choice(CART, *problems[k % PROBLEMS]),
        },
        rounds,
    )
    extra = {
        "gap, median": {RELAXED: _percent(np.median(gaps))},
        "gap, largest": {RELAXED: _percent(np.max(gaps))},
        "below 0.1 %": {RELAXED: f"{agree} of {len(gaps)}"},
    }
    title = f"{n_arms} arm{'s' if n_arms > 1 else ''} ({len(gaps)} of {PROBLEMS} feasible)"
    return timed_table(title, run, OURS, "µs", extra)


def _drawn(random: np.random.Generator, n_arms: int) -> tuple[list[Arm], Array]:
    arms = []
    for i in range(n_arms):
        points = np.column_stack([np.full(POINTS, -0.25), random.uniform(-0.4, 0.4, POINTS), np.ones(POINTS)])
        friction = Friction(0.6, 4) if random.random() < 0.5 else None
        limits = {"force_limit": (40.0, 30.0, 30.0), "moment_limit": (4.0, 4.0, 3.0)}
        arms.append(Arm(f"arm{i}", points.tolist(), friction=friction, **limits))
    return arms, random.uniform([5.0, -5.0, -6.0], [35.0, 5.0, 6.0]) * n_arms


def _percent(share: float) -> str:
    return f"{number(100 * share)} %"
