"""What the model does not explain, in the loop: loads, pushes, ramps, sills and floors, beside what others do.

A cart that nobody knows is drawn, pushed by two hands along one path in MuJoCo, and disturbed on the way. Each way to
control it meets the same draws, with the same limits, sensors and poles of the tracking error. Observers are as quick
as the same noise of what they observe allows; one is twice as quick.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from estimation import CartFilter, DisturbedFilter
from planning import Controller
from planning.references import PathReference, chain, pause, speed_change, turn

from ..constraints import RollingConstraints
from ..effects import CasterRealignment, PayloadChange, RollingResistance, ViscousDrag
from ..errors import PlantError
from ..frames import Array, body_to_world, wrap_angle
from ..inertia import Inertia
from ..model import CartModel
from ..motion import Motion
from ..simulation.closed_loop import Loop, run
from ..simulation.pushed_plant import Push, PushedPlant, PushSource, no_pushes
from ..simulation.sensors import Sensors
from ..wheels import GRAVITY
from .disturbance_peers import ExtendedStateObserver, PaperTracker
from .parallel import Progress, run_all
from .shopping_cart import FILTER_NOISE as SHOPPING_NOISE
from .shopping_cart import FIRM_GAINS, SENSOR_NOISE, WHEELS, two_hands

LOAD, PUSH, RAMP, SILL, FLOOR = "load", "push", "ramp", "sill", "floor"
OURS, ESO, QUICK_ESO = "ours", "extended-state observer", "the same, twice as quick"
PAPER, PAPER_KEPT = "paper's law, learning", "paper's law, guess kept"
WAYS = OURS, ESO, QUICK_ESO, PAPER, PAPER_KEPT
FILTER_NOISE = replace(SHOPPING_NOISE, disturbance=0.02)
BANDWIDTHS = {ESO: 21.0, QUICK_ESO: 42.0}
"""rad/s: of the first, noise of poses makes the disturbance of 30 kg as uncertain as ours, 1 N."""
DISTURBANCE_KINDS = (LOAD, PUSH, RAMP, SILL, FLOOR)
SPEED_DIP = *speed_change(-0.25), *speed_change(0.25)
PATH = chain(
    *(speed_change(0.5), pause(0.3), SPEED_DIP, SPEED_DIP, turn(-0.5, 0.4), pause(0.3)),
    *(SPEED_DIP, turn(0.8, 0.4), pause(0.5), SPEED_DIP),
    *(pause(0.5), turn(-0.8, 0.4), pause(0.5), SPEED_DIP, pause(1.0), speed_change(-0.5), pause(1.5)),
)
CONTROL_PERIOD = 0.01
ARMS = two_hands(0.22, (120.0, 10.0, 20.0), (15.0, 15.0, 15.0))
ONSET_TIME = 5.6
"""s, from which on things happen and errors count."""
RAMP_ANGLE = math.radians(3.0)
WHEEL_RADIUS = 0.06
"""m, of wheels."""


@dataclass(frozen=True)
class Case:
    """What happens to a drawn cart."""

    kind: str
    seed: int

    @property
    def random(self) -> np.random.Generator:
        return np.random.default_rng([self.seed, DISTURBANCE_KINDS.index(self.kind), 33])

    @property
    def cart(self) -> CartModel:
        """25 to 50 kg, with the load that may be put on it."""
        random = self.random
        mass, x, y = random.uniform(25.0, 50.0), random.uniform(0.2, 0.45), random.uniform(-0.08, 0.08)
        effects: tuple[Any, ...] = (
            ViscousDrag(linear=2.0, angular=0.4),
            RollingResistance(coefficient=random.uniform(0.008, 0.02)),
            CasterRealignment(swivel_torque=0.1),
        )
        if self.kind == LOAD:
            place = random.uniform(0.15, 0.55), random.uniform(-0.15, 0.15)
            effects += (PayloadChange(random.uniform(ONSET_TIME, 9.0), random.uniform(5.0, 30.0), *place),)
        inertia = Inertia(mass, (x, y), 0.09 * mass)
        return CartModel(inertia, RollingConstraints(), effects, WHEELS, com_height=0.45, name=str(self))

    @property
    def guess(self) -> CartModel:
        effects = ViscousDrag(linear=3.0, angular=1.0), RollingResistance(0.015), CasterRealignment(swivel_torque=0.06)
        inertia = Inertia(25.0, (0.3, 0.0), 2.2)
        return CartModel(inertia, RollingConstraints(), effects, WHEELS, com_height=0.45, name="first guess")

    @property
    def outside(self) -> PushSource:
        """What pushes the cart beside the hands."""
        if self.kind == LOAD:
            return no_pushes
        return {PUSH: _push, RAMP: _ramp, SILL: _sill, FLOOR: _floor}[self.kind](self)


def _push(case: Case) -> PushSource:
    """20 to 60 N for 0.5 s, from any side, somewhere on the cart, three times."""
    random = np.random.default_rng([case.seed, 1])
    starts = ONSET_TIME + np.array([0.2, 2.7, 5.2]) + random.uniform(0.0, 1.0, 3)
    size, angle = random.uniform(20.0, 60.0, 3), random.uniform(-np.pi, np.pi, 3)
    points = np.stack([random.uniform(0.0, 0.72, 3), random.uniform(-0.25, 0.25, 3), np.full(3, 0.45)], axis=1)

    def now(time: float, motion: Motion) -> Sequence[Push]:
        for start, f, way, point in zip(starts, size, angle, points, strict=True):
            if start <= time < start + 0.5:
                return (Push(f * np.array([np.cos(way), np.sin(way), 0.0]), point),)
        return ()

    return now


def _ramp(case: Case) -> PushSource:
    """3° up or down, 0.6 to 1.5 m long, in the world's x; its ends are as long as the wheels are apart."""
    random, cart = np.random.default_rng([case.seed, 2]), case.cart
    begin, length, way = random.uniform(2.9, 3.6), random.uniform(0.6, 1.5), random.choice([-1.0, 1.0])
    weight, com = GRAVITY * cart.inertia.mass, np.array([*cart.inertia.com, 0.45])

    def now(time: float, motion: Motion) -> Sequence[Push]:
        back = body_to_world(motion.pose_sb[2]).T
        x = motion.pose_sb[0] + (back.T @ com)[0]
        share = np.clip((x - begin) / 0.72, 0, 1) * np.clip((begin + length + 0.72 - x) / 0.72, 0, 1)
        force = back @ np.array([-way * share * weight * math.sin(RAMP_ANGLE), 0.0, 0.0])
        return (Push(force, com),)

    return now


def _sill(case: Case) -> PushSource:
    """Sharp, 2 to 5 mm high, at two places of the world's x; each wheel's middle goes round its edge."""
    random, cart = np.random.default_rng([case.seed, 3]), case.cart
    places, heights = np.array([random.uniform(2.9, 3.5), random.uniform(3.8, 4.6)]), random.uniform(0.002, 0.005, 2)
    loads, spots = cart.wheel_set.loads(cart.inertia.phi), np.array([[w.x, w.y, 0.0] for w in WHEELS])

    def now(time: float, motion: Motion) -> Sequence[Push]:
        turned, pushes = body_to_world(motion.pose_sb[2]), []
        for spot, load in zip(spots, loads, strict=True):
            x = motion.pose_sb[0] + (turned @ spot)[0]
            for place, high in zip(places, heights, strict=True):
                if (x - place) ** 2 < WHEEL_RADIUS**2 - (WHEEL_RADIUS - high) ** 2:
                    fx = load * (x - place) / math.sqrt(WHEEL_RADIUS**2 - (x - place) ** 2)
                    pushes.append(Push(turned.T @ np.array([fx, 0.0, 0.0]), spot))
        return pushes

    return now


def _floor(case: Case) -> PushSource:
    """Rolling resistance that is 0 to 0.05 higher from place to place."""
    random, cart = np.random.default_rng([case.seed, 4]), case.cart
    rough, weight = random.uniform(0.0, 0.05, 40) * random.integers(0, 2, 40), GRAVITY * cart.inertia.mass
    com = np.array([*cart.inertia.com, 0.0])

    def now(time: float, motion: Motion) -> Sequence[Push]:
        c = rough[int(motion.pose_sb[0] / 0.5) % 40] if time > ONSET_TIME else 0.0
        return (Push(np.array([-c * weight * math.tanh(motion.velocity[0] / 0.01), 0.0, 0.0]), com),)

    return now


@dataclass(frozen=True, eq=False)
class Outcome:
    """From ONSET_TIME on: errors of position (n,) and heading (n,), m and rad, beside what the cart is to do, the force
    of the hands (n,), N, and the largest error of the mass as a share, NaN where none is learned; of a load, from
    MASS_SETTLING_TIME after it is put on. `fell` says whether the cart tipped over."""

    case: Case
    way: str
    position: Array
    heading: Array
    force: Array
    mass_error: float = math.nan
    fell: bool = False


MASS_SETTLING_TIME = 4.0
"""s after a load from which on the mass counts."""


def attempt(job: tuple[Case, str]) -> Outcome:
    """One run."""
    from ..simulation.mujoco_plant import MujocoPlant

    case, way = job
    cart = case.cart
    plant = PushedPlant(MujocoPlant(cart), case.outside)
    driver = controller(case.guess, way)
    driver.warm_up()
    try:
        record = run(Loop(driver, plant, Sensors(cart, SENSOR_NOISE, case.seed)))
    except PlantError:
        return Outcome(case, way, np.zeros(0), np.zeros(0), np.zeros(0), fell=True)
    late, error = record.time >= ONSET_TIME, record.pose - record.reference_pose
    force = sum(np.linalg.norm(wrench[:, :3], axis=1) for wrench in record.wrenches.values())
    return Outcome(
        case,
        way,
        position=np.hypot(error[late, 0], error[late, 1]),
        heading=np.abs(wrap_angle(error[late, 2])),
        force=np.asarray(force)[late],
        mass_error=_mass_error(case, record.time, record.parameters["mass"].value) if record.parameters else math.nan,
    )


def controller(guess: CartModel, way: str) -> Controller:
    """By name."""
    names, reference = [arm.name for arm in ARMS], PathReference(PATH)
    usual: dict[str, Any] = {"gains": FIRM_GAINS, "regrasp": None, "learn": way in (OURS, PAPER)}
    if way in BANDWIDTHS:
        observer = ExtendedStateObserver(guess, BANDWIDTHS[way])
        return Controller(observer.cart, ARMS, reference, estimator=observer, **usual)
    kind = DisturbedFilter if way == OURS else CartFilter
    tracker = None if way == OURS else PaperTracker(FIRM_GAINS)
    return Controller(
        guess, ARMS, reference, estimator=kind(guess, names, noise=FILTER_NOISE), tracker=tracker, **usual
    )


def _mass_error(case: Case, time: Array, mass: Array) -> float:
    loads = [effect.time for effect in case.cart.effects if isinstance(effect, PayloadChange)]
    counts = time >= max([ONSET_TIME, *(load + MASS_SETTLING_TIME for load in loads)])
    return float(np.abs(mass / case.cart.phi_at(time)[:, 0] - 1.0)[counts].max())


def run_seeds(seeds: Sequence[int], workers: int = 1, progress: Progress = None) -> list[Outcome]:
    """Each kind, seed and way, over `workers` processes."""
    jobs = [(Case(kind, seed), way) for seed in seeds for kind in DISTURBANCE_KINDS for way in WAYS]
    return run_all(attempt, jobs, workers, progress)
