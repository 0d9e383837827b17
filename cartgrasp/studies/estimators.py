"""The estimators on the same logs: filter, regressor, the paper's form as printed, and `identify` as a reference.

A controller that knows the cart drives it along three paths, straight, in curves, and gently, with two hands; so no log
depends on an estimator. The sensors are quiet, usual or poor, or give poses without velocities. Each estimator is told
the sensors' noise and begins with the same wrong guess of load and drags.
"""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from estimation import FilterNoise
from estimation.whole_log.identification import identify
from estimation.whole_log.replay import ONLINE_ESTIMATORS, replay
from planning.references import PathReference, chain, pause, speed_change, straight, turn
from planning.tracking import build_tracker

from ..constraints import RollingConstraints
from ..contacts import ContactWrenches
from ..effects import RollingResistance, ViscousDrag
from ..frames import Array
from ..inertia import Inertia
from ..logs import RunLog
from ..model import CartModel
from ..motion import Measurement, ParameterEstimate
from ..simulation.plant import ModelPlant
from ..simulation.pushed_plant import PushedPlant, PushSource, no_pushes
from ..simulation.sensors import SensorNoise, Sensors
from .parallel import Progress, run_all
from .scenario import filter_noise

CONTROL_PERIOD = 0.01
MOTION_SETTLING_TIME = 1.0
"""s, from which on motions are compared."""
FILTER, REGRESSOR, IDENTIFY = "filter", "regressor", "identify"
WAYS = (*ONLINE_ESTIMATORS, IDENTIFY)
PATHS = {
    "straight": chain(straight(2.0, 0.6, 0.5), pause(0.5), straight(-2.0, 0.6, 0.5), pause(0.5)),
    "curves": chain(
        *(speed_change(0.6), turn(1.2, 0.6, 0.8), pause(0.5), turn(-2.0, 0.7, 0.8)),
        *(speed_change(-0.4), turn(1.0, 0.5, 0.8), speed_change(-0.2), pause(0.5)),
    ),
    "gentle": chain(speed_change(0.3, 0.1), turn(0.5, 0.2, 0.15), turn(-0.5, 0.2, 0.15), speed_change(-0.3, 0.1)),
}
SENSOR_SETS = {
    "quiet": SensorNoise(0.0002, 0.0002, 0.001, 0.001, 0.3, 0.015),
    "usual": SensorNoise(0.0004, 0.0004, 0.005, 0.005, 3.0, 0.15),
    "poor": SensorNoise(0.005, 0.005, 0.02, 0.02, 6.0, 0.3),
    "poses alone": SensorNoise(0.0004, 0.0004, 0.005, 0.005, 3.0, 0.15, velocity_period=None),
}
HANDS = {"left": (-0.25, 0.2, 1.0), "right": (-0.25, -0.2, 1.0)}


def truth() -> CartModel:
    effects = (ViscousDrag(linear=3.0, angular=1.2), RollingResistance(coefficient=0.015))
    return CartModel(Inertia(24.0, (0.28, 0.06), 2.2), RollingConstraints(), effects)


def guess() -> CartModel:
    effects = (ViscousDrag(linear=2.0, angular=1.0), RollingResistance(coefficient=0.02))
    return CartModel(Inertia(20.0, (0.3, 0.0), 1.8), RollingConstraints(), effects)


@dataclass(frozen=True)
class Job:
    """A log: its path and sensors by name."""

    path: str
    sensors: str
    seed: int


@dataclass(frozen=True)
class Answer:
    """What an estimator found in a log, the rms errors of speed (m/s) and yaw rate (rad/s) on the way (NaN where it
    tells no motion), and how long a row of it took, s."""

    parameters: dict[str, ParameterEstimate]
    health: str
    step_time: float
    motion_errors: tuple[float, float] = (math.nan, math.nan)


@dataclass(frozen=True)
class Trial:
    """The answers by estimator."""

    job: Job
    answers: dict[str, Answer]


@dataclass(frozen=True, eq=False)
class Drive:
    """A log, and the true pose and nu (n, 3 + k) at its rows."""

    log: RunLog
    motion: Array


def drive_cart(cart: CartModel, job: Job, duration: float | None = None, outside: PushSource = no_pushes) -> Drive:
    """A cart along the job's path, whatever else pushes it; whole or for a duration (s)."""
    plant, sensors = PushedPlant(ModelPlant(cart), outside), Sensors(cart, SENSOR_SETS[job.sensors], job.seed)
    reference, tracker = PathReference(PATHS[job.path], cart.rolling), build_tracker(cart.constraints)
    rows, motions = [], []
    for _ in range(round((duration or reference.duration) / CONTROL_PERIOD)):
        now, motion = plant.time, plant.motion
        given = shared(tracker.wrench_b(reference.at(now), motion, cart))
        sensed, felt = sensors.motion(now, motion), sensors.wrenches(now, given)
        rows.append(Measurement(now, sensed.pose, sensed.velocity, felt.wrenches, felt.contacts))
        motions.append(np.concatenate([motion.pose_sb, motion.velocity]))
        plant.step(given, CONTROL_PERIOD)
    return Drive(RunLog.from_measurements(rows, list(HANDS)), np.array(motions))


def shared(wrench_b: Array) -> ContactWrenches:
    """Forward forces of the hands alone."""
    contacts = {name: np.array(point) for name, point in HANDS.items()}
    levers = np.array([[1.0, 1.0], [-point[1] for point in HANDS.values()]])
    forces = np.linalg.solve(levers, wrench_b[[0, 2]])
    wrenches = {name: np.array([force, 0, 0, 0, 0, 0]) for name, force in zip(HANDS, forces, strict=True)}
    return ContactWrenches(wrenches, contacts)


def answer(driven: Drive, way: str, noise: FilterNoise) -> Answer:
    """The answer of one estimator to one drive."""
    log, begin = driven.log, time.process_time()
    if way == IDENTIFY:
        found = identify([log], guess(), noise=noise)
        return Answer(found.parameters, "", (time.process_time() - begin) / len(log))
    told = replay(log, ONLINE_ESTIMATORS[way](guess(), list(HANDS), noise=noise))
    step_time = (time.process_time() - begin) / len(log)
    velocity = np.array([estimate.motion.velocity for estimate in told.estimates])
    with np.errstate(over="ignore"):  # the paper's filter may be anywhere
        squares = np.square(velocity - driven.motion[:, 3:])[log.time >= MOTION_SETTLING_TIME]
    speed, yaw_rate = np.sqrt(squares.mean(axis=0))
    return Answer(dict(told.last.parameters), str(told.last.health), step_time, (float(speed), float(yaw_rate)))


def attempt(job: Job) -> Trial:
    """Every estimator on one log."""
    driven, noise = drive_cart(truth(), job), filter_noise(SENSOR_SETS[job.sensors])
    return Trial(job, {way: answer(driven, way, noise) for way in WAYS})


def run_seeds(seeds: Sequence[int], workers: int = 1, progress: Progress = None) -> list[Trial]:
    """Each path with each sensors and seed, over `workers` processes."""
    jobs = [Job(path, sensors, seed) for path in PATHS for sensors in SENSOR_SETS for seed in seeds]
    return run_all(attempt, jobs, workers, progress)
