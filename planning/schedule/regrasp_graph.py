"""Grips in time: the states that arms can be in from stage to stage, the options that lead on, and the least sum.

An arm's state is the candidate that it holds or goes to, and for how many stages it is still on its way. In a stage an
arm holds, starts a regrasp, or goes on with one; a regrasp that takes d > 0 stages gives no wrench in any of them, and
with d = 0 it is done at the stage's start. The joint state is the product over arms, and the least cost to go obeys
Bellman's `V_k(s) = min over options of (cost_k(option) + V_k+1(after))`: exact, for sums over stages.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cartgrasp.errors import UsageError
from cartgrasp.frames import Array

from .stage_efforts import NO_CONTACT

MAX_JOINT_OPTIONS = 5_000_000
Indices = NDArray[np.intp]


@dataclass(frozen=True, eq=False)
class Options:
    """Ways on, (m,) each, sorted by `before`: from a state to a state, with a choice of grips (a row of the table of
    `StageEfforts`), starting so many regrasps."""

    before: Indices
    after: Indices
    choice: Indices
    regrasps: Indices


@dataclass(frozen=True, eq=False)
class RegraspGraph:
    """The graph of states and options for arms with `counts` candidates, and regrasps that take `stages` stages."""

    counts: tuple[int, ...]
    stages: int
    options: Options

    @classmethod
    def of(cls, counts: Sequence[int], stages: int) -> RegraspGraph:
        each = [_options(count, stages) for count in counts]
        size = np.prod([len(options.before) for options in each], dtype=float)
        if size > MAX_JOINT_OPTIONS:
            raise UsageError(f"schedule: {size:.0f} joint options a stage are too many; fewer contacts, longer stages")
        states, grips = [count * max(1, stages) for count in counts], [count + 1 for count in counts]
        ways = np.indices([len(options.before) for options in each]).reshape(len(each), -1)
        pairs = list(zip(each, ways, strict=True))
        joint = Options(
            before=np.ravel_multi_index([own.before[way] for own, way in pairs], states),
            after=np.ravel_multi_index([own.after[way] for own, way in pairs], states),
            choice=np.ravel_multi_index([own.choice[way] for own, way in pairs], grips),
            regrasps=np.sum([own.regrasps[way] for own, way in pairs], axis=0),
        )
        order = np.argsort(joint.before, kind="stable")
        return cls(tuple(counts), stages, Options(*(part[order] for part in vars(joint).values())))

    def state(self, grips: ArrayLike, waits: ArrayLike = 0) -> Indices:
        """The joint states (...) of arms that hold, or reach in so many stages, these candidates (..., n)."""
        own = np.asarray(grips) * max(1, self.stages) + np.asarray(waits)
        return np.asarray(np.ravel_multi_index(tuple(np.moveaxis(own, -1, 0)), self._sizes))

    def grips(self, states: ArrayLike) -> Indices:
        """Per arm, the candidates (..., n) that are held or gone to in states (...)."""
        return np.stack(np.unravel_index(np.asarray(states), self._sizes), axis=-1) // max(1, self.stages)

    @property
    def _sizes(self) -> tuple[int, ...]:
        """How many states each arm has."""
        return tuple(count * max(1, self.stages) for count in self.counts)

    @property
    def at_rest(self) -> Indices:
        """The states in which every arm holds."""
        return self.state(np.stack(np.unravel_index(np.arange(np.prod(self.counts)), self.counts), axis=-1))

    def costs_to_go(self, costs: Array, regrasp: float) -> Array:
        """V, (stages + 1, states), for the cost of each stage and choice of grips, and of each regrasp."""
        options, starts = self.options, self._starts
        values = np.zeros((len(costs) + 1, len(starts)))
        for k in range(len(costs) - 1, -1, -1):
            ways = costs[k, options.choice] + regrasp * options.regrasps + values[k + 1, options.after]
            values[k] = np.minimum.reduceat(ways, starts)
        return values

    def best_path(self, costs: Array, regrasp: float, values: Array, start: int) -> list[int]:
        """The options taken from a start, one a stage; of equal ones, one that regrasps least."""
        options, state, path = self.options, start, []
        ends = np.append(self._starts[1:], len(options.before))
        for k in range(len(costs)):
            ways = np.arange(self._starts[state], ends[state])
            spent = regrasp * options.regrasps[ways]
            total = costs[k, options.choice[ways]] + spent + values[k + 1, options.after[ways]]
            best = ways[np.lexsort((options.regrasps[ways], total))[0]]
            path.append(int(best))
            state = int(options.after[best])
        return path

    def blocked(self, costs: Array, starts: Indices) -> int | None:
        """The first stage that no sequence of options gets past."""
        options = self.options
        reached = np.zeros(len(self._starts), dtype=bool)
        reached[starts] = True
        for k in range(len(costs)):
            open_ways = reached[options.before] & np.isfinite(costs[k, options.choice])
            reached = np.zeros_like(reached)
            reached[options.after[open_ways]] = True
            if not reached.any():
                return k
        return None

    @property
    def _starts(self) -> Indices:
        return np.flatnonzero(np.diff(self.options.before, prepend=-1))


def _options(count: int, stages: int) -> Options:
    """The options of one arm with `count` candidates, for regrasps that take `stages` stages."""
    levels = max(1, stages)
    rows = [(grip * levels, grip * levels, grip, 0) for grip in range(count)]
    rows += [
        (grip * levels + j, grip * levels + j - 1, NO_CONTACT, 0) for grip in range(count) for j in range(1, levels)
    ]
    for grip in range(count):
        for other in range(count):
            if other != grip:
                rows.append((grip * levels, other * levels + levels - 1, NO_CONTACT if stages else other, 1))
    before, after, held, regrasps = np.array(rows).T
    return Options(before, after, held - NO_CONTACT, regrasps)
