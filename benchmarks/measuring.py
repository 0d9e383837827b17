"""Times of competitors that take turns, so that whatever else the machine does falls on all of them alike."""

from __future__ import annotations

import gc
import os
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

Competitor = Callable[[int], object]


@dataclass(frozen=True)
class Times:
    """What one competitor took, call by call, in s; `cold` are the first calls of its turns, in no median."""

    warm: tuple[float, ...]
    cold: tuple[float, ...]

    @classmethod
    def of(cls, turns: list[list[float]]) -> Times:
        """With one call a turn there is no difference: all count as warm."""
        if len(turns[0]) == 1:
            return cls(tuple(turn[0] for turn in turns), ())
        return cls(tuple(t for turn in turns for t in turn[1:]), tuple(turn[0] for turn in turns))

    @property
    def median(self) -> float:
        return float(np.median(self.warm))

    @property
    def p99(self) -> float:
        return float(np.percentile(self.warm, 99))


@dataclass(frozen=True)
class Run:
    """Times by competitor, and the machine's load over the last minute when the run began and ended."""

    times: Mapping[str, Times]
    rounds: int
    load: tuple[float, float]


def interleave(competitors: Mapping[str, Competitor], rounds: int, burst: int = 1) -> Run:
    """In each round every competitor is called `burst` times in a row, with the number of the call; each round has its
    own order, so that nobody always profits from the same one before. The first call of a turn is `cold`."""
    names, random = list(competitors), np.random.default_rng(0)
    found: dict[str, list[list[float]]] = {name: [] for name in names}
    begin = os.getloadavg()[0]
    gc.collect()
    for k in range(rounds):
        for name in random.permutation(names).tolist():
            found[name].append(_turn(competitors[name], range(k * burst, (k + 1) * burst)))
    times = {name: Times.of(turns) for name, turns in found.items()}
    return Run(times, rounds, (begin, os.getloadavg()[0]))


def _turn(call: Competitor, numbers: range) -> list[float]:
    seconds = []
    for k in numbers:
        start = time.perf_counter_ns()
        call(k)
        seconds.append(1e-9 * (time.perf_counter_ns() - start))
    return seconds
