"""Ways to read a force sensor: turned, mirrored, of the other side's force, of the world's axes, in another unit."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from itertools import permutations, product

import numpy as np

from cartgrasp.frames import PLANAR, Array

COMMON_MOUNTING_ODDS, RARE_MOUNTING_ODDS = 0.005, 0.0003
"""Odds, against sound axes, of each wrong mounting. Some twenty keep recorded z vertical (one log in ten in all), and
32 don't (one in a hundred)."""
UNIT_ODDS = 0.01
"""Odds of each unit of force, and of each of moments beside newtons: one log in a hundred."""
RECORDED_WRENCH_UNITS = {
    ("N", "N·m"): (1.0, 1.0),
    ("N", "N·cm"): (1.0, 0.01),
    ("N", "N·mm"): (1.0, 0.001),
    ("lbf", "lbf·ft"): (4.4482216, 1.3558179),
    ("lbf", "lbf·in"): (4.4482216, 0.1129848),
    ("lbf", "N·m"): (4.4482216, 1.0),
    ("kgf", "kgf·m"): (9.80665, 9.80665),
    ("kgf", "N·m"): (9.80665, 1.0),
    ("kN", "kN·m"): (1000.0, 1000.0),
    ("mN", "mN·m"): (0.001, 0.001),
}
"""For units of forces and moments, what recorded numbers are multiplied by to be N and N·m; the sound ones first."""
RECORDED_COMPONENTS = ("fx", "fy", "fz", "tx", "ty", "tz", "along", "across")
"""What is recorded, and the force along and across {b}'s x if it was recorded in {s}."""


@dataclass(frozen=True)
class Mounting:
    """The true fx, fy and tz in {a} of `RECORDED_COMPONENTS`, (3, 8); the fault's kind ("" for none), odds, words."""

    taken: Array
    kind: str
    odds: float
    words: str


@cache
def mountings() -> tuple[Mounting, ...]:
    """The sound one first. The 24 turns of a cube and their reactions, one component reversed, x and y exchanged, and
    forces of the world."""
    one = np.eye(3)
    pairs = [(one, one)]
    for order, signs in product(permutations(range(3)), product((1.0, -1.0), repeat=3)):
        turn = np.array(signs)[:, None] * one[list(order)]
        if not np.array_equal(turn, one):
            pairs.append((turn, turn))
    pairs += [(one[[1, 0, 2]], one), (np.diag([-1.0, 1, 1]), one), (np.diag([1.0, -1, 1]), one)]
    pairs.append((one, np.diag([1.0, 1, -1])))
    words = "forces are along the world's axes; turn them by -theta into the contact's"
    world = np.zeros((3, len(RECORDED_COMPONENTS)))
    world[[0, 1, 2], [6, 7, 5]] = 1.0
    return (*(_of(force, moment) for force, moment in pairs), Mounting(world, "frame", COMMON_MOUNTING_ODDS, words))


def _of(force: Array, moment: Array) -> Mounting:
    taken = np.zeros((3, len(RECORDED_COMPONENTS)))
    taken[:2, :3], taken[2, 3:6] = force[:2], moment[2]
    wrong = [i for i, own in enumerate(PLANAR) if taken[i, own] != 1]
    told = [f"{('fx', 'fy', 'tz')[i]} is what is recorded as {_signed(taken[i])}" for i in wrong]
    if not wrong and np.array_equal(force, np.eye(3)):
        return Mounting(taken, "", 1.0, "")
    straight = all(taken[i, own] != 0 for i, own in enumerate(PLANAR))
    kind = "sign" if straight else "axes"
    odds = COMMON_MOUNTING_ODDS if abs(force[2, 2]) == 1 else RARE_MOUNTING_ODDS
    return Mounting(taken, kind, odds, " and ".join(told) or "only fz, tx or ty differ")


def _signed(row: Array) -> str:
    at = int(np.abs(row).argmax())
    return f"{'-' if row[at] < 0 else ''}{RECORDED_COMPONENTS[at]}"
