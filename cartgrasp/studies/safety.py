"""Whether carts that are not known yet skid or tip over: high loads that are driven hard, in MuJoCo.

Carts of 10 to 100 kg are drawn with their CoM anywhere between the wheels that leaves each its least load, and for each
a first guess that is as unsure as it says. Two hands on a handle start, bend and stop the cart. How high a load
lies no sensor tells: it is known. In each tick the true cart's limits are worked out for the motion that the plant has
and the wrenches that it gets.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product
from math import inf

import numpy as np

from planning import Caution, Skid, TipOver
from planning.references import PathReference, Stretch, pause

from ..constraints import RollingConstraints
from ..contacts import ContactWrenches
from ..effects import RollingResistance, ViscousDrag
from ..errors import PlantError, UsageError
from ..first_guess import PHYSICAL_NAMES, FirstGuess
from ..frames import Array
from ..inertia import Inertia
from ..model import CartModel
from ..motion import Motion
from ..simulation.closed_loop import Loop, run
from ..simulation.mujoco_plant import MujocoPlant
from ..simulation.sensors import Sensors
from .parallel import Progress, run_all
from .robust_margins import CONFIDENCE, FRICTION, LIMIT_TOLERANCE, effort_of, room
from .scenario import FIRST_GUESS, LEARNING, Scenario
from .shopping_cart import FILTER_NOISE, SENSOR_NOISE, four_wheels, two_hands

BLIND, GUESSED, ESTIMATED, CONFIDENT, TRUTH_KNOWN = (
    *("no limits", "limits of the first guess", "limits of the estimate"),
    *("limits of the estimate, 99 %", "limits of the true cart"),
)
GUESS_STD_TWICE, GUESS_STD_THRICE = "99 %, guess twice as unsure", "99 %, guess three times as unsure"
WAYS = (BLIND, GUESSED, ESTIMATED, CONFIDENT, GUESS_STD_TWICE, GUESS_STD_THRICE, TRUTH_KNOWN)
GUESS_STD_FACTORS = {GUESS_STD_TWICE: 2.0, GUESS_STD_THRICE: 3.0}
"""As wide deviations of the first guess, with which margins give way, and a cautious controller slows down."""
MAX_ARRIVAL_DELAY = 10.0
"""s that such a cart may be late."""
MIN_WHEEL_LOAD = 5.0
LIMITS = (TipOver(MIN_WHEEL_LOAD), Skid(FRICTION))
ARMS = two_hands(0.2, (150.0, 80.0, 80.0), (15.0, 15.0, 15.0))
DISTURBANCE = 0.5
"""N: what the filter is told that its model lacks: loads that lean, and casters that swing round."""
WHEELS = four_wheels(0.3, 0.72, 0.28)
MASS_RANGE, COM_X_RANGE, COM_Y_RANGE, HEIGHT_RANGE = (10.0, 100.0), (0.1, 0.6), (-0.15, 0.15), (0.5, 1.0)
MIN_REST_LOAD_RATIO = 2.0
"""Times its least load that each wheel of a drawn cart carries at rest."""
GUESS_DEVIATIONS = 0.15, 0.04, 0.04, 0.3
"""Standard deviations of a first guess: shares of mass and inertia, m of the CoM."""
PATH = (
    *(Stretch(0.8, 1.0), *pause(0.3)),
    *(Stretch(0.4, 0.0, 2.0), *pause(0.6), Stretch(0.8, 0.0, -2.0), *pause(0.6), Stretch(0.4, 0.0, 2.0)),
    *(Stretch(0.4, -2.0), *pause(0.4)),
)
ARRIVAL_WAIT, ARRIVAL_DISTANCE, ARRIVAL_SPEED = 2.0, 0.05, 0.05
"""s that a cart may be late, m from the end at which it has arrived, m/s."""


def drawn(seed: int, times: float = 1.0) -> tuple[CartModel, CartModel]:
    """A cart, and what is believed of it at first, with `times` the usual deviations; beliefs in what is no cart are
    drawn again."""
    random = np.random.default_rng([7, seed])
    while True:
        mass, x, y, height = (random.uniform(*span) for span in (MASS_RANGE, COM_X_RANGE, COM_Y_RANGE, HEIGHT_RANGE))
        truth = _cart((mass, x, y, mass * random.uniform(0.08, 0.16)), height)
        if (truth.wheel_set.loads(truth.inertia.phi) > MIN_REST_LOAD_RATIO * MIN_WHEEL_LOAD).all():
            break
    body = truth.inertia
    values = np.array([body.mass, *body.com, body.about_com])
    std = times * np.array(GUESS_DEVIATIONS) * [body.mass, 1.0, 1.0, body.about_com]
    while True:
        try:
            guess = _cart(values + std * random.normal(size=4).clip(-2.5, 2.5), height)
            break
        except UsageError:
            continue
    told = tuple(zip(PHYSICAL_NAMES, std.tolist(), strict=True))
    return truth, replace(guess, first_guess=FirstGuess(told))


def _cart(values: Sequence[float] | Array, height: float) -> CartModel:
    mass, x, y, about = map(float, values)
    drags = ViscousDrag(2.0, 0.4), RollingResistance(0.015)
    return CartModel(Inertia(mass, (x, y), about), RollingConstraints(), drags, WHEELS, com_height=height)


@dataclass(frozen=True)
class Run:
    """A cart driven one way. How far the true cart stayed inside its limits, `room` (N, by tick; negative: beyond), and
    the least load (N) that a wheel in MuJoCo had in each; effort (N²), its sum over the usual time; when it arrived (s;
    infinite if it did not, or fell); and whether it fell."""

    seed: int
    way: str
    room: Array
    loads: Array
    effort: float
    arrived: float
    fell: bool

    @property
    def violates(self) -> bool:
        return self.fell or bool(self.room.min() < -LIMIT_TOLERANCE)


class WatchedPlant:
    """A plant, and beside it what happened in each tick."""

    def __init__(self, truth: CartModel) -> None:
        self._truth, self._plant = truth, MujocoPlant(truth)
        self.acceleration = self._plant.acceleration
        self.room: list[float] = []
        self.loads: list[float] = []
        self.efforts: list[float] = []
        self.motions: list[Motion] = []

    @property
    def time(self) -> float:
        return self._plant.time

    @property
    def motion(self) -> Motion:
        return self._plant.motion

    def step(self, wrenches: ContactWrenches, duration: float) -> None:
        self.room.append(room(self._truth, self.motion, wrenches.spatial_wrench_b, MIN_WHEEL_LOAD))
        self.efforts.append(effort_of(wrenches.wrenches))
        self.motions.append(self.motion)
        self._plant.step(wrenches, duration)
        self.loads.append(float(self._plant.wheel_loads().min()))


def scenario(truth: CartModel, guess: CartModel, way: str, seed: int) -> Scenario:
    return Scenario(
        truth=truth,
        guess=replace(truth, first_guess=guess.first_guess) if way == TRUTH_KNOWN else guess,
        arms=ARMS,
        stretches=PATH,
        sensors=SENSOR_NOISE,
        noise=replace(FILTER_NOISE, disturbance=DISTURBANCE),
        known=frozenset({"viscous_drag", "rolling_resistance"}),
        estimation=FIRST_GUESS if way in (GUESSED, TRUTH_KNOWN) else LEARNING,
        seed=seed,
    )


def drive(seed: int, way: str) -> Run:
    """One run."""
    truth, guess = drawn(seed, GUESS_STD_FACTORS.get(way, 1.0))
    made = scenario(truth, guess, way, seed)
    sure = CONFIDENCE if way in (CONFIDENT, *GUESS_STD_FACTORS) else None
    plant, end = WatchedPlant(truth), PathReference(PATH)
    wait = MAX_ARRIVAL_DELAY if way in GUESS_STD_FACTORS else ARRIVAL_WAIT
    controller = made.controller(
        cart_limits=() if way == BLIND else LIMITS,
        confidence=sure,
        caution=Caution() if way in GUESS_STD_FACTORS else None,
    )
    controller.warm_up()
    loop = Loop(controller, plant, Sensors(truth, made.sensors, seed))
    fell = False
    try:
        run(loop, end.duration + wait)
    except PlantError:
        fell = True
    goal, period = end.at(end.duration).pose_sb[:2], made.period
    away = np.array([np.hypot(*(motion.pose_sb[:2] - goal)) for motion in plant.motions])
    speed = np.array([abs(motion.velocity[0]) for motion in plant.motions])
    late = np.flatnonzero((away > ARRIVAL_DISTANCE) | (speed > ARRIVAL_SPEED))
    never = fell or not len(late) or late[-1] == len(away) - 1
    arrived = inf if never else period * float(late[-1] + 1)
    usual = min(len(plant.efforts), round((end.duration + ARRIVAL_WAIT) / period))
    effort = float(np.sum(plant.efforts)) / usual
    return Run(seed, way, np.array(plant.room), np.array(plant.loads), effort, arrived, fell)


def _drive(job: tuple[int, str]) -> Run:
    return drive(*job)


def run_seeds(seeds: Sequence[int], workers: int = 1, progress: Progress = None) -> list[Run]:
    """Every way with each cart, over `workers` processes."""
    return run_all(_drive, list(product(seeds, WAYS)), workers, progress)
