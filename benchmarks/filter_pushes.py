"""`python -m benchmarks.filter_pushes [--seeds 0:100] [--only nothing|push|load|floor|ramp]`: what the online filter
makes of pushes that no arm gave, of loads, of other floors, and of ramps.

Carts of 10 to 80 kg with drag and rolling resistance, first guesses from half to twice the mass, sensors as told. Once
in a run, after 3 to 8 s of 14, something of 10 to 60 N pushes for 0.2 to 1 s from anywhere, or a tenth to four tenths
of the mass are put on (taken off in three of ten), or the floor is rougher for 1 to 8 s (coefficients 0.01 to 0.05
more), or slopes from there on for as long (by 0.02 to 0.08, most of it along the way); in sound runs nothing happens.
A tick is sure and wrong where the mass is said to be identifiable under a health of `ok`, and is off by more than 3 %
and four deviations.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass

import numpy as np

from cartgrasp.constraints import RollingConstraints
from cartgrasp.effects import PayloadChange
from cartgrasp.frames import rotation_planar
from cartgrasp.inertia import Inertia
from cartgrasp.model import CartModel
from cartgrasp.motion import Motion
from cartgrasp.simulation.pushed_plant import Push
from cartgrasp.studies.estimators import CONTROL_PERIOD, HANDS, PATHS, SENSOR_SETS, Job, drive_cart
from cartgrasp.studies.scenario import filter_noise
from cartgrasp.wheels import GRAVITY
from estimation import CartFilter
from estimation.whole_log.replay import replay

from .filter_faults import between, resistances

NOTHING, PUSH, LOAD, FLOOR, RAMP = KINDS = "nothing", "push", "load", "floor", "ramp"
LASTING = 14.0
OFF, DEVIATIONS, SETTLED = 0.03, 4.0, 0.05


@dataclass(frozen=True)
class Run:
    """From the event on: for how long the mass was sure and wrong, and not `ok` (s); its last error, by its value and
    by its deviation; and whether the last health was `ok`."""

    wrong: float
    unsound: float
    off: float
    deviations: float
    is_ok: bool


def drive(seed: int, kind: str) -> Run:
    random = np.random.default_rng([seed, 11])
    mass, share = between(random, 10.0, 80.0), between(random, 0.5, 2.0)
    com = float(random.uniform(0.15, 0.4)), float(random.uniform(-0.08, 0.08))
    drags = np.array([between(random, 1.0, 8.0), between(random, 0.4, 3.0), between(random, 0.005, 0.03)])
    believed = drags * random.uniform(0.5, 2.0, 3)
    at, load = float(random.uniform(3.0, 8.0)), float(random.uniform(0.1, 0.4)) * mass
    load *= -0.6 if random.random() < 0.3 else 1.0
    force, lasting = between(random, 10.0, 60.0), between(random, 0.2, 1.0)
    angle = float(random.uniform(-np.pi, np.pi)) if random.random() < 0.5 else float(random.choice([0.0, np.pi]))
    point = np.array([random.uniform(-0.3, 0.6), random.uniform(-0.3, 0.3), 0.5])
    pushes = [Push(force * np.array([np.cos(angle), np.sin(angle), 0.0]), point)]
    rough, stretch = between(random, 0.01, 0.05) * GRAVITY * mass, between(random, 1.0, 8.0)

    grade, across = between(random, 0.02, 0.08) * float(random.choice([-1.0, 1.0])), float(random.normal(0.0, 0.01))
    begun: list[np.ndarray] = []  # the ramp's rise over run (2,) in the world, once the cart is on it

    def outside(time: float, motion: Motion) -> list[Push]:
        if kind == FLOOR and at <= time < at + stretch:
            drag = -rough * np.tanh(motion.velocity[0] / 0.01)
            return [Push(np.array([drag, 0.0, 0.0]), np.array([*com, 0.0]))]
        if kind == RAMP and at <= time < at + stretch:
            turn = rotation_planar(motion.pose_sb[2])
            begun.extend([] if begun else [turn @ [grade, across]])
            return [Push(np.array([*(-GRAVITY * mass * turn.T @ begun[0]), 0.0]), np.array([*com, 0.0]))]
        return pushes if kind == PUSH and at <= time < at + lasting else []

    truth = _cart(mass, com, drags, PayloadChange(at, load, 0.2, 0.1) if kind == LOAD else None)
    guess = _cart(share * mass, (0.3, 0.0), believed, None)
    job = Job(list(PATHS)[seed % len(PATHS)], ("quiet", "usual", "usual")[seed % 3], seed)
    log = drive_cart(truth, job, LASTING, outside).log
    told = replay(log, CartFilter(guess, list(HANDS), noise=filter_noise(SENSOR_SETS[job.sensors]))).estimates
    after = [(one.parameters["mass"], one.health == "ok") for one in told if one.time > at]
    true = mass + (load if kind == LOAD else 0.0)
    wrong = [
        is_ok and one.identifiable and abs(one.value - true) > max(OFF * true, DEVIATIONS * one.std)
        for one, is_ok in after
    ]
    last, is_ok = after[-1]
    off = last.value - true
    unsound = sum(not ok for _, ok in after)
    return Run(CONTROL_PERIOD * sum(wrong), CONTROL_PERIOD * unsound, off / true, off / last.std, is_ok)


def _cart(mass: float, com: tuple[float, float], drags: np.ndarray, load: PayloadChange | None) -> CartModel:
    effects = *resistances(*map(float, drags)), *((load,) if load else ())
    return CartModel(Inertia(mass, com, 0.09 * mass), RollingConstraints(), effects)


def main() -> None:
    parser = argparse.ArgumentParser("python -m benchmarks.filter_pushes", description=__doc__)
    parser.add_argument("--seeds", default="0:100", metavar="A:B")
    parser.add_argument("--only", choices=KINDS)
    options = parser.parse_args()
    seeds = range(*map(int, options.seeds.split(":")))
    print("| | runs | sure and wrong, mean s | runs with such a tick | not `ok`, mean s | `ok` at the end |", end="")
    print(" mass off at the end, median | by more than 5 % | deviations, rms |")
    print("| --- " * 9 + "|")
    for kind in KINDS if options.only is None else (options.only,):
        found = [drive(seed, kind) for seed in seeds]
        wrong, off = np.array([one.wrong for one in found]), np.abs([one.off for one in found])
        rms = np.sqrt(np.mean(np.square([one.deviations for one in found])))
        cells = [kind, len(found), f"{wrong.mean():.2f}", int((wrong > 0).sum())]
        cells += [f"{np.mean([one.unsound for one in found]):.2f}", sum(one.is_ok for one in found)]
        cells += [f"{100 * np.median(off):.1f} %", int((off > SETTLED).sum()), f"{rms:.2f}"]
        print(f"| {' | '.join(map(str, cells))} |", flush=True)


if __name__ == "__main__":
    main()
