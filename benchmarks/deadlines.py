"""`python -m benchmarks.deadlines [--ticks N]`: how long ticks take at worst, by what comes of them, after `warm_up`.

Times are the thread's own CPU time, so that other programs on the machine have no share in them; what the interpreter's
garbage collector takes is in them."""

from __future__ import annotations

import argparse
import itertools
import time
from collections.abc import Callable, Iterator

import numpy as np

from cartgrasp import Arm, CartModel, ContactSet, Estimate, Inertia, Measurement, Motion
from cartgrasp.effects import ViscousDrag
from estimation import CartFilter
from planning import WrenchPlanner

TICKS = 100_000
EDGES = (20.0, 50.0, 100.0, 200.0, 500.0, 1000.0, 2000.0, 5000.0)
"""µs."""
CART = CartModel(Inertia(24.0, (0.3, 0.0), 2.0), effects=(ViscousDrag(5.0, 2.0),))
DURATION, LOADED_AT, LOAD = 20.0, 10.0, 2.0
RATES = (100.0, 500.0)
"""Hz, of a filter's samples."""
Tick = Callable[[], str]
"""Does one, and says what came of it."""


def main() -> None:
    parser = argparse.ArgumentParser("python -m benchmarks.deadlines", description=__doc__)
    parser.add_argument("--ticks", type=int, default=TICKS, help="of each kind")
    ticks = parser.parse_args().ticks
    print("\n".join(table({name: spent(make(), ticks // SELDOM.get(name, 1)) for name, make in KINDS.items()})))


def spent(tick: Tick, ticks: int) -> dict[str, np.ndarray]:
    """µs of each tick, by what came of it."""
    found: dict[str, list[int]] = {}
    for _ in range(ticks):
        begin = time.thread_time_ns()
        what = tick()
        took = time.thread_time_ns() - begin
        found.setdefault(what, []).append(took)
    return {what: np.array(took) / 1000.0 for what, took in found.items()}


def table(found: dict[str, dict[str, np.ndarray]]) -> list[str]:
    """Markdown: ticks, median, worst of a thousand and of all, and how many are in each range."""
    ranges = [f"< {edge:g}" for edge in EDGES] + ["more"]
    head = ["ticks of", "came out", "ticks", "median µs", "p99.9", "worst", *ranges]
    lines = [f"| {' | '.join(head)} |", f"|{' --- |' * len(head)}"]
    for name, by_what in found.items():
        for what, took in by_what.items():
            counts = np.diff([0, *(np.count_nonzero(took < edge) for edge in EDGES), len(took)])
            figures = [np.median(took), np.quantile(took, 0.999), took.max()]
            cells = [name, what, f"{len(took)}", *(f"{one:.1f}" for one in figures), *map(str, counts.tolist())]
            lines.append(f"| {' | '.join(cells)} |")
    return lines


def _planning(force: float, *places: tuple[float, float, float], **given: float) -> Callable[[], Tick]:
    """Of wrenches about a forward force (N), now and then one that can be given, so that something is held."""

    def make() -> Tick:
        limits = {"force_limit": (60.0, 60.0, 40.0), "moment_limit": (8.0, 8.0, 6.0)}
        left, right = ContactSet(((-0.25, 0.2, 1.0), *places)), ContactSet(((-0.25, -0.2, 1.0),))
        planner = WrenchPlanner(CART, [Arm("left", left, **limits), Arm("right", right, **limits)], **given)
        planner.warm_up()
        planner.plan_or_hold((20.0, 0.0, 0.0))
        wrenches = np.random.default_rng(0).uniform((-10.0, 0.0, -3.0), (10.0, 0.0, 3.0), (1000, 3))
        wrenches[:, 0] += force
        walk = itertools.cycle(wrenches.tolist())
        return lambda: planner.plan_or_hold(next(walk)).status

    return make


def _stale() -> Tick:
    planner = WrenchPlanner(CART, [Arm("hand", [(-0.25, 0.1, 1.0)])])
    planner.warm_up()
    now = Estimate(10.0, Motion(np.zeros(3), np.zeros(3)), {}, "", CART, CART.parameters)
    planner.plan_or_hold((20.0, 0.0, 0.0), estimate=now)
    return lambda: planner.plan_or_hold((20.0, 0.0, 0.0), estimate=now._replace(time=1.0)).status


def _updates(rate: float) -> Callable[[], Tick]:
    """Over a log again and again, whose load doubles halfway; each time a new filter begins."""

    def make() -> Tick:
        log = list(_log(rate))

        def outcomes() -> Iterator[str]:
            while True:
                online = CartFilter(CART)
                for measurement in log:
                    yield str(online.update(measurement).health)

        CartFilter(CART).warm_up()
        walk = outcomes()
        return lambda: next(walk)

    return make


def _log(rate: float) -> Iterator[Measurement]:
    random = np.random.default_rng(0)
    for time_s in np.arange(0.0, DURATION, 1.0 / rate).tolist():
        felt, off = random.normal(size=(2, 6))
        speed, x = 0.3 + 0.2 * np.sin(time_s), 0.3 * time_s + 0.2 * (1.0 - np.cos(time_s))
        mass = 24.0 * (LOAD if time_s > LOADED_AT else 1.0)
        wrench = np.array([mass * 0.2 * np.cos(time_s) + 5.0 * speed, 0.0, 0.0, 0.0, 0.0, 0.0]) + 0.5 * felt
        pose, velocity = np.array([x, 0.0, 0.0]) + 0.0005 * off[:3], np.array([speed, 0.0, 0.0]) + 0.005 * off[3:]
        yield Measurement(time_s, pose, velocity, {"hand": wrench}, {"hand": np.array([-0.25, 0.0, 1.0])})


OTHER = (-0.25, 0.1, 1.0)
KINDS: dict[str, Callable[[], Tick]] = {
    "plan_or_hold": _planning(30.0),
    "plan_or_hold, beyond": _planning(500.0),
    "plan_or_hold, beyond, relaxed": _planning(500.0, relax=np.inf),
    "plan_or_hold, contacts chosen": _planning(30.0, OTHER),
    "plan_or_hold, contacts chosen, beyond": _planning(500.0, OTHER),
    "plan_or_hold, not a number": _planning(np.nan),
    "plan_or_hold, stale": _stale,
    **{f"update, {rate:g} Hz": _updates(rate) for rate in RATES},
}

SELDOM = {"plan_or_hold, beyond, relaxed": 20}
"""Of which there are so many times fewer: they are slow."""

if __name__ == "__main__":
    main()
