"""What hands pay at equal tracking error, by what is known of a load and where they hold: the paper's headline.

A truck on a handle 0.25 m behind its fixed wheels, casters ahead, in MuJoCo: a start, two curves, a stop, a start and a
stop. The drags are known, the load is not. A path asks for the same net wrench of whoever follows it equally well, so
ways are compared where they do: `gains` of each are scaled by one number until its rms position error is that of the
learned cart, held in the middle of the handle, with the usual gains.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import product
from math import exp, inf, log

import numpy as np

from planning import Choosing, RegraspTimes
from planning.contact_sources.lookahead import ContactFamily
from planning.contact_sources.strategies import FIXED as STAY
from planning.contact_sources.strategies import TEACH
from planning.excitation.excitation_family import motions
from planning.references import PathReference, chain, pause, speed_change, turn
from planning.tracking import Gains

from ..arms import Arm
from ..constraints import RollingConstraints
from ..effects import RollingResistance, ViscousDrag
from ..errors import PlantError
from ..first_guess import FirstGuess
from ..frames import Array
from ..inertia import Inertia
from ..information import WrenchNoise
from ..model import CartModel
from ..simulation.closed_loop import run
from ..simulation.record import RunRecord
from .parallel import Progress, run_all
from .run_figures import RunFigures
from .scenario import FIRST_GUESS, LEARNING, MUJOCO_PLANT, Scenario, scaled
from .shopping_cart import FILTER_NOISE, SENSOR_NOISE, four_wheels

MASSES, COM_OFFSETS, HANDS = (15.0, 40.0, 80.0), (0.0, 0.1, 0.2), (1, 2)
WRONG_GUESS_KEPT, USUAL_LOAD_KEPT, LEARNED = "wrong guess kept", "usual load kept", "learned"
KNOWLEDGE = (WRONG_GUESS_KEPT, USUAL_LOAD_KEPT, LEARNED)
"""An empty cart of 15 kg is believed in; a usual load of 40 kg; the same, 25 kg to either side, and learned."""
MIDDLE_PLACE, BEST_PLACE, CHOSEN_PLACE = "middle", "best", "chosen"
GRIP_CHOICES = (MIDDLE_PLACE, BEST_PLACE, CHOSEN_PLACE)
"""Held in the middle of the handle; where the whole path costs least by the truth; chosen in the loop."""
WHEELS = four_wheels(0.32, 0.8, 0.3)
HANDLE_X, HEIGHT = -0.25, 1.0
LEFT_GRIPS = (0.15, -0.05, 0.05, 0.25, 0.35)
GRIPS: dict[int, dict[str, tuple[float, ...]]] = {
    1: {"hand": (0.0, 0.1, -0.1, 0.2, -0.2, 0.3, -0.3)},
    2: {"left": LEFT_GRIPS, "right": tuple(-y for y in LEFT_GRIPS)},
}
"""y of the places where each of so many hands may hold, the middle's first, m."""
MIN_HAND_DISTANCE, COM_X, GYRATION_RADIUS = 0.15, 0.4, 0.33  # m
MOMENT_WEIGHT = 10.0  # in the effort, beside that of forces, 1
WRENCH_NOISE = WrenchNoise(SENSOR_NOISE.force, SENSOR_NOISE.moment)
FIRST_GUESS_STD = FirstGuess((("mass", 25.0), ("com_x", 0.15), ("com_y", 0.15), ("inertia", 3.0)))
START, STOP = (*speed_change(0.6), *pause(1.0)), (*speed_change(-0.6), *pause(1.2))
BEND_MANOEUVRE = (*turn(np.pi / 3, 0.5), *pause(0.5), *turn(-np.pi / 3, 0.5), *pause(0.5))
PATH = chain(START, STOP, START, BEND_MANOEUVRE, STOP)
GAIN_RANGE, MAX_GAIN_TRIES, TYPICAL_GAIN_SLOPE = (0.25, 8.0), 4, -1.5
"""Bounds of the factor on gains, how many are tried at most, and the usual log-log slope of the error by the gain."""
EQUAL_ERROR_TOLERANCE, MAX_BRACKET_RATIO = 0.02, 1.6
"""Log ratio within which errors count as equal, and ratio within which they are near."""
FIGURES = ("gain", "error", "force", "moment", "largest_force", "largest_moment", "effort")


def cart(mass: float, aside: float) -> CartModel:
    """The truck with its CoM `aside` to the left, m."""
    inertia = Inertia(mass, (COM_X, aside), mass * GYRATION_RADIUS**2)
    drags = ViscousDrag(2.0, 0.4), RollingResistance(0.015)
    return CartModel(inertia, RollingConstraints(), drags, WHEELS, com_height=0.45, name=f"truck of {mass:g} kg")


def arms(hands: int, grips: Sequence[float] | None = None, moment_weight: float = MOMENT_WEIGHT) -> tuple[Arm, ...]:
    """At all places of the handle, or each at one of `grips`, m."""
    force, moment = (120.0, 80.0, 40.0), (20.0, 20.0, 20.0)
    weights = (1.0, 1.0, 1.0, moment_weight, moment_weight, moment_weight)
    places = {name: ys if grips is None else (grips[i],) for i, (name, ys) in enumerate(GRIPS[hands].items())}
    return tuple(
        Arm(name, [(HANDLE_X, y, HEIGHT) for y in ys], weights=weights, force_limit=force, moment_limit=moment)
        for name, ys in places.items()
    )


def scenario(truth: CartModel, hands: Sequence[Arm], knowledge: str, place: str, gain: float, seed: int) -> Scenario:
    guess = cart(15.0 if knowledge == WRONG_GUESS_KEPT else 40.0, 0.0)
    return Scenario(
        truth=truth,
        guess=replace(guess, first_guess=FIRST_GUESS_STD),
        arms=tuple(hands),
        stretches=PATH,
        sensors=SENSOR_NOISE,
        noise=FILTER_NOISE,
        known=frozenset({"viscous_drag", "rolling_resistance"}),
        estimation=LEARNING if knowledge == LEARNED else FIRST_GUESS,
        plant=MUJOCO_PLANT,
        contacts=TEACH if place == CHOSEN_PLACE else STAY,
        choosing=Choosing(every=2.0, asked={}, noise=WRENCH_NOISE, min_hand_distance=MIN_HAND_DISTANCE),
        regrasp=RegraspTimes(speed=0.8),
        gains=scaled(Gains(), gain),
        seed=seed,
    )


@dataclass(frozen=True)
class RunCost:
    """What one run costs: by how much its gains were scaled, the rms position error (m), mean effort (N²) and regrasps.
    Forces (N) and moments (N·m) are the rms of all hands', and the largest of one hand. All are infinite where the cart
    tips over."""

    gain: float
    error: float
    force: float = inf
    moment: float = inf
    largest_force: float = inf
    largest_moment: float = inf
    effort: float = inf
    regrasps: int = 0

    @classmethod
    def of(cls, record: RunRecord, gain: float) -> RunCost:
        wrenches = np.array(list(record.wrenches.values()))
        (force, peak), (moment, largest) = (_rms_and_largest(part) for part in (wrenches[..., :3], wrenches[..., 3:]))
        weights = np.array(arms(1)[0].weights)
        figures = RunFigures.of(record)
        effort = float((wrenches**2 @ weights).sum(axis=0).mean())
        return cls(gain, figures.rms_error, force, moment, peak, largest, effort, figures.regrasps)

    def is_equal(self, error: float) -> bool:
        return bool(abs(log(self.error / error)) <= EQUAL_ERROR_TOLERANCE)


def _rms_and_largest(parts: Array) -> tuple[float, float]:
    """The rms of all n vectors of (n, T, 3) together, and the largest of one."""
    sizes = np.linalg.norm(parts, axis=2)
    return float(np.sqrt((sizes**2).sum(axis=0).mean())), float(sizes.max())


@dataclass(frozen=True)
class Job:
    """A truck, its hands, and the seed of its sensors' noise."""

    mass: float
    aside: float
    hands: int
    seed: int


@dataclass(frozen=True)
class Comparison:
    """What each way paid, by (knowledge, place), at the error (m) that all were to have."""

    job: Job
    error: float
    paid: dict[tuple[str, str], RunCost]

    def share(self, figure: str, one: tuple[str, str], other: tuple[str, str]) -> float:
        """A figure of one way by that of another; NaN where either does not reach the error."""
        ways = self.paid[one], self.paid[other]
        if not all(way.is_equal(self.error) for way in ways):
            return np.nan
        return float(getattr(ways[0], figure) / getattr(ways[1], figure))


def drive(job: Job, knowledge: str, place: str, gain: float) -> RunCost:
    """One run."""
    truth, hands = cart(job.mass, job.aside), arms(job.hands)
    grips = best_grips(truth, hands) if place == BEST_PLACE else [arm.contacts.points[0][1] for arm in hands]
    held = {arm.name: (HANDLE_X, y, HEIGHT) for arm, y in zip(hands, grips, strict=True)}
    hands = hands if place == CHOSEN_PLACE else arms(job.hands, grips)
    try:
        return RunCost.of(run(scenario(truth, hands, knowledge, place, gain, job.seed).build(held=held)), gain)
    except PlantError:
        return RunCost(gain, inf)


def compare(job: Job) -> Comparison:
    """All ways at the error of the learned cart that is held in the middle, with the usual gains."""
    first = drive(job, LEARNED, MIDDLE_PLACE, 1.0)
    paid = {(LEARNED, MIDDLE_PLACE): first}
    for knowledge, place in product(KNOWLEDGE, GRIP_CHOICES):
        if (knowledge, place) not in paid:
            paid[knowledge, place] = at_error(first.error, partial(drive, job, knowledge, place))
    return Comparison(job, first.error, paid)


def at_error(error: float, run_with: Callable[[float], RunCost]) -> RunCost:
    """What is paid at an error: gains are sought by secants over logarithms until two runs enclose the error closely,
    and their figures interpolated so. Where no gain reaches it, the run that comes nearest."""
    tries = [run_with(1.0)]
    while len(tries) < MAX_GAIN_TRIES and tries[-1].error < inf and not _enclosed(tries, error):
        gain = min(max(_next_gain(tries, error), GAIN_RANGE[0]), GAIN_RANGE[1])
        if any(abs(log(gain / before.gain)) < 0.01 for before in tries):
            break
        tries.append(run_with(gain))
    near = _around(tries, error)
    if len(near) < 2:
        return min(tries, key=lambda paid: abs(log(paid.error / error)))
    share = log(error / near[0].error) / log(near[1].error / near[0].error)
    ends = np.log([[getattr(paid, name) for name in FIGURES] for paid in near])
    figures = np.exp((1 - share) * ends[0] + share * ends[1]).tolist()
    return RunCost(**dict(zip(FIGURES, figures, strict=True)), regrasps=max(paid.regrasps for paid in near))


def _around(tries: Sequence[RunCost], error: float) -> list[RunCost]:
    """The runs next below and above, as far as there are any."""
    below = sorted((paid for paid in tries if paid.error <= error), key=lambda paid: -paid.error)
    above = sorted((paid for paid in tries if error < paid.error < inf), key=lambda paid: paid.error)
    return below[:1] + above[:1]


def _enclosed(tries: Sequence[RunCost], error: float) -> bool:
    near = _around(tries, error)
    return any(paid.is_equal(error) for paid in near) or (
        len(near) == 2 and near[1].error < MAX_BRACKET_RATIO * near[0].error
    )


def _next_gain(tries: Sequence[RunCost], error: float) -> float:
    near = _around(tries, error)
    if len(near) < 2:
        near = sorted(tries, key=lambda paid: abs(log(paid.error / error)))[:2]
    slope = TYPICAL_GAIN_SLOPE
    if len(near) == 2:
        slope = min(log(near[0].error / near[1].error) / log(near[0].gain / near[1].gain), -0.5)
    return near[0].gain * exp(log(error / near[0].error) / slope)


def run_seeds(seeds: Sequence[int], workers: int = 1, progress: Progress = None) -> list[Comparison]:
    """Every truck with every seed, over `workers` processes."""
    jobs = [Job(mass, aside, n, seed) for n, mass, aside, seed in product(HANDS, MASSES, COM_OFFSETS, seeds)]
    return run_all(compare, jobs, workers, progress)


# --- what statics allow ---------------------------------------------------------------------------------------


def best_grips(truth: CartModel, hands: Sequence[Arm]) -> list[float]:
    """y of each hand, m, where the whole path takes the least effort."""
    path = PathReference(PATH)
    lookahead = ContactFamily.of(truth, hands, WRENCH_NOISE, MIN_HAND_DISTANCE).ahead(truth, path, (0.0, path.duration))
    best = lookahead.cheapest(np.zeros(len(lookahead.lowest)))
    assert best is not None, "every grip can drive the path"
    return [float(y) for y in lookahead.family.choices[best][:, 1]]


def best_by_statics(aside: float, hands: int, moment_weight: float = MOMENT_WEIGHT) -> tuple[float, float]:
    """The rms force and the effort in the best place, as shares of those in the middle, along the exact path and
    without limits."""
    truth, path = cart(40.0, aside), PathReference(PATH)
    family = ContactFamily.of(truth, arms(hands, None, moment_weight), WRENCH_NOISE, MIN_HAND_DISTANCE)
    lowest = family.ahead(truth, path, (0.0, path.duration)).lowest
    needed, best = motions(path, truth, (0.0, path.duration), 0.0).needed[0], int(lowest.argmin())
    firsts = [ys[0] for ys in GRIPS[hands].values()]
    middle = next(i for i, one in enumerate(family.choices) if (one[:, 1] == firsts).all())
    wrenches = [family.split.wrenches(i, needed).reshape(-1, hands, 6) for i in (best, middle)]
    forces = [_rms_and_largest(np.moveaxis(one[..., :3], 1, 0))[0] for one in wrenches]
    return forces[0] / forces[1], float(lowest[best] / lowest[middle])
