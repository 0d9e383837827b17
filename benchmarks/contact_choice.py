"""`WrenchPlanner.plan` where it has to choose the contacts too, with its proof, beside trying them all."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cache
from itertools import product

import numpy as np

from cartgrasp import Arm
from cartgrasp.frames import Array
from planning import WrenchPlanner, build_allocation
from planning.allocation.allocation_template import AllocationTemplate

from .measuring import Run, interleave
from .peers import bare_daqp, most
from .report import Result, Table, number, timed_table
from .scene import CART, hand

KINDS = 20
SPAN = (-0.25, 0.25)  # m, of the handle
APART = 0.1  # m, between hands
OURS = "WrenchPlanner.plan"
BRUTE = "brute force, bare daqp"
COARSE = 9
MOST_TRIED = 20_000  # programs that brute force may solve for a table
NOTE = f"""Points stand along a handle of 0.5 m, segments are the handle itself; two hands stay {APART:g} m apart.
Wrenches have random directions and a share of the most that the arms can give in that direction, at the best of
{COARSE} points on each handle. Each call has another wrench; the planner begins with the contacts of its last call.
Brute force solves every choice of points by daqp alone, programs ready, no verification, for as many rounds as
{MOST_TRIED:,} programs allow. Beside segments it tries 64 points on each, which is not exact: `worse` is by how much
its effort is above ours, the largest over its wrenches, and `gap` is the largest relative gap that our proofs leave."""


@dataclass(frozen=True, eq=False)
class Scene:
    """Arms with `points` candidates each (on segments: what brute force tries), and shares of the most."""

    n_arms: int
    points: int
    shares: tuple[float, float]
    segments: bool = False

    @property
    def name(self) -> str:
        what = ["segment" if self.segments else f"{self.points:,}"] * self.n_arms
        low, high = (round(100 * share) for share in self.shares)
        return f"{' x '.join(what)}{'' if self.segments else ' points'}, at {low} to {high} % of the most"

    @property
    def distance(self) -> float:
        return APART if self.n_arms > 1 else 0.0

    @property
    def line(self) -> Array:
        ys = np.linspace(*SPAN, self.points)
        return np.column_stack([np.full(self.points, -0.25), ys, np.ones(self.points)])

    @property
    def arms(self) -> list[Arm]:
        if self.segments:
            return [hand(f"arm{i}", segment=self.line[[0, -1]].tolist()) for i in range(self.n_arms)]
        return [hand(f"arm{i}", self.line.tolist()) for i in range(self.n_arms)]

    def wrenches(self) -> Array:
        random = np.random.default_rng(self.n_arms)
        return _strongest(self.n_arms) * random.uniform(*self.shares, (KINDS, 1))


SCENES = (
    Scene(1, 64, (0.1, 0.9)),
    Scene(1, 1024, (0.1, 0.9)),
    Scene(2, 64, (0.1, 0.9)),
    Scene(2, 64, (0.9, 1.0)),
    Scene(2, 128, (0.1, 0.9)),
    Scene(1, 64, (0.1, 0.9), segments=True),
    Scene(2, 64, (0.1, 0.9), segments=True),
)


def run(rounds: int) -> Result:
    return Result("Choice of contacts", NOTE, tuple(_compare(scene, rounds) for scene in SCENES))


@cache
def _strongest(n_arms: int) -> Array:
    """In random directions, the most that is feasible at some choice of points, (KINDS, 3)."""
    coarse, random = Scene(n_arms, COARSE, (1.0, 1.0)), np.random.default_rng(n_arms)
    arms, found = coarse.arms, []
    choices = [{a.name: point for a, point in zip(arms, points, strict=True)} for points in _kept(coarse)]
    for moment in random.uniform(-0.25, 0.25, KINDS):
        direction = np.array([1.0, 0.0, moment])
        found.append(max(most(build_allocation(CART, arms, c, direction)) for c in choices) * direction)
    return np.array(found)


def _compare(scene: Scene, rounds: int) -> Table:
    planner = WrenchPlanner(CART, scene.arms, min_hand_distance=scene.distance)
    planner.warm_up()
    wrenches = scene.wrenches()
    plans = [planner.plan(wrench) for wrench in wrenches]
    every = _every_program(scene)
    tried = max(1, min(rounds, MOST_TRIED // scene.points**scene.n_arms))
    brute = [every(wrenches[k % KINDS]) for k in range(tried)]
    worse = max(b / plan.effort - 1 for b, plan in zip(brute, plans, strict=False) if plan.effort)
    ours = interleave({OURS: lambda k: planner.plan(wrenches[k % KINDS])}, rounds)
    theirs = interleave({BRUTE: lambda k: every(wrenches[k % KINDS])}, tried)
    run = Run({**ours.times, **theirs.times}, rounds, (ours.load[0], theirs.load[1]))
    proofs = [plan.choice for plan in plans if plan.choice]
    solved = [proof.solved for proof in proofs]
    extra = {
        "programs solved": {OURS: f"{number(float(np.median(solved)))} (most {max(solved)})"},
        "gap": {OURS: f"{max(proof.gap for proof in proofs):.1e}"},
        "worse": {BRUTE: f"{worse:.1e}"},
    }
    found = sum(plan.status == "optimal" for plan in plans)
    return timed_table(f"{scene.name} ({found} of {KINDS} planned)", run, OURS, "µs", extra)


def _every_program(scene: Scene) -> Callable[[Array], float]:
    """A function from a wrench to the least effort over all choices of points that keep apart."""
    template = AllocationTemplate.of(CART, scene.arms)
    cost = template.cost(np.zeros(template.n))
    zero = np.zeros(template.basis_b.shape[1])
    programs = [template.program(template.contact_rows(points), zero, cost) for points in _kept(scene)]
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


def _kept(scene: Scene) -> Iterator[Array]:
    """Every choice of points (n, 3) that keeps the hands apart."""
    for points in product(scene.line, repeat=scene.n_arms):
        if len(points) == 1 or np.linalg.norm(points[0] - points[1]) >= APART:
            yield np.array(points)
