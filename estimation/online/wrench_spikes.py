"""Single wrenches that are far from those before and after: no push, but a sensor that slipped.

A sample that leaps is held back until the next ones say what it was. Where they are as before, it was a spike and is
left out, as `log_noise/glitches.py` does with whole logs. Where they stay, or leap on, it was a push, which is brought
in late (`late_samples.py`): then nothing is lost but the time of a sample.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from cartgrasp.errors import printable
from cartgrasp.motion import Measurement

from ..log_noise.glitches import FAR
from ..noise import FilterNoise
from ..sensor_check.suspicion import Suspicion
from .kernels.felt_wrench import HELD

LASTS = 3
"""Samples that leap in a row and are a spike at most, as in whole logs."""
SMOOTHING = 0.02
"""Share of a new step in the usual one."""
FADING = 0.999
"""Of the largest wrench of late, at each sample: a controller may push as hard again, for one sample."""
REST = 0.0, 0.0, 0.0
NONE: list[Measurement] = []
TOLD = 10.0
"""s for which a spike is told."""
EXACT = 1e-9
"""N and N·m: noise of sensors that are said to have none."""
Pushes = dict[str, tuple[float, float, float]]
"""fx, fy and tz, which push a planar cart, by arm."""


class WrenchSpikes:
    """Looks at samples in the order in which they come; those that are late stay as they are."""

    def __init__(self, noise: FilterNoise) -> None:
        self._per_force, self._per_moment = 1.0 / max(noise.force, EXACT), 1.0 / max(noise.moment, EXACT)
        self._last: Pushes = {}
        self._usual: dict[str, float] = {}  # step, in deviations of the noise
        self._largest: dict[str, float] = {}  # wrench of late, likewise
        self._held: list[tuple[Measurement, Pushes]] = []
        self._time = -math.inf
        self._told: dict[str, tuple[float, float]] = {}  # when, and how far it leapt, by arm

    def sift(self, measurement: Measurement) -> tuple[list[Measurement], Measurement]:
        """Wrenches that were held back and are pushes after all; and the measurement, without its own where they
        leap."""
        if not measurement.wrenches or not measurement.time > self._time:
            return [], measurement
        since, self._time = measurement.time - self._time, measurement.time
        new, steps, leaps, held = Pushes(), dict[str, float](), False, self._held
        for arm, wrench in measurement.wrenches.items():
            push = new[arm] = _pushing(wrench)
            old = self._last.get(arm)
            if old is not None:
                step = steps[arm] = self._step(old, push)
                leaps = leaps or (step > FAR and self._is_far(arm, step))
        if not (leaps or held):
            self._go_on(new, steps)
            return NONE, measurement
        goes_on = held and (self._stays(held[-1][1], new) or (leaps and len(held) >= LASTS))
        is_push = bool(goes_on) or since > HELD
        if leaps and not is_push:
            held.append((replace(measurement, pose=None, velocity=None), new))
            return [], replace(measurement, wrenches={})
        if held:
            self._held = []
            if not is_push:
                self._note(held)
        self._go_on(new, steps)
        return [one for one, _ in held] if is_push else NONE, measurement

    @property
    def suspicions(self) -> Iterator[Suspicion]:
        """Of the last moments."""
        for arm, (time, size) in self._told.items():
            if self._time - time < TOLD:
                words = f"{printable(arm)}: its wrench leapt by {size:.3g} N at t = {time:g} s and back: left out"
                yield Suspicion("jumps", arm, 0.99, size, words, put_right=True)

    def _go_on(self, new: Pushes, steps: dict[str, float]) -> None:
        """From arms' new wrenches, so far from the last ones."""
        for arm, push in new.items():
            size = self._step(REST, push)
            if math.isfinite(push[0] + push[1] + push[2]):
                usual = self._usual.get(arm, 0.0)
                self._usual[arm] = usual + SMOOTHING * (steps.get(arm, 0.0) - usual)
                self._largest[arm] = max(FADING * self._largest.get(arm, 0.0), size)
                self._last[arm] = push

    def _is_far(self, arm: str, step: float) -> bool:
        return step > max(FAR * self._usual.get(arm, 0.0), FAR, self._largest.get(arm, 0.0))

    def _step(self, old: tuple[float, float, float], new: tuple[float, float, float]) -> float:
        """The larger of force and moment, in deviations of the noise."""
        x, y = abs(new[0] - old[0]), abs(new[1] - old[1])
        force, moment = (x if x > y else y) * self._per_force, abs(new[2] - old[2]) * self._per_moment
        return force if force > moment else moment

    def _leaping(self, old: Pushes, new: Pushes) -> list[str]:
        """The arms whose wrenches are far from others."""
        return [arm for arm in new if arm in old and self._is_far(arm, self._step(old[arm], new[arm]))]

    def _stays(self, held: Pushes, new: Pushes) -> bool:
        """Whether arms that leapt are about where they leapt to, and nearer to it than to where they were."""
        leapt = [arm for arm in self._leaping(self._last, held) if arm in new]
        there = all(self._step(held[arm], new[arm]) < self._step(self._last[arm], new[arm]) for arm in leapt)
        return there and not self._leaping(held, new)

    def _note(self, held: list[tuple[Measurement, Pushes]]) -> None:
        for one, new in held:
            for arm in self._leaping(self._last, new):
                size = max(abs(after - before) for after, before in zip(new[arm], self._last[arm], strict=True))
                self._told[arm] = one.time, size


def _pushing(wrench: ArrayLike) -> tuple[float, float, float]:
    fx, fy, _, _, _, tz = np.asarray(wrench, dtype=float).tolist()
    return fx, fy, tz
