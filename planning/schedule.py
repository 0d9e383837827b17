"""When and where to regrasp over a horizon: the proven least effort, by dynamic programming over grips.

The horizon is cut into stages; the wrench that the reference asks for in a stage's middle stands for the stage. A
schedule costs

    sum over stages of (effort of the stage's QP) * (its length) + (effort of a regrasp) * (number of regrasps),

and an arm on its way gives nothing, so the others bear the whole. The sum separates over stages, so the dynamic program
finds the least; run again over certified lower bounds of every QP, it gives a bound that no schedule is below.
`plan_schedule` is a pure function of reference, cart and what is held now: call it again when the estimate has changed.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from cartgrasp.arms import Arm
from cartgrasp.errors import UsageError
from cartgrasp.frames import Array

from .contact_regions import DISTANCE_TOLERANCE, hand_distance
from .quadratic_program import INFEASIBLE, NUMERICAL, OPTIMAL
from .regrasp_graph import Indices, RegraspGraph
from .stage_efforts import AWAY, StageEfforts, candidate_points, stage_efforts, why_not

if TYPE_CHECKING:
    from cartgrasp.model import CartModel
    from cartgrasp.roles import ReferencePath

EQUAL = 1e-12
"""Relative difference of totals that counts as none."""


@dataclass(frozen=True)
class RegraspCost:
    """For `duration` (s, rounded up to whole stages) the arm gives no wrench; `effort` (N²·s) is added once."""

    duration: float = 0.5
    effort: float = 0.0

    def __post_init__(self) -> None:
        if not (np.isfinite([self.duration, self.effort]).all() and min(self.duration, self.effort) >= 0):
            raise UsageError(f"regrasp: {self} must have a finite duration and effort >= 0")


@dataclass(frozen=True, eq=False)
class Grip:
    """The contact (3,) in {b} that an arm holds, or from the time `ready` (s) on will hold."""

    contact: Array
    ready: float = -np.inf


@dataclass(frozen=True)
class Horizon:
    """From `now` (s) to the reference's end, in stages of at most `stage` (s). `held` are the grips that one starts
    from, by arm; without it the first grips are chosen, free of charge."""

    now: float = 0.0
    stage: float = 0.25
    held: Mapping[str, Grip] | None = None
    min_hand_distance: float = 0.0


@dataclass(frozen=True, eq=False)
class Regrasp:
    """An arm leaves `origin` (3,) at `start` and holds `target` (3,) from `stop` on, s."""

    arm: str
    start: float
    stop: float
    origin: Array
    target: Array


@dataclass(frozen=True)
class BlockedStage:
    """A stage that can't be done, and why."""

    start: float
    stop: float
    words: str


@dataclass(frozen=True, eq=False)
class Schedule:
    """K stages between `times` (K + 1,), with the effort (N²) of each; by arm, contacts (K, 3) in {b} held or gone to,
    and whether the arm `holds` (K,). No schedule costs less than `bound` (N²·s); `solved` counts QPs. When
    `infeasible`, `blocked` names the stages and there are no contacts."""

    status: str
    times: Array
    contacts: Mapping[str, Array] = field(default_factory=dict)
    holds: Mapping[str, Array] = field(default_factory=dict)
    efforts: Array = field(default_factory=lambda: np.zeros(0))
    regrasps: tuple[Regrasp, ...] = ()
    total: float = np.inf
    bound: float = np.inf
    solved: int = 0
    blocked: tuple[BlockedStage, ...] = ()

    @property
    def gap(self) -> float:
        """Relative: (total - bound) / max(1, total)."""
        return max(0.0, (self.total - self.bound) / max(1.0, self.total)) if np.isfinite(self.total) else np.inf

    def grips(self, time: float) -> dict[str, Grip]:
        """What each arm holds or goes to at a time: where to start the next schedule from."""
        k = int(np.clip(np.searchsorted(self.times, time + 1e-9, side="right") - 1, 0, len(self.times) - 2))
        ready = {r.arm: r.stop for r in self.regrasps if r.start <= time + 1e-9 < r.stop}
        return {arm: Grip(points[k], ready.get(arm, -np.inf)) for arm, points in self.contacts.items()}


def plan_schedule(
    reference: ReferencePath,
    cart: CartModel,
    arms: Sequence[Arm],
    cost: RegraspCost = RegraspCost(),
    horizon: Horizon = Horizon(),
) -> Schedule:
    """The least effort from now to the reference's end, over every way to hold and to regrasp the arms' points."""
    times = _stage_times(reference, horizon)
    length = float(times[1] - times[0])
    middles = (times[:-1] + times[1:]) / 2
    wrenches = np.array([wanted_wrench(reference, cart, time) for time in middles])
    efforts = stage_efforts(cart, arms, wrenches, horizon.min_hand_distance)
    points = candidate_points(arms)
    stages = int(np.ceil(cost.duration / length - 1e-9))
    graph = RegraspGraph.of([len(candidates) for candidates in points.values()], stages)
    starts = _starts(graph, points, horizon, length)
    values = graph.costs_to_go(length * efforts.efforts, cost.effort)
    bound = float(graph.costs_to_go(length * efforts.bounds, cost.effort)[0, starts].min())
    least = float(values[0, starts].min())
    if not np.isfinite(least):
        at = graph.blocked(efforts.efforts, starts)
        blocked = _blocked(cart, arms, (times, wrenches), efforts, (at, horizon.min_hand_distance))
        status = INFEASIBLE if np.isinf(bound) else NUMERICAL
        return Schedule(status, times, bound=bound, solved=efforts.solved, blocked=blocked)
    equal = starts[values[0, starts] <= least * (1.0 + EQUAL)]
    paths = [graph.best_path(length * efforts.efforts, cost.effort, values, int(start)) for start in equal]
    path = min(paths, key=lambda path: int(graph.options.regrasps[path].sum()))
    return _told(graph, points, path, efforts, (times, least, bound))


def wanted_wrench(reference: ReferencePath, cart: CartModel, time: float) -> Array:
    """The planar wrench (3,) in {b} with which a cart that is on its reference stays on it."""
    wanted = reference.at(time)
    state = cart.state(wanted.pose_sb, wanted.velocity)
    return cart.planar_wrench(cart.required_wrench(state, wanted.acceleration, time=time))


def _stage_times(reference: ReferencePath, horizon: Horizon) -> Array:
    left = reference.duration - horizon.now
    if not (np.isfinite(left) and left > 0):
        raise UsageError(f"horizon: now = {horizon.now} s is not before the reference's end, {reference.duration:g} s")
    if not (np.isfinite(horizon.stage) and horizon.stage > 0):
        raise UsageError(f"horizon: a stage of {horizon.stage} s is not a finite time > 0")
    return np.linspace(horizon.now, reference.duration, int(np.ceil(left / horizon.stage - 1e-9)) + 1)


def _starts(graph: RegraspGraph, points: Mapping[str, Array], horizon: Horizon, length: float) -> Indices:
    """The states that one may start in."""
    if horizon.held is None:
        at_rest = graph.at_rest
        contacts = np.array([[p[i] for p, i in zip(points.values(), graph.grips(s), strict=True)] for s in at_rest])
        return at_rest[hand_distance(contacts) >= horizon.min_hand_distance - DISTANCE_TOLERANCE]
    if set(horizon.held) != set(points):
        raise UsageError(f"horizon: grips of {sorted(horizon.held)} are given, arms are {sorted(points)}")
    grips, waits = [], []
    for name, candidates in points.items():
        grip = horizon.held[name]
        away = np.abs(candidates - np.asarray(grip.contact, dtype=float)).max(axis=1)
        if not away.min() < 1e-6:
            raise UsageError(f"horizon: arm {name} holds {list(grip.contact)}, which is none of its points")
        grips.append(int(away.argmin()))
        wait = int(np.ceil(max(0.0, grip.ready - horizon.now) / length - 1e-9))
        if wait > max(0, graph.stages - 1):
            raise UsageError(f"horizon: arm {name} is ready at {grip.ready:g} s, later than a regrasp from now takes")
        waits.append(wait)
    return np.array([graph.state(grips, waits)])


def _blocked(
    cart: CartModel,
    arms: Sequence[Arm],
    asked: tuple[Array, Array],
    efforts: StageEfforts,
    known: tuple[int | None, float],
) -> tuple[BlockedStage, ...]:
    """Stages that no grips can do, and the one that no sequence of regrasps gets past."""
    (times, wrenches), (at, distance) = asked, known
    found = []
    for k in np.flatnonzero(np.isinf(efforts.efforts).all(axis=1)).tolist():
        words = why_not(cart, arms, wrenches[k], distance) or "no solver gave a verified answer"
        found.append(BlockedStage(float(times[k]), float(times[k + 1]), words))
    if at is not None and np.isfinite(efforts.efforts[at]).any():
        words = (
            "some grips can do it, but no sequence of regrasps leads to them: what is held before can't do it, and "
            "while an arm is on its way the others can't bear the wrench"
        )
        found.append(BlockedStage(float(times[at]), float(times[at + 1]), words))
    return tuple(sorted(found, key=lambda stage: stage.start))


def _told(
    graph: RegraspGraph,
    points: Mapping[str, Array],
    path: Sequence[int],
    efforts: StageEfforts,
    result: tuple[Array, float, float],
) -> Schedule:
    """The path as contacts by time."""
    times, total, bound = result
    choices = graph.options.choice[list(path)]
    after = np.array([graph.grips(int(graph.options.after[i])) for i in path])
    before = np.array([graph.grips(int(graph.options.before[i])) for i in path])
    regrasps = []
    for i, (name, candidates) in enumerate(points.items()):
        for k in np.flatnonzero(after[:, i] != before[:, i]).tolist():
            stop = times[min(k + graph.stages, len(times) - 1)]
            ends = candidates[before[k, i]], candidates[after[k, i]]
            regrasps.append(Regrasp(name, float(times[k]), float(stop), *ends))
    return Schedule(
        status=OPTIMAL,
        times=times,
        contacts={name: candidates[after[:, i]] for i, (name, candidates) in enumerate(points.items())},
        holds={name: efforts.grips[choices, i] != AWAY for i, name in enumerate(points)},
        efforts=efforts.efforts[np.arange(len(choices)), choices],
        regrasps=tuple(sorted(regrasps, key=lambda r: r.start)),
        total=total,
        bound=bound,
        solved=efforts.solved,
    )
