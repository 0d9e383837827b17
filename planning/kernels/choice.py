"""Contacts among single points of each arm: every solved program bounds all other choices (cut.py), the one of least
bound is solved next, and the search ends when no bound is below the best value found. An infeasible choice takes out
all those for which its ray proves the same."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from cartgrasp.frames import Array

from .allocation import ask, move, solve_program
from .cut import Table, effort_cut, ray_cut
from .dual_active_set import INFEASIBLE, OPTIMAL
from .jit import compiled, entry
from .proof import COST, EQUALITY_TOLERANCE, wrench_scale
from .working_set import Ints
from .workspace import Workspace, unpack

DONE, GAVE_UP = range(2)


class Progress(NamedTuple):
    """Best value and least bound left (2,); the choice of the best value (-1: none yet), the one to solve next (-1:
    none left) and how many have been solved (3,)."""

    values: Array
    counts: Ints


@entry
def search(
    floats: Array,
    ints: Ints,
    wrench: tuple[float, float, float],
    tables: tuple[Array, Ints, Array, Array, Array, Array, Array],
    progress: tuple[Array, Ints],
    most: int,
    gap: float,
) -> int:
    """Goes on until no bound is below the best value by more than `gap`, relative and of at least 1, or `most`
    programs have been solved in all. When it is done, the workspace holds the answer at the
    best choice."""
    w, table, found = unpack(floats, ints), Table(*tables), Progress(*progress)
    ask(w, wrench)
    while found.counts[1] >= 0 and found.values[1] < cutoff(found.values[0], gap) and found.counts[2] < most:
        place(w, table, found.counts[1])
        if not learn(w, table, found, solve_program(floats, ints)):
            return GAVE_UP
    if found.counts[0] >= 0:
        place(w, table, found.counts[0])
        if solve_program(floats, ints) != OPTIMAL:
            return GAVE_UP
    return DONE


@compiled
def cutoff(best: float, gap: float) -> float:
    return best - gap * max(1.0, abs(best)) if best < np.inf else best


@compiled
def learn(w: Workspace, table: Table, found: Progress, status: int) -> bool:
    """Raises all bounds by what has been found at the choice that was next; False if that isn't proven."""
    choice = found.counts[1]
    found.counts[2] += 1
    table.bounds[choice] = np.inf
    if status not in (OPTIMAL, INFEASIBLE):
        return False
    value = w.found[COST] + charge(table, choice)
    if status == OPTIMAL and value < found.values[0]:
        found.values[0], found.counts[0] = value, choice
    is_ray = status == INFEASIBLE
    constant = ray_cut(w, table) if is_ray else effort_cut(w, table)
    raise_bounds(table, found, constant, EQUALITY_TOLERANCE * wrench_scale(w.claim) if is_ray else np.inf)
    return True


@compiled
def charge(table: Table, choice: int) -> float:
    """What a full choice costs beside the effort."""
    total = 0.0
    if len(table.charges) == 0:
        return total
    for arm in range(len(table.starts) - 2, -1, -1):
        options = table.starts[arm + 1] - table.starts[arm]
        total += table.charges[table.starts[arm] + choice % options]
        choice //= options
    return total


@compiled
def place(w: Workspace, table: Table, choice: int) -> None:
    """Puts the arms at the points of a full choice."""
    for arm in range(len(table.starts) - 2, -1, -1):
        options = table.starts[arm + 1] - table.starts[arm]
        v = table.starts[arm] + choice % options
        choice //= options
        for c in range(3):
            w.points[arm, c] = table.points[v, c]
    move(w)


@compiled
def raise_bounds(table: Table, found: Progress, constant: float, tolerance: float) -> None:
    """Each bound becomes at least the cut's; beyond `tolerance`, which is finite for rays, it becomes infinite."""
    starts, phi, bounds = table.starts, table.phi, table.bounds
    last = len(starts) - 2
    first, inner = starts[last], starts[last + 1] - starts[last]
    least, choice, is_ray = np.inf, -1, tolerance < np.inf
    for block in range(len(bounds) // inner):
        rest, base = block, constant
        for arm in range(last - 1, -1, -1):
            options = starts[arm + 1] - starts[arm]
            base += phi[starts[arm] + rest % options]
            rest //= options
        for j in range(inner):
            value, i = base + phi[first + j], block * inner + j
            if is_ray:
                value = np.inf if value > tolerance else -np.inf
            if value > bounds[i]:
                bounds[i] = value
            if bounds[i] < least:
                least, choice = bounds[i], i
    found.values[1], found.counts[1] = least, choice
