"""`python -m benchmarks.wrong_motion [--constants]`: sources of motion that are wrong, in the controller's loop.

A cart of 24 kg that is guessed at 20 kg follows a curve at 0.6 m/s. From 2 s on its poses have another origin, turn,
or are in degrees; its velocities are zeros, freeze or are reversed; or wrenches are told as -9999: for 0.8 s, or for
good. Told are the cart's largest speed, how far it was from its path at most, and at last. Then a cart that nobody
knows to stand on a slope, 1.4 m off its path. With `--constants` those by which it is stopped, and velocities are left
out, are taken 30 % less and more: told is in how many of these runs the cart is faster than 0.9 m/s, or off at last by
more than 5 cm where the fault was short. It takes half an hour.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import product
from types import ModuleType

import numpy as np

from cartgrasp.arms import Arm
from cartgrasp.cli.output import progress
from cartgrasp.effects import FloorSlope, ViscousDrag
from cartgrasp.inertia import Inertia
from cartgrasp.model import CartModel
from cartgrasp.motion import Measurement, Motion
from cartgrasp.simulation import ModelPlant, SensorNoise, Sensors
from cartgrasp.studies.shopping_cart import WHEELS
from estimation import CartFilter, DisturbedFilter, FilterNoise
from estimation.online import arm_monitor, repeated_velocities
from planning import Caution, Controller, PathReference, chain, pause
from planning.control import protective_stop
from planning.control.step import Step
from planning.references import speed_change, turn

TRUTH = CartModel(Inertia(24.0, (0.3, 0.05), 2.2), effects=(ViscousDrag(3.0, 1.2),), wheels=WHEELS)
GUESS = TRUTH.with_inertia(Inertia(20.0, (0.25, 0.0), 2.0))
PATH = PathReference(chain(speed_change(0.6), turn(0.8, 0.3), pause(3.0), turn(-0.8, 0.3), speed_change(-0.6)))
BEGIN, SHORT, DURATION = 2.0, 0.8, 12.0
"""s."""
FAST, NEAR = 0.9, 0.05
"""m/s, m."""
CAUTION = Caution()
FILTERS = {"CartFilter": CartFilter, "DisturbedFilter": DisturbedFilter}
Wrong = Callable[[Measurement, Measurement], Measurement]
"""Makes a sample wrong; the second is the last one that was right."""
POSES: dict[str, Wrong] = {
    "moved": lambda m, _: replace(m, pose=m.pose - np.array([3.0, 4.0, 0.0])),
    "turned about": lambda m, _: replace(m, pose=m.pose + np.array([0.0, 0.0, np.pi])),
    "turned": lambda m, _: replace(m, pose=m.pose + np.array([0.0, 0.0, 0.5])),
    "another frame": lambda m, _: replace(m, pose=np.array([1.0 - m.pose[1], m.pose[0], m.pose[2] + np.pi / 2.0])),
    "drifting": lambda m, _: replace(m, pose=m.pose + np.array([0.0, 0.0, 0.1 * (m.time - BEGIN)])),
    "in degrees": lambda m, _: replace(m, pose=m.pose * [1.0, 1.0, 180.0 / np.pi]),
}
VELOCITIES: dict[str, Wrong] = {
    "zeros": lambda m, _: replace(m, velocity=np.zeros(3)),
    "frozen": lambda m, right: replace(m, velocity=right.velocity),
    "reversed": lambda m, _: replace(m, velocity=-m.velocity),
}
WRENCHES: dict[str, Wrong] = {
    "of -9999": lambda m, _: replace(m, wrenches=dict.fromkeys(m.wrenches, np.full(6, -9999.0)))
}
WRONG = POSES | VELOCITIES | WRENCHES
CONSTANTS: tuple[tuple[ModuleType, str], ...] = (
    (protective_stop, "MONITORING_INTERVAL"),
    (protective_stop, "MONITORED_SPEED"),
    (protective_stop, "HOLDING_SPEED"),
    (protective_stop, "FIRST_PAUSE"),
    (protective_stop, "GENTLE_SHARE"),
    (protective_stop, "MAX_HOLD"),
    (repeated_velocities, "CALIBRATION_VELOCITIES"),
    (repeated_velocities, "MAX_WAY_ERROR"),
    (arm_monitor, "MAX_WEIGHT_RATIO"),
)


@dataclass(frozen=True)
class Driven:
    """The last step; the cart's largest speed (m/s), and how far it was from its path at most and at last (m)."""

    step: Step
    speed: float
    farthest: float
    off: float

    def is_safe(self, is_short: bool) -> bool:
        return self.speed < FAST and (self.off < NEAR or not is_short)


def driven(kind: str, filter_kind: str, until: float, duration: float, caution: Caution | None = CAUTION) -> Driven:
    """With samples that are wrong from `BEGIN` on."""
    right = Measurement(0.0)
    of_wrenches, spoil = kind in WRENCHES, WRONG[kind]

    def seen(measured: Measurement) -> Measurement:
        nonlocal right
        if not BEGIN <= measured.time < until or of_wrenches:
            right = measured
            return measured
        return spoil(measured, right)

    def felt(measured: Measurement) -> Measurement:
        return spoil(measured, right) if of_wrenches and BEGIN <= measured.time < until else measured

    told = list(ticks(_controller(filter_kind, caution), TRUTH, duration, seen=seen, felt=felt))
    off = [float(np.hypot(*(motion.pose_sb - step.reference.pose_sb)[:2])) for step, motion in told]
    return Driven(told[-1][0], _largest_speed(told), max(off), off[-1])


def held_on_a_slope(slope: float, duration: float = 8.0) -> Driven:
    """A cart that stands 1.4 m off its path; `off` is how far it has gone from there."""
    truth = replace(TRUTH, effects=(*TRUTH.effects, FloorSlope(slope, 0.0)))
    told = list(ticks(_controller("CartFilter", CAUTION), truth, duration, x=-1.4))
    away = [abs(float(motion.pose_sb[0]) + 1.4) for _, motion in told]
    return Driven(told[-1][0], _largest_speed(told), max(away), away[-1])


def runs() -> Iterator[tuple[str, bool, Driven]]:
    """What was wrong, whether for a short time, and what it did."""
    for of, faults in (("poses", POSES), ("velocities", VELOCITIES), ("wrenches", WRENCHES)):
        for kind, filter_kind, is_short in product(faults, FILTERS, (True, False)):
            until, duration = (BEGIN + SHORT, 6.0) if is_short else (np.inf, DURATION)
            words = f"{of} {kind} | {filter_kind} | {f'{SHORT:g} s' if is_short else 'for good'}"
            yield words, is_short, driven(kind, filter_kind, until, duration)
    for slope in (0.03, -0.05):
        yield f"a slope of {slope:g}, unknown | CartFilter | for good", False, held_on_a_slope(slope)


def unsafe() -> str:
    """Of all runs."""
    return "; ".join(words.replace(" | ", ", ") for words, short, one in runs() if not one.is_safe(short)) or "none"


def ticks(
    controller: Controller,
    truth: CartModel,
    duration: float,
    x: float = 0.0,
    seed: int = 0,
    seen: Callable[[Measurement], Measurement] = lambda measured: measured,
    felt: Callable[[Measurement], Measurement] = lambda measured: measured,
) -> Iterator[tuple[Step, Motion]]:
    """Each step, and the cart's motion after it; what is `seen` and `felt` may be spoiled."""
    plant = ModelPlant(truth, pose_sb=(x, 0.0, 0.0))
    sensors = Sensors(truth, SensorNoise(force=1.0, moment=0.05), seed)
    while plant.time < duration:
        step = controller.step(seen(sensors.motion(plant.time, plant.motion)))
        controller.observe(felt(sensors.wrenches(plant.time, step.given)))
        plant.step(step.given, 0.01)
        yield step, plant.motion


def _largest_speed(told: Sequence[tuple[Step, Motion]]) -> float:
    return max(abs(float(motion.velocity[0])) for _, motion in told)


def _controller(kind: str, caution: Caution | None) -> Controller:
    hands = [
        Arm(name, [(-0.25, y, 1.0)], force_limit=(60.0,) * 3, moment_limit=(8.0,) * 3)
        for name, y in (("left", 0.2), ("right", -0.2))
    ]
    learner = FILTERS[kind](GUESS, ["left", "right"], noise=FilterNoise(force=1.0, moment=0.05))
    controller = Controller(GUESS, hands, PATH, estimator=learner, regrasp=None, caution=caution)
    controller.warm_up()
    return controller


def main() -> None:
    parser = argparse.ArgumentParser("python -m benchmarks.wrong_motion", description=__doc__)
    parser.add_argument("--constants", action="store_true")
    if not parser.parse_args().constants:
        print("| what is wrong | filter | how long | largest speed, m/s | off its path at most, m | at last |")
        print("| --- " * 6 + "|")
        for words, _, one in runs():
            print(f"| {words} | {one.speed:.2f} | {one.farthest:.2f} | {one.off:.2f} |", flush=True)
        return
    print("| constant | not safe: 30 % less | more |")
    print("| --- " * 3 + "|")
    print("| as they are |" + f" {unsafe()} |" * 2, flush=True)
    with progress("constants") as told:
        for done, (module, name) in enumerate(CONSTANTS):
            value, found = getattr(module, name), []
            for share in (0.7, 1.3):
                setattr(module, name, type(value)(share * value))
                found.append(unsafe())
            setattr(module, name, value)
            print(f"| {name} | {' | '.join(found)} |", flush=True)
            told((done + 1) / len(CONSTANTS))


if __name__ == "__main__":
    main()
