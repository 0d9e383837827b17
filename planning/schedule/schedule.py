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

import numpy as np

from cartgrasp.arms import Arm
from cartgrasp.errors import UsageError
from cartgrasp.frames import Array
from cartgrasp.model import CartModel
from cartgrasp.roles import ReferencePath

from ..contacts.contact_regions import DISTANCE_TOLERANCE, hand_distance
from ..planner import WrenchPlanner
from ..quadratic_program import INFEASIBLE, NUMERICAL, OPTIMAL
from ..tracking import wrench_on_reference
from .regrasp_graph import Indices, RegraspGraph
from .stage_efforts import NO_CONTACT, StageEfforts, candidate_points, stage_efforts

EQUAL_COST_RATIO = 1e-12
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
    """From `now` (s) for `length` (s), but at most to the reference's end, in stages of at most `stage` (s). `held` are
    the grips that one starts from, by arm; without it the first grips are chosen, free of charge."""

    now: float = 0.0
    stage: float = 0.25
    held: Mapping[str, Grip] | None = None
    min_hand_distance: float = 0.0
    length: float = np.inf


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

    def grips(self, time: float) -> dict[str, Grip]:
        """What each arm holds or goes to at a time: where to start the next schedule from."""
        k = int(np.clip(np.searchsorted(self.times, time + 1e-9, side="right") - 1, 0, len(self.times) - 2))
        ready = {r.arm: r.stop for r in self.regrasps if r.start <= time + 1e-9 < r.stop}
        return {arm: Grip(points[k], ready.get(arm, -np.inf)) for arm, points in self.contacts.items()}


DEFAULT_COST, WHOLE_REFERENCE = RegraspCost(), Horizon()


def plan_schedule(
    reference: ReferencePath,
    cart: CartModel,
    arms: Sequence[Arm],
    cost: RegraspCost = DEFAULT_COST,
    horizon: Horizon = WHOLE_REFERENCE,
) -> Schedule:
    """The least effort from now to the reference's end, over every way to hold and to regrasp the arms' points. Stages
    last seconds, so rates of the arms don't count."""
    arms = [arm.without_rate() for arm in arms]
    problem = _Problem.of(reference, cart, arms, cost, horizon)
    graph, times, length = problem.graph, problem.times, problem.length
    efforts = stage_efforts(cart, arms, problem.wrenches, horizon.min_hand_distance)
    starts = problem.starts(horizon)
    values = graph.costs_to_go(length * efforts.efforts, cost.effort)
    bound = float(graph.costs_to_go(length * efforts.bounds, cost.effort)[0, starts].min())
    least = float(values[0, starts].min())
    if not np.isfinite(least):
        status = INFEASIBLE if np.isinf(bound) else NUMERICAL
        blocked = problem.blocked(efforts, starts, horizon.min_hand_distance)
        return Schedule(status, times, bound=bound, solved=efforts.solved, blocked=blocked)
    equal = starts[values[0, starts] <= least * (1.0 + EQUAL_COST_RATIO)]
    paths = [graph.best_path(length * efforts.efforts, cost.effort, values, int(start)) for start in equal]
    path = min(paths, key=lambda path: int(graph.options.regrasps[path].sum()))
    choices = graph.options.choice[path]
    return Schedule(
        status=OPTIMAL,
        times=times,
        contacts=problem.contacts(path),
        holds={name: efforts.grips[choices, i] != NO_CONTACT for i, name in enumerate(problem.points)},
        efforts=efforts.efforts[np.arange(len(choices)), choices],
        regrasps=problem.regrasps(path),
        total=least,
        bound=bound,
        solved=efforts.solved,
    )


def wanted_wrench(reference: ReferencePath, cart: CartModel, time: float) -> Array:
    """The planar wrench (3,) in {b} that a tracker asks for at a time, of a cart that is on its reference."""
    return wrench_on_reference(cart, reference.at(time))


@dataclass(frozen=True, eq=False)
class _Problem:
    """Stages between `times` (K + 1,) that ask for `wrenches` (K, 3); the arms' points by name, and their grips in
    time."""

    cart: CartModel
    arms: Sequence[Arm]
    times: Array
    wrenches: Array
    points: Mapping[str, Array]
    graph: RegraspGraph

    @classmethod
    def of(
        cls, reference: ReferencePath, cart: CartModel, arms: Sequence[Arm], cost: RegraspCost, horizon: Horizon
    ) -> _Problem:
        times = _stage_times(reference, horizon)
        wrenches = np.array([wanted_wrench(reference, cart, time) for time in (times[:-1] + times[1:]) / 2])
        points = candidate_points(arms)
        stages = int(np.ceil(cost.duration / (times[1] - times[0]) - 1e-9))
        within = min(stages, len(times))  # a longer one is not over by the end either
        graph = RegraspGraph.of([len(candidates) for candidates in points.values()], within)
        return cls(cart, arms, times, wrenches, points, graph)

    @property
    def length(self) -> float:
        return float(self.times[1] - self.times[0])

    def starts(self, horizon: Horizon) -> Indices:
        """The states that one may start in."""
        graph, points = self.graph, self.points
        if horizon.held is None:
            states = graph.at_rest
            grips = graph.grips(states)
            contacts = np.stack([p[grips[:, i]] for i, p in enumerate(points.values())], axis=1)
            return states[hand_distance(contacts) >= horizon.min_hand_distance - DISTANCE_TOLERANCE]
        if set(horizon.held) != set(points):
            raise UsageError(f"horizon: grips of {sorted(horizon.held)} are given, arms are {sorted(points)}")
        pairs = [self._start(name, horizon.held[name], horizon.now) for name in points]
        return np.array([graph.state(*zip(*pairs, strict=True))])

    def _start(self, name: str, grip: Grip, now: float) -> tuple[int, int]:
        """Which point an arm holds or goes to, and for how many stages it is still on its way."""
        away = np.abs(self.points[name] - np.asarray(grip.contact, dtype=float)).max(axis=1)
        if not away.min() < 1e-6:
            raise UsageError(f"horizon: arm {name} holds {list(grip.contact)}, which is none of its points")
        wait = min(int(np.ceil(max(0.0, grip.ready - now) / self.length - 1e-9)), len(self.times) - 1)
        if wait > max(0, self.graph.stages - 1):
            raise UsageError(f"horizon: arm {name} is ready at {grip.ready:g} s, later than a regrasp from now takes")
        return int(away.argmin()), wait

    def contacts(self, path: Sequence[int]) -> dict[str, Array]:
        """By arm, what is held or gone to in each stage, (K, 3)."""
        after = self.graph.grips(self.graph.options.after[path])
        return {name: candidates[after[:, i]] for i, (name, candidates) in enumerate(self.points.items())}

    def regrasps(self, path: Sequence[int]) -> tuple[Regrasp, ...]:
        options = self.graph.options
        before, after = (self.graph.grips(part[path]) for part in (options.before, options.after))
        found = []
        for i, (name, candidates) in enumerate(self.points.items()):
            for k in np.flatnonzero(after[:, i] != before[:, i]).tolist():
                stop = self.times[min(k + self.graph.stages, len(self.times) - 1)]
                ends = candidates[before[k, i]], candidates[after[k, i]]
                found.append(Regrasp(name, float(self.times[k]), float(stop), *ends))
        return tuple(sorted(found, key=lambda regrasp: regrasp.start))

    def blocked(self, efforts: StageEfforts, starts: Indices, distance: float) -> tuple[BlockedStage, ...]:
        """Stages that no grips can do, and the one that no sequence of regrasps gets past."""
        found = {}
        for k in np.flatnonzero(np.isinf(efforts.efforts).all(axis=1)).tolist():
            plan = WrenchPlanner(self.cart, self.arms, min_hand_distance=distance).plan(self.wrenches[k])
            words = "" if plan.status == OPTIMAL else plan.message
            found[k] = words or "no solver gave a verified answer"
        last = self.graph.blocked(efforts.efforts, starts)
        if last is not None and last not in found:
            found[last] = (
                "some grips can do it, but no sequence of regrasps leads to them: what is held before can't do it, "
                "and while an arm is on its way the others can't bear the wrench"
            )
        edges = self.times.tolist()
        return tuple(BlockedStage(edges[k], edges[k + 1], found[k]) for k in sorted(found))


def _stage_times(reference: ReferencePath, horizon: Horizon) -> Array:
    left = reference.duration - horizon.now
    if not (np.isfinite(left) and left > 0):
        raise UsageError(f"horizon: now = {horizon.now} s is not before the reference's end, {reference.duration:g} s")
    if not (np.isfinite(horizon.stage) and horizon.stage > 0):
        raise UsageError(f"horizon: a stage of {horizon.stage} s is not a finite time > 0")
    if not horizon.length > 0:
        raise UsageError(f"horizon: a length of {horizon.length} s is not a time > 0")
    left = min(left, horizon.length)
    return np.linspace(horizon.now, horizon.now + left, int(np.ceil(left / horizon.stage - 1e-9)) + 1)
