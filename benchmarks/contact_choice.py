"""`WrenchPlanner.plan` where it has to choose the contacts too, with its proof, beside trying them all."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import product

import numpy as np

from cartgrasp import Arm, CartModel
from cartgrasp.frames import Array
from planning import WrenchPlanner
from planning.allocation_template import AllocationTemplate

from .measuring import Run, interleave
from .peers import bare_daqp
from .report import Result, Table, number, timed_table
from .scene import CART, hand

POINTS = 64
KINDS = 20
SPAN = (-0.25, 0.25)  # m, of the handle
APART = 0.1  # m, between hands
OURS = "WrenchPlanner.plan"
BRUTE = "brute force, bare daqp"
BRUTE_ROUNDS = {1: 20, 2: 3}
NOTE = f"""Points are {POINTS} an arm along a handle of 0.5 m, segments are the handle itself; two hands stay
{APART:g} m apart. Each call has another wrench; the planner begins with the contacts of its last call. Brute force
solves every choice of points by daqp alone, programs ready, no verification ({BRUTE_ROUNDS[1]} rounds for one arm,
{BRUTE_ROUNDS[2]} for two). Beside segments it tries the same {POINTS} points, which is not exact: `worse` is by how
much its effort is above ours, the largest over its wrenches."""


@dataclass(frozen=True, eq=False)
class Scene:
    name: str
    arms: tuple[Arm, ...]
    wrenches: Array

    @classmethod
    def of(cls, n: int, segments: bool) -> Scene:
        what = f"{n} segment{'s' * (n > 1)}" if segments else " x ".join([str(POINTS)] * n) + " points"
        random = np.random.default_rng(n)
        wrenches = random.uniform((5, 0, -6), (n * 55, 0, 6), (KINDS, 3))
        return cls(what, tuple(_arm(f"arm{i}", segments) for i in range(n)), wrenches)


def run(rounds: int) -> Result:
    scenes = [Scene.of(n, segments) for segments in (False, True) for n in (1, 2)]
    return Result("Choice of contacts", NOTE, tuple(_compare(scene, rounds) for scene in scenes))


def _compare(scene: Scene, rounds: int) -> Table:
    apart = APART if len(scene.arms) > 1 else 0.0
    planner = WrenchPlanner(CART, scene.arms, min_hand_distance=apart)
    planner.warm_up()
    plans = [planner.plan(wrench) for wrench in scene.wrenches]
    every = _every_program(CART, scene.arms)
    tried = min(rounds, BRUTE_ROUNDS[len(scene.arms)])
    brute = [every(scene.wrenches[k % KINDS]) for k in range(tried)]
    worse = max((b / plan.effort - 1 for b, plan in zip(brute, plans, strict=False) if plan.effort), default=np.nan)
    ours = interleave({OURS: lambda k: planner.plan(scene.wrenches[k % KINDS])}, rounds)
    theirs = interleave({BRUTE: lambda k: every(scene.wrenches[k % KINDS])}, tried)
    run = Run({**ours.times, **theirs.times}, rounds, (ours.load[0], theirs.load[1]))
    solved = [plan.choice.solved for plan in plans if plan.choice]
    extra = {
        "programs solved": {OURS: f"{number(float(np.median(solved)))} (most {max(solved)})"},
        "worse": {BRUTE: f"{max(worse, 0.0):.1e}"},
    }
    found = sum(plan.status == "optimal" for plan in plans)
    return timed_table(f"{scene.name} ({found} of {KINDS} wrenches feasible)", run, OURS, "ms", extra)


def _every_program(cart: CartModel, arms: tuple[Arm, ...]) -> Callable[[Array], float]:
    """A function from a wrench to the least effort over all choices of points that keep apart."""
    template = AllocationTemplate.of(cart, arms)
    line = np.column_stack([np.full(POINTS, -0.25), np.linspace(*SPAN, POINTS), np.ones(POINTS)])
    choices = [c for c in product(range(POINTS), repeat=len(arms)) if len(c) == 1 or _keep(line[list(c)])]
    cost = template.cost(np.zeros(template.n))
    zero = np.zeros(template.basis_b.shape[1])
    programs = [template.program(template.contact_rows(line[list(c)]), zero, cost) for c in choices]
    asked = list(programs)
    solve = bare_daqp(asked, False)

    def least(wrench: Array) -> float:
        target, best = template.basis_b.T @ wrench, np.inf
        for k, program in enumerate(programs):
            asked[k] = program.with_equality_value(target)
            x = solve(k)
            if np.abs(asked[k].equality[0].dot(x) - target).max() < 1e-6:
                best = min(best, float(x.dot(template.effort_weights * x)))
        return best

    return least


def _keep(points: Array) -> bool:
    return bool(np.linalg.norm(points[0] - points[1]) >= APART)


def _arm(name: str, segment: bool) -> Arm:
    if segment:
        return hand(name, segment=[(-0.25, y, 1.0) for y in SPAN])
    return hand(name, [(-0.25, y, 1.0) for y in np.linspace(*SPAN, POINTS)])
