"""`python -m benchmarks.pose_rates [--seeds 0:3]`: a hard push, and silent arms, however seldom poses come.

A cart of 24 kg that is guessed at 18 kg, two hands of 80 N, curves at 0.6 m/s, `Caution()`. At 7 s 60 N push aside at
the cart's far end for half a second; or from 5 s on no arm tells its wrench for 3 s. Poses come at 100 to 20 Hz, with
velocities or without. Told is how far the cart gets off its path, and by how much its yaw rate is wrong.
"""

from __future__ import annotations

import argparse
from itertools import product

import numpy as np

from cartgrasp.arms import Arm
from cartgrasp.effects import ViscousDrag
from cartgrasp.inertia import Inertia
from cartgrasp.model import CartModel
from cartgrasp.motion import Measurement
from cartgrasp.simulation import ModelPlant, SensorNoise, Sensors
from cartgrasp.simulation.pushed_plant import Push, PushedPlant
from estimation import CartFilter, DisturbedFilter, FilterNoise
from planning import Caution, Controller, PathReference, chain, pause
from planning.references import speed_change, turn

from .sealed.__main__ import seeds

TRUTH = CartModel(Inertia(24.0, (0.3, 0.0), 2.0), effects=(ViscousDrag(3.0, 1.2),))
GUESS = TRUTH.with_inertia(Inertia(18.0, (0.25, 0.05), 1.5))
CURVES = *turn(1.2, 0.4), *pause(1.0), *turn(-1.2, 0.4), *pause(0.5)
PATH = PathReference(chain(speed_change(0.6), CURVES, CURVES, speed_change(-0.6)))
PUSH, PUSHED, SILENT = Push(np.array([0.0, 60.0, 0.0]), np.array([0.7, 0.1, 0.4])), (7.0, 7.5), (5.0, 8.0)
RATES, DURATION, PERIOD = (100, 50, 33, 20), 14.0, 0.01
KINDS = "push", "silent arms"
FILTERS = {"CartFilter": CartFilter, "DisturbedFilter": DisturbedFilter}


def run(kind: str, rate: int, has_velocity: bool, name: str, seed: int) -> tuple[float, float]:
    """The largest distance from the path (m) and error of the yaw rate (rad/s) from 5 s on."""
    limits = {"force_limit": (80.0, 60.0, 40.0), "moment_limit": (10.0,) * 3}
    arms = [Arm(arm, [(-0.25, y, 1.0)], **limits) for arm, y in (("left", 0.2), ("right", -0.2))]
    learner = FILTERS[name](GUESS, ["left", "right"], noise=FilterNoise(force=0.5, moment=0.02))
    controller = Controller(GUESS, arms, PATH, estimator=learner, regrasp=None, caution=Caution())
    sensors = Sensors(TRUTH, SensorNoise(force=0.5, moment=0.02), seed)
    acts = kind == "push"
    plant = PushedPlant(ModelPlant(TRUTH), lambda time, _: [PUSH] if acts and PUSHED[0] <= time < PUSHED[1] else [])
    off = wrong = 0.0
    for k in range(round(DURATION / PERIOD)):
        seen = sensors.motion(plant.time, plant.motion)
        is_due = k % round(100 / rate) == 0
        velocity = seen.velocity if has_velocity and is_due else None
        step = controller.step(Measurement(plant.time, seen.pose if is_due else None, velocity))
        if acts or not SILENT[0] <= plant.time < SILENT[1]:
            controller.observe(sensors.wrenches(plant.time, step.given))
        if plant.time > SILENT[0]:
            apart = plant.motion.pose_sb - step.reference.pose_sb
            off = max(off, float(np.hypot(*apart[:2])))
            wrong = max(wrong, abs(float(step.estimate.motion.velocity[1] - plant.motion.velocity[1])))
        plant.step(step.given, PERIOD)
    return off, wrong


def main() -> None:
    parser = argparse.ArgumentParser("python -m benchmarks.pose_rates", description=__doc__)
    parser.add_argument("--seeds", type=seeds, default=range(3), metavar="A:B")
    options = parser.parse_args()
    print("| what | poses, Hz | velocities | filter | off the path at most, m | yaw rate wrong at most, rad/s |")
    print("| --- " * 6 + "|")
    for kind, rate, has_velocity, name in product(KINDS, RATES, (True, False), FILTERS):
        found = np.array([run(kind, rate, has_velocity, name, seed) for seed in options.seeds]).max(axis=0)
        print(
            f"| {kind} | {rate} | {'yes' if has_velocity else 'no'} | {name} | {found[0]:.2f} | {found[1]:.2f} |",
            flush=True,
        )


if __name__ == "__main__":
    main()
