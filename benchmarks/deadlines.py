"""`python -m benchmarks.deadlines [--ticks N] [--only WORD]`: how long ticks take at worst, after `warm_up`, by what
comes of them.

Times are the thread's own CPU time, so that other programs on the machine have no share in them; what the interpreter's
garbage collector takes is in them."""

from __future__ import annotations

import argparse
import itertools
import time
from array import array
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from cartgrasp import Arm, CartModel, ContactSet, Estimate, Inertia, Measurement, Motion
from cartgrasp.effects import ViscousDrag
from cartgrasp.first_guess import FirstGuess
from cartgrasp.simulation import ModelPlant, SensorNoise, Sensors
from cartgrasp.wheels import Wheel
from estimation import CartFilter, DisturbedFilter
from planning import Controller, PathReference, Skid, TipOver, WrenchPlanner, chain, speed_change, turn
from planning.control.step import Step

TICKS = 100_000
EDGES = (20.0, 50.0, 100.0, 200.0, 500.0, 1000.0, 2000.0, 5000.0)
"""µs."""
CART = CartModel(Inertia(24.0, (0.3, 0.0), 2.0), effects=(ViscousDrag(5.0, 2.0),))
HAND = {"force_limit": (60.0, 60.0, 40.0), "moment_limit": (8.0, 8.0, 6.0)}
DURATION, LOADED_AT, LOAD = 20.0, 10.0, 2.0
STD = {
    "mass": 3.0,
    "com_x": 0.05,
    "com_y": 0.02,
    "inertia": 0.4,
    "viscous_drag.linear": 1.0,
    "viscous_drag.angular": 0.5,
}
"""What a cart's file may say of its first guess."""
RATES = (100.0, 500.0)
"""Hz, of a filter's samples and of a controller's ticks."""
Tick = Callable[[], str]
"""Does one, and says what came of it."""
Ticks = Iterator[Tick]
"""Without end; what is done between two is not timed."""


def main() -> None:
    parser = argparse.ArgumentParser("python -m benchmarks.deadlines", description=__doc__)
    parser.add_argument("--ticks", type=int, default=TICKS, help="of each kind")
    parser.add_argument("--only", default="", metavar="WORD", help="kinds whose name has it")
    asked = parser.parse_args()
    kinds = {name: make for name, make in KINDS.items() if asked.only in name}
    print("\n".join(table({name: spent(make(), asked.ticks // SELDOM.get(name, 1)) for name, make in kinds.items()})))


def spent(ticks: Ticks, count: int) -> dict[str, np.ndarray]:
    """µs of each of so many ticks, by what came of it."""
    found: dict[str, array[int]] = {}  # no lists: the collector of garbage would look through them, within a tick
    for tick in itertools.islice(ticks, count):
        begin = time.thread_time_ns()
        what = tick()
        took = time.thread_time_ns() - begin
        found.setdefault(what, array("q")).append(took)
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


def _planning(force: float, *places: tuple[float, float, float], **given: float) -> Callable[[], Ticks]:
    """Of wrenches about a forward force (N), now and then one that can be given, so that something is held."""

    def make() -> Ticks:
        left, right = ContactSet(((-0.25, 0.2, 1.0), *places)), ContactSet(((-0.25, -0.2, 1.0),))
        planner = WrenchPlanner(CART, [Arm("left", left, **HAND), Arm("right", right, **HAND)], **given)
        planner.warm_up()
        planner.plan_or_hold((20.0, 0.0, 0.0))
        wrenches = np.random.default_rng(0).uniform((-10.0, 0.0, -3.0), (10.0, 0.0, 3.0), (1000, 3))
        wrenches[:, 0] += force
        for wrench in itertools.cycle(wrenches.tolist()):
            yield lambda wrench=wrench: planner.plan_or_hold(wrench).status

    return make


def _stale() -> Ticks:
    planner = WrenchPlanner(CART, [Arm("hand", [(-0.25, 0.1, 1.0)])])
    planner.warm_up()
    now = Estimate(10.0, Motion(np.zeros(3), np.zeros(CART.constraints.n_free)), {}, "", CART, CART.parameters)
    planner.plan_or_hold((20.0, 0.0, 0.0), estimate=now)
    return itertools.repeat(lambda: planner.plan_or_hold((20.0, 0.0, 0.0), estimate=now._replace(time=1.0)).status)


def _updates(rate: float) -> Callable[[], Ticks]:
    """Over a log again and again, whose load doubles halfway; each time a new filter begins."""

    def make() -> Ticks:
        log = list(_log(rate))
        CartFilter(CART).warm_up()
        while True:
            online = CartFilter(CART)
            for measurement in log:
                yield lambda online=online, measurement=measurement: str(online.update(measurement).health)

    return make


def _controlling(
    rate: float,
    contacts: str = "fixed",
    confidence: float | None = 0.99,
    std: Mapping[str, float] = STD,
    learner: Callable[..., Any] = CartFilter,
) -> Callable[[], Ticks]:
    """Of a whole loop: filter, tracker, planner and contacts of two arms with three points each, with limits of skid
    and tip-over. A path again and again; each time a new controller begins."""

    def make() -> Ticks:
        guess = replace(GUESS, first_guess=FirstGuess(tuple(std.items())))
        asked = {"contacts": contacts, "cart_limits": LIMITS, "confidence": confidence, "period": 1.0 / rate}
        while True:
            hands = _hands()
            told = learner(guess, [hand.name for hand in hands])
            controller = Controller(guess, hands, PATH, estimator=told, **asked)
            controller.warm_up()
            robot, sensors = ModelPlant(TRUCK), Sensors(TRUCK, SensorNoise(force=0.5, moment=0.02), seed=1)
            steps, felt = list[Step](), None
            while not controller.is_done:
                yield partial(_tick, controller, felt, sensors.motion(robot.time, robot.motion), steps)
                given = steps.pop().given
                felt = sensors.wrenches(robot.time, given)
                robot.step(given, controller.period)

    return make


def _tick(controller: Controller, felt: Measurement | None, moved: Measurement, steps: list[Step]) -> str:
    if felt is not None:
        controller.observe(felt)
    steps.append(controller.step(moved))
    return str(steps[-1].plan.status)


def _hands() -> list[Arm]:
    points = [(-0.25, y, 1.0) for y in (0.15, 0.2, 0.25)]
    return [Arm("left", points, **HAND), Arm("right", [(x, -y, z) for x, y, z in points], **HAND)]


def _log(rate: float) -> Iterator[Measurement]:
    random = np.random.default_rng(0)
    for time_s in np.arange(0.0, DURATION, 1.0 / rate).tolist():
        felt, off = random.normal(size=(2, 6))
        speed, x = 0.3 + 0.2 * np.sin(time_s), 0.3 * time_s + 0.2 * (1.0 - np.cos(time_s))
        mass = 24.0 * (LOAD if time_s > LOADED_AT else 1.0)
        wrench = np.array([mass * 0.2 * np.cos(time_s) + 5.0 * speed, 0.0, 0.0, 0.0, 0.0, 0.0]) + 0.5 * felt
        pose, velocity = np.array([x, 0.0, 0.0]) + 0.0005 * off[:3], np.array([speed, 0.0, 0.0]) + 0.005 * off[3:]
        yield Measurement(time_s, pose, velocity, {"hand": wrench}, {"hand": np.array([-0.25, 0.0, 1.0])})


WHEELS = (*(Wheel("fixed", 0.0, y) for y in (-0.25, 0.25)), *(Wheel("caster", 0.7, y, 0.05) for y in (-0.2, 0.2)))
TRUCK = CartModel(Inertia(24.0, (0.3, 0.0), 2.0), effects=CART.effects, wheels=WHEELS, com_height=0.5)
GUESS = TRUCK.with_inertia(Inertia(22.0, (0.28, 0.0), 1.8))
PATH = PathReference(chain(speed_change(0.5), turn(0.8, 0.4), turn(-0.8, 0.4), speed_change(-0.5)))
LIMITS = (Skid(0.5), TipOver(5.0))
OTHER = (-0.25, 0.1, 1.0)
KINDS: dict[str, Callable[[], Ticks]] = {
    "plan_or_hold": _planning(30.0),
    "plan_or_hold, beyond": _planning(500.0),
    "plan_or_hold, beyond, relaxed": _planning(500.0, relax=np.inf),
    "plan_or_hold, contacts chosen": _planning(30.0, OTHER),
    "plan_or_hold, contacts chosen, beyond": _planning(500.0, OTHER),
    "plan_or_hold, not a number": _planning(np.nan),
    "plan_or_hold, stale": _stale,
    **{f"update, {rate:g} Hz": _updates(rate) for rate in RATES},
    "controller, 500 Hz, limits of the estimate": _controlling(500.0, confidence=None),
    **{f"controller, {rate:g} Hz, with 99 %": _controlling(rate) for rate in RATES},
    "controller, 500 Hz, with 99 %, contacts that teach": _controlling(500.0, "teach"),
    "controller, 500 Hz, with 99 %, disturbances told": _controlling(500.0, learner=DisturbedFilter),
    "controller, 500 Hz, with 99 % of a guess that is too unsure": _controlling(500.0, std={}),
}

SELDOM = {
    "plan_or_hold, beyond, relaxed": 20,
    "controller, 500 Hz, with 99 % of a guess that is too unsure": 100,
} | {name: 10 for name in KINDS if name.startswith("controller") and "unsure" not in name}
"""Of which there are so many times fewer: they are slow."""

if __name__ == "__main__":
    main()
