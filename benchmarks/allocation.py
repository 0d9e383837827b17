"""`WrenchPlanner.plan` at given contacts, beside other solvers on the same programs."""

from __future__ import annotations

import numpy as np

from cartgrasp import Arm, CartModel
from cartgrasp.frames import Array
from planning import WrenchPlanner, build_allocation

from .measuring import Competitor, interleave
from .peers import PEERS, Solve, most
from .report import Result, Table, timed_table
from .scene import CART, hand

ARMS = (1, 2, 4)
KINDS = 40
BURST = 10
OURS = "WrenchPlanner.plan"
BARE = "daqp, bare"
RIGHT = 1e-6
NOTE = f"""6 unknowns an arm, 2 equalities, boxes, a friction pyramid of 4 sides an arm. Wrenches are drawn at 70 to
99 % of the most that the arms can give in a random direction, and in random order, so that a warm start seldom helps.
Ours, after `warm_up`, reads, checks, assembles, solves, verifies all KKT residuals and returns a `Plan`; before
`warm_up` it does the same by numpy and daqp. Peers get arrays that are ready, and update and solve only (Clarabel
and all through qpsolvers are built anew where contacts are new). `right` counts answers to {KINDS} programs that
differ from daqp's by at most {RIGHT:g} of the largest component, at a peer's default tolerances (piqp and proxqp 1e-9);
the pseudo-inverse is right where no limit binds. `over daqp` is the ratio of medians to bare daqp's."""


def run(rounds: int) -> Result:
    tables = []
    for n in ARMS:
        for fixed in (True, False):
            tables.append(_compare(n, fixed, rounds))
    return Result("Allocation at given contacts", NOTE, tuple(tables))


def _compare(n: int, fixed: bool, rounds: int) -> Table:
    random = np.random.default_rng(n)
    cart, arms = CART, _arms(n)
    home = np.array([arm.contacts.first for arm in arms])
    shift = random.uniform((0, -0.04, 0), (0, 0.04, 0), (KINDS, n, 3)) * (not fixed)
    places = [dict(zip((arm.name for arm in arms), home + s, strict=True)) for s in shift]
    wrenches = [_feasible_wrench(cart, arms, place, random) for place in places]
    programs = [build_allocation(cart, arms, p, w) for p, w in zip(places, wrenches, strict=True)]
    planner = WrenchPlanner(cart, arms)
    planner.warm_up()
    plans = [planner.plan(w, p) for w, p in zip(wrenches, places, strict=True)]
    ours = [np.concatenate(list(plan.wrenches.values())) for plan in plans]
    solvers = {peer.name: peer.build(programs, fixed) for peer in PEERS if peer.installed}
    exact = [solvers[BARE](k) for k in range(KINDS)]
    right = {name: _right([solve(k) for k in range(KINDS)], exact) for name, solve in solvers.items()}
    right[OURS] = _right(ours, exact)
    cold, given = WrenchPlanner(cart, arms), [None] * KINDS if fixed else places
    competitors: dict[str, Competitor] = {
        OURS: lambda k: planner.plan(wrenches[k % KINDS], given[k % KINDS]),
        "the same before warm_up": lambda k: cold.plan(wrenches[k % KINDS], given[k % KINDS]),
    }
    for name, solve in solvers.items():
        competitors[name] = _cycling(solve)
    title = f"{n} {'arm' if n == 1 else 'arms'}, {'only the wrench new' if fixed else 'wrench and contacts new'}"
    run = interleave(competitors, rounds, BURST)
    daqp = run.times[BARE].median
    over = {name: f"{times.median / daqp:.2f}" for name, times in run.times.items()}
    return timed_table(title, run, OURS, "µs", {"over daqp": over, "right": right})


def _arms(n: int) -> list[Arm]:
    return [hand(f"arm{i}", [(-0.25, y, 1.0)]) for i, y in enumerate(np.linspace(-0.2, 0.2, n + 2)[1:-1])]


def _feasible_wrench(
    cart: CartModel, arms: list[Arm], contacts: dict[str, Array], random: np.random.Generator
) -> Array:
    """(fx, 0, tau) at 70 to 99 % of the most in a random direction."""
    direction = np.array([1.0, 0.0, random.uniform(-0.5, 0.5)])
    share = most(build_allocation(cart, arms, contacts, direction)) * random.uniform(0.7, 0.99)
    return share * direction


def _cycling(solve: Solve) -> Competitor:
    return lambda k: solve(k % KINDS)


def _right(found: list[Array], exact: list[Array]) -> str:
    pairs = zip(found, exact, strict=True)
    near = sum(bool(np.abs(x - e).max() <= RIGHT * max(1.0, np.abs(e).max())) for x, e in pairs)
    return f"{near} of {len(exact)}"
