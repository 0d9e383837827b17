"""`plan_schedule`: when and where to regrasp over a reference."""

from __future__ import annotations

from functools import partial

from cartgrasp.effects import RollingResistance
from planning.references import PathReference, chain, pause, speed_change, turn
from planning.schedule.schedule import RegraspCost, plan_schedule

from .measuring import interleave
from .report import Result, timed_table
from .scene import CART, hand

COST = RegraspCost(duration=0.5, effort=1.0)
ROLLING = CART.with_effect(RollingResistance(0.03))
PLACES = {"left": (0.1, 0.2, 0.3), "right": (-0.1, -0.2, -0.3)}
ARMS = tuple(hand(name, [(-0.25, y, 1.0) for y in places]) for name, places in PLACES.items())
BEND = chain(turn(0.5, 0.3, 0.2), turn(-0.5, 0.3, 0.2))
BENDS, CRUISE = "bends all the way", "straight, mostly at one speed"
STRETCHES = {BENDS: BEND * 4, CRUISE: chain(pause(28.0))}
NOTE = """Two arms with three points each, stages of 0.25 s; a regrasp takes 0.5 s and costs 1 N²·s. A QP is solved for
each way to hold, an arm on its way among them, at each wrench that is asked for. `gap` is by how much a schedule may
cost more than the best, relative."""


def run(rounds: int) -> Result:
    calls = {}
    extra: dict[str, dict[str, str]] = {"duration, s": {}, "stages": {}, "QPs": {}, "gap": {}}
    for name, between in STRETCHES.items():
        stretches = chain(speed_change(0.5, 0.2), between, speed_change(-0.5, 0.2))
        path = PathReference(stretches, ROLLING.rolling)
        calls[name] = partial(_plan, path)
        found = plan_schedule(path, ROLLING, ARMS, COST)
        stages, gap = len(found.times) - 1, (found.total - found.bound) / max(1.0, found.total)
        cells = (f"{path.duration:.0f}", f"{stages}", f"{found.solved:,}", f"{gap:.0e}")
        for column, cell in zip(extra.values(), cells, strict=True):
            column[name] = cell
    table = timed_table("A schedule", interleave(calls, rounds), BENDS, "ms", extra)
    return Result("When to regrasp", NOTE, (table,))


def _plan(path: PathReference, _: int) -> object:
    return plan_schedule(path, ROLLING, ARMS, COST)
