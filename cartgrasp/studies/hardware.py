"""The paper's hardware experiments on MuJoCo: a cart on wheels and casters, noisy forces, velocities that jump.

E1 to E4 are 10 m straight runs with 15 to 45 kg (Fig. 9), E5 is push and pull in turn, with and without the casters'
swinging round in the estimator's model; two more are heavy loads that turn, at speeds of a ballbot that pushes a
wheelchair. The plant differs in structure from every model. A controller that knows the cart drives it once with one
hand; a run is what sensors would have made of that, so that what scatters is their noise alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from estimation import CartFilter, Prior
from planning.references import PathReference, Stretch, chain, pause, speed_change, straight, turn
from planning.tracking import build_tracker

from ..contacts import ContactWrenches
from ..effects import CasterRealignment, Effect, RollingResistance, ViscousDrag
from ..first_guess import PHYSICAL_NAMES
from ..frames import Array
from ..inertia import Inertia, physical_from_phi
from ..information import WrenchNoise as ForceNoise
from ..information import reduced_noise
from ..logs import RunLog
from ..model import CartModel
from ..motion import Measurement, Motion
from ..simulation.sensors import SensorNoise, Sensors
from .motion_bound import TrueMotion, information_of
from .parallel import Progress, run_all
from .scenario import filter_noise
from .shopping_cart import FIRM_GAINS, WHEELS

CONTROL_PERIOD = 0.01
HAND, HAND_POINT = "hand", (-0.25, 0.0, 1.0)
SENSOR_NOISE = SensorNoise(0.0004, 0.0004, 0.01, 0.01, 3.0, 0.15)
FILTER_NOISE = filter_noise(SENSOR_NOISE, disturbance=0.05, slip=0.0002)
PRIOR = Prior(mass=0.6, com=0.15, inertia=0.6, effects=0.5)
JUMP_PROBABILITY, JUMP_STD = 0.01, 0.3
"""Share of velocities that jump, and by how much (m/s, rad/s)."""
MIN_LEARNING_SPEED = 0.05
SEED_STRIDE = 1000
"""By kilogram: no two loads share their noise."""
WITH_CASTERS, WITHOUT_CASTERS = "casters swing", "casters left out"


@dataclass(frozen=True)
class Experiment:
    """`mass` (kg) along a path, and what the estimator's model has of the casters."""

    name: str
    mass: float
    path: tuple[Stretch, ...]
    casters: str = WITHOUT_CASTERS

    @property
    def cart(self) -> CartModel:
        """What is pushed: its load lies off the middle."""
        drags = ViscousDrag(linear=2.0, angular=0.4), RollingResistance(coefficient=0.015)
        inertia = Inertia(self.mass, (0.36, 0.05), 0.09 * self.mass)
        effects = *drags, CasterRealignment(swivel_torque=0.12)
        return CartModel(inertia, effects=effects, wheels=WHEELS, com_height=0.45)

    @property
    def guess(self) -> CartModel:
        """What is believed at first, whatever the load."""
        effects: tuple[Effect, ...] = (ViscousDrag(linear=3.0, angular=1.0), RollingResistance(coefficient=0.02))
        if self.casters == WITH_CASTERS:
            effects += (CasterRealignment(swivel_torque=0.06),)
        return CartModel(Inertia(30.0, (0.3, 0.0), 3.0), effects=effects, wheels=WHEELS, com_height=0.45)


STRAIGHT_RUN = chain(straight(10.0, 0.5, 0.5))
STOP_YAW_RATE = 0.05
"""rad/s, of yaw, with which a leg of push and pull goes into its stop: casters that are pushed back along a perfect
line stay poised on their turning point for a metre and more, and no hands and no floor are that straight."""


def leg(way: int) -> tuple[Stretch, ...]:
    """2.5 m forth (1) or back (-1), and a rest."""
    into, stop = Stretch(0.5, 0.0, way * STOP_YAW_RATE / 0.5), Stretch(0.8, -way * 0.5, -way * STOP_YAW_RATE / 0.8)
    return chain(speed_change(way * 0.4), pause(4.95), [into, stop], pause(0.5))


PUSH_PULL = chain(*(leg(way) for way in (1, -1) * 4))
TURNING = chain(*(speed_change(0.45), turn(1.2, 0.3, 0.5), turn(-1.2, 0.3, 0.5), pause(0.5), speed_change(-0.45))) * 3
STRAIGHT_EXPERIMENTS = tuple(
    Experiment(f"E{i}", mass, STRAIGHT_RUN) for i, mass in enumerate((15.0, 25.0, 35.0, 45.0), 1)
)
REVERSAL_EXPERIMENTS = tuple(Experiment("E5", 29.7, PUSH_PULL, casters) for casters in (WITH_CASTERS, WITHOUT_CASTERS))
HEAVY_EXPERIMENTS = tuple(Experiment(f"{mass:.0f} kg", mass, TURNING, WITH_CASTERS) for mass in (60.0, 80.0))
EXPERIMENTS = (*STRAIGHT_EXPERIMENTS, *REVERSAL_EXPERIMENTS, *HEAVY_EXPERIMENTS)


@dataclass(frozen=True, eq=False)
class Drive:
    """What truly happens at the control steps: motions and wrenches of the hand (n, 6)."""

    motions: tuple[Motion, ...]
    wrenches: Array


@dataclass(frozen=True, eq=False)
class Outcome:
    """Over the runs: mass (runs, n) and its standard deviation over time, and at the end the errors of mass, CoM and
    inertia (runs, 4); with the true mass, the times (n,) and the reversals' times, and the bound of the mass's standard
    deviation."""

    experiment: Experiment
    time: Array
    mass: Array
    std: Array
    errors: Array
    bound: float
    reversals: Array


def drive(experiment: Experiment) -> Drive:
    """In MuJoCo."""
    from ..simulation.mujoco_plant import MujocoPlant

    cart = experiment.cart
    plant, tracker = MujocoPlant(cart), build_tracker(cart.constraints, FIRM_GAINS)
    reference = PathReference(experiment.path, cart.rolling)
    motions, wrenches = [], []
    for k in range(round(reference.duration / CONTROL_PERIOD)):
        motion = plant.motion
        fx, _, moment = tracker.wrench_b(reference.at(CONTROL_PERIOD * k), motion, cart)
        wrench = np.array([fx, 0.0, 0.0, 0.0, 0.0, moment + HAND_POINT[1] * fx])
        motions.append(motion)
        wrenches.append(wrench)
        plant.step(ContactWrenches({HAND: wrench}, {HAND: np.array(HAND_POINT)}), CONTROL_PERIOD)
    return Drive(tuple(motions), np.array(wrenches))


def record(experiment: Experiment, driven: Drive, seed: int) -> RunLog:
    """As sensors would."""
    sensors, random = Sensors(experiment.cart, SENSOR_NOISE, seed), np.random.default_rng([seed, 1])
    rows = []
    for k, (motion, wrench) in enumerate(zip(driven.motions, driven.wrenches, strict=True)):
        now = CONTROL_PERIOD * k
        seen = sensors.motion(now, motion)
        felt = sensors.wrenches(now, ContactWrenches({HAND: wrench}, {HAND: np.array(HAND_POINT)}))
        jump = JUMP_STD * random.standard_normal(3) * (random.random() < JUMP_PROBABILITY)
        velocity = None if seen.velocity is None else seen.velocity + jump
        rows.append(Measurement(now, seen.pose, velocity, felt.wrenches, felt.contacts))
    return RunLog.from_measurements(rows, [HAND])


def mass_bound(experiment: Experiment, driven: Drive) -> float:
    """Cramér-Rao's, of the standard deviation of the mass, kg: from the true motion, the noise of all sensors, wrenches
    at speed, and the prior. What the casters do is taken as known."""
    effects = experiment.cart.effects[:2]
    cart = replace(experiment.cart, effects=effects)
    first = replace(experiment.guess, effects=experiment.guess.effects[:2])
    velocity = np.array([motion.velocity for motion in driven.motions])
    pose = np.array([motion.pose_sb for motion in driven.motions])
    fast = np.abs(velocity[1:, 0] + velocity[:-1, 0]) / 2 >= MIN_LEARNING_SPEED
    noise = reduced_noise(cart, [HAND_POINT], ForceNoise(SENSOR_NOISE.force, SENSOR_NOISE.moment))
    told = information_of(cart, TrueMotion(pose, velocity, CONTROL_PERIOD, fast), noise, SENSOR_NOISE)
    information = told + np.linalg.inv(PRIOR.covariance(first))
    return float(np.sqrt(np.linalg.inv(information)[0, 0]))


def reversal_times(driven: Drive) -> Array:
    """Where the cart, at speed, goes the other way than before, s."""
    u = np.array([motion.velocity[0] for motion in driven.motions])
    at_speed = np.flatnonzero(np.abs(u) >= MIN_LEARNING_SPEED)
    return np.asarray(CONTROL_PERIOD * at_speed[1:][np.diff(np.sign(u[at_speed])) != 0])


def attempt(experiment: Experiment, seeds: Sequence[int]) -> Outcome:
    """One drive, a recording for each seed."""
    driven = drive(experiment)
    mass, std, errors = [], [], []
    for seed in seeds:
        estimator = CartFilter(
            experiment.guess, [HAND], noise=FILTER_NOISE, prior=PRIOR, least_speed=MIN_LEARNING_SPEED
        )
        log = record(experiment, driven, seed + SEED_STRIDE * round(experiment.mass))
        found = [estimator.update(row).parameters["mass"] for row in log.measurements()]
        mass.append([one.value for one in found])
        std.append([one.std for one in found])
        last = estimator.estimate.parameters
        errors.append([last[name].value for name in PHYSICAL_NAMES])
    true = physical_from_phi(experiment.cart.inertia.phi)
    return Outcome(
        experiment=experiment,
        time=np.asarray(CONTROL_PERIOD * np.arange(len(driven.motions))),
        mass=np.array(mass),
        std=np.array(std),
        errors=np.array(errors) - true,
        bound=mass_bound(experiment, driven),
        reversals=reversal_times(driven),
    )


def run_seeds(seeds: Sequence[int], workers: int = 1, progress: Progress = None) -> list[Outcome]:
    """All experiments, over `workers` processes."""
    return run_all(partial(attempt, seeds=seeds), EXPERIMENTS, workers, progress)
