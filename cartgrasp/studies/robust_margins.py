"""What margins are worth while a load is learned: the same pushes planned without margins, with them, and by the truth.

Two arms hold a cart by a handle above its load, so that its casters unload when it is braked. They stop it hard four
times: twice on a straight line, which can't teach where along x its load lies (physics.md), then twice in curves, which
do. Each seed draws another cart from what is believed at first, so the share of plans that break a true limit can be
held against the stated confidence. All ways answer the same wanted wrench at the same tick; the one with margins is
carried out, and the filter learns from it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from estimation import CartFilter, Prior
from planning import Plan, Skid, TipOver, WrenchPlanner
from planning.references import PathReference, Stretch, pause
from planning.tracking import build_tracker

from ..constraints import RollingConstraints
from ..effects import ViscousDrag
from ..floor_reaction import FloorReaction
from ..frames import Array
from ..inertia import Inertia, physical_from_phi
from ..model import CartModel
from ..motion import Estimate, Motion
from ..simulation.plant import ModelPlant
from ..simulation.sensors import Sensors
from .parallel import run_all
from .scenario import filter_noise
from .shopping_cart import SENSOR_NOISE, WHEELS, two_hands

NOMINAL, ROBUST, CART_KNOWN = "no margins", "99 % margins", "cart known"
WAYS = (NOMINAL, ROBUST, CART_KNOWN)
CONFIDENCE, MIN_MARGIN_LOAD, FRICTION = 0.99, 15.0, 0.5
LIMIT_TOLERANCE = 0.1
"""N: what the noise of the measured motion may do to a limit; less is not counted as broken."""
CONTROL_PERIOD = 0.01
ARMS = two_hands(0.2, (120.0, 60.0, 80.0), (12.0, 12.0, 12.0))
PRIOR = Prior(mass=0.15, com=0.04, inertia=0.2, known=frozenset({"viscous_drag"}))
FILTER_NOISE = filter_noise(SENSOR_NOISE)
STRAIGHT_LAP = (Stretch(0.6, 1.0), Stretch(0.3, -2.0), *pause(0.1))
CURVED_LAP = (
    *(Stretch(0.4, 1.0, 3.0), Stretch(0.4, 1.0, -3.0), Stretch(0.2, -2.0, -3.0), Stretch(0.2, -2.0, 3.0)),
    *pause(0.2),
)
PATH = (*STRAIGHT_LAP, *STRAIGHT_LAP, *CURVED_LAP, *CURVED_LAP)
LAP_TIMES = (0.0, 1.0, 2.0, 3.4, 4.8)
"""s: when each of them begins, and the end."""


def believed() -> CartModel:
    """The first guess; its load lies near the axle, which leaves the casters little."""
    inertia = Inertia(24.0, (0.2, 0.0), 2.0)
    return CartModel(
        inertia, RollingConstraints(), (ViscousDrag(3.0, 1.2),), WHEELS, com_height=0.45, name="first guess"
    )


def drawn(seed: int) -> CartModel:
    """A cart from what is believed at first."""
    guess, random = believed(), np.random.default_rng([seed, 5])
    mass, com_x, com_y, inertia = physical_from_phi(guess.inertia.phi) + random.normal(0.0, PRIOR.deviations(guess)[:4])
    return guess.with_inertia(Inertia(float(mass), (float(com_x), float(com_y)), float(inertia)))


@dataclass(frozen=True, eq=False)
class Run:
    """One cart, pushed and learned, n ticks; ways are in the order of WAYS. `room` (n, ways) is how far the true cart
    is inside its limits (N; negative: beyond), `at_limit` (n, ways) whether a limit of the cart was active; efforts
    (n, ways) are in N². Also the margins' largest `reserve` (n,), N, and the filter's deviation of the CoM (n,), m."""

    seed: int
    time: Array
    statuses: np.ndarray
    efforts: Array
    room: Array
    at_limit: np.ndarray
    reserve: Array
    com_x_std: Array

    @property
    def is_hard(self) -> np.ndarray:
        """(n,): the plan without margins, or that of the known cart, is at a limit of the cart."""
        return np.asarray(self.at_limit[:, 0] | self.at_limit[:, 2])


def drive(seed: int, duration: float | None = None) -> Run:
    """One run, whole or of a duration (s): the plant, the filter and the three planners of a seed."""
    truth, guess = drawn(seed), believed()
    plant, sensors = ModelPlant(truth), Sensors(truth, SENSOR_NOISE, seed)
    learner = CartFilter(guess, [arm.name for arm in ARMS], noise=FILTER_NOISE, prior=PRIOR)
    reference, tracker = PathReference(PATH, guess.rolling), build_tracker(guess.constraints)
    limits = (TipOver(MIN_MARGIN_LOAD), Skid(FRICTION))
    planners = [
        WrenchPlanner(guess, ARMS, cart_limits=limits, confidence=sure, relax=np.inf, period=CONTROL_PERIOD)
        for sure in (None, CONFIDENCE, None)
    ]
    ticks = []
    for _ in range(round((reference.duration if duration is None else duration) / CONTROL_PERIOD)):
        time, motion = plant.time, plant.motion
        estimate = learner.update(sensors.motion(time, motion))
        wanted = tracker.wrench_b(reference.at(time), estimate.motion, estimate.cart())
        known = Estimate(estimate.time, estimate.motion, {}, "", truth, truth.parameters)
        told = (estimate, estimate, known)
        plans = [p.plan_or_hold(wanted, estimate=e) for p, e in zip(planners, told, strict=True)]
        given = plans[1].contact_wrenches
        learner.update(sensors.wrenches(time, given))
        plant.step(given, CONTROL_PERIOD)
        ticks.append(_tick(truth, motion, plans, estimate))
    return Run(seed, *map(np.array, zip(*ticks, strict=True)))


def _tick(truth: CartModel, motion: Motion, plans: Sequence[Plan], estimate: Estimate) -> tuple[Any, ...]:
    """One row of each part of a `Run`, in its order."""
    given = [plan.contact_wrenches for plan in plans]
    return (
        estimate.time,
        [plan.status for plan in plans],
        [effort_of(one.wrenches) for one in given],
        [room(truth, motion, one.spatial_wrench_b, MIN_MARGIN_LOAD) for one in given],
        [any("skid" in name or "wheel" in name for name in plan.active) for plan in plans],
        _reserve(plans[1]),
        estimate.parameters["com_x"].std,
    )


def effort_of(wrenches: Mapping[str, Array]) -> float:
    """The effort of wrenches, N², with the weights that arms usually have."""
    weights = np.array(ARMS[0].weights)
    return float(sum(w**2 @ weights for w in wrenches.values()))


def room(truth: CartModel, motion: Motion, wrench_b: Array, least_load: float) -> float:
    """How far a cart is inside its limits under a spatial wrench (6,), N: skid, and a least load (N) on each wheel."""
    floor = FloorReaction.of(truth, motion)
    loads = floor.loads(wrench_b)
    skid = FRICTION * loads[~truth.wheel_set.is_caster].sum() - abs(float(floor.lateral(wrench_b)))
    return float(min(loads.min() - least_load, skid))


def _reserve(plan: Plan) -> float:
    """The largest margin of a plan, N; 0 without any."""
    if plan.proof is None:
        return 0.0
    program, solution = plan.proof
    lengths = [float(np.linalg.norm((cone.offset + cone.rows @ solution.x)[1:])) for cone in program.cones]
    return max(lengths, default=0.0)


run_seeds = partial(run_all, drive)
"""A run for each seed."""
