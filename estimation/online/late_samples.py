"""Samples that come late or out of order are taken in where they belong: the estimator goes back and on again.

Sensors that are late are so sample after sample. So the state right after the last late one is kept: the next goes back
no farther.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Generic, Protocol, Self, TypeVar

from cartgrasp.frames import Array
from cartgrasp.motion import Measurement

from .regressor.wrench_noise_scale import WrenchNoiseScale

MAX_SAMPLE_DELAY = 0.3
"""s: how late a sample may be."""
TIME_TOLERANCE = 1e-9
"""s, of stamps that were meant to be the same."""
CHECKPOINT_INTERVAL = 0.1
"""s between states that are kept; one is kept with the next sample that takes no longer than most."""
CLOCK_RESET_TIMEOUT = 0.5
"""s: for how long nothing but refused samples come, one after the other, when the clock was set back."""


class SampleFilter(Protocol):
    """What goes on from sample to sample, can be kept as it is, and is told how noisy velocities are."""

    @property
    def time(self) -> float: ...

    def take(self, measurement: Measurement) -> None: ...

    def copy(self) -> Self: ...

    @property
    def took_long(self) -> bool:
        """Whether the last sample took longer than most."""
        ...

    @property
    def wrench_noise_scale(self) -> WrenchNoiseScale:
        """The noise scale of wrenches."""
        ...

    def scale_noise(self, noise_factors: Array) -> None:
        """Variances of velocities, linear and yaw (2,), are so many times the declared ones."""
        ...


T = TypeVar("T", bound=SampleFilter)


@dataclass(frozen=True)
class Checkpoint(Generic[T]):
    """A state, and how many samples it had seen."""

    state: T
    n_samples: int


class LateSamples(Generic[T]):
    """Brings samples in order to `state`."""

    def __init__(self, state: T) -> None:
        self.state = state
        self._kept: list[Checkpoint[T]] = []
        self._after_late: Checkpoint[T] | None = None
        self._due = -math.inf  # when the next state is kept
        self._samples: list[Measurement] = []
        self._forgotten = 0
        self._refused: tuple[float, float] | None = None  # first and last in a row
        self.clock_offset = 0.0  # s, added to stamps: a clock that was set back goes on from where it was

    def on_steady_clock(self, measurement: Measurement) -> Measurement:
        """The sample with the time of a clock that is never set back; `take` is to be given such."""
        if not self.clock_offset:
            return measurement
        return replace(measurement, time=measurement.time + self.clock_offset)

    def take(self, measurement: Measurement) -> bool:
        """Whether the sample could be taken in: not where it comes later than by `MAX_SAMPLE_DELAY`, or is of before
        all that is kept. Where nothing but such come, the clock was set back."""
        if self._take(measurement):
            self._refused = None
            return True
        first, last = self._refused or (measurement.time, measurement.time)
        self._refused = (first if last <= measurement.time else measurement.time), measurement.time
        if measurement.time - self._refused[0] < CLOCK_RESET_TIMEOUT:
            return False
        gap = self.state.time + CLOCK_RESET_TIMEOUT - measurement.time
        self.clock_offset += gap
        return self._take(replace(measurement, time=measurement.time + gap))

    def scale_noise(self, noise_factors: Array) -> None:
        """Says to the state, and to those that it may go back to, how noisy velocities are."""
        kept = [*self._kept, *([] if self._after_late is None else [self._after_late])]
        for state in (self.state, *(one.state for one in kept)):
            state.scale_noise(noise_factors)

    def _take(self, measurement: Measurement) -> bool:
        if measurement.time >= self.state.time - TIME_TOLERANCE:
            self._go_on(measurement)
            return True
        oldest = self.state.time - MAX_SAMPLE_DELAY
        if not self._kept or measurement.time < max(oldest - TIME_TOLERANCE, self._kept[0].state.time):
            return False
        while self._kept[-1].state.time > measurement.time:
            self._kept.pop()
        first = self._go_back(measurement.time) - self._forgotten
        again, self._samples = self._samples[first:], self._samples[:first]
        late = sum(sample.time <= measurement.time for sample in again)
        for sample in (*again[:late], measurement):
            self._go_on(sample)
        self._after_late = Checkpoint(self.state.copy(), self._forgotten + len(self._samples))
        for sample in again[late:]:
            self._go_on(sample)
        return True

    def _go_back(self, time: float) -> int:
        """To the last state that is kept of before a time; returns how many samples it had seen."""
        last, late = self._kept[-1], self._after_late
        self._due, self._after_late = last.state.time + CHECKPOINT_INTERVAL, None
        if late is not None and late.n_samples > last.n_samples and late.state.time <= time:
            self.state = late.state
            return late.n_samples
        self.state = last.state.copy()
        return last.n_samples

    def _go_on(self, measurement: Measurement) -> None:
        self.state.take(measurement)
        self._samples.append(measurement)
        if self.state.time >= self._due and not self.state.took_long:
            self._keep()

    def _keep(self) -> None:
        self._kept.append(Checkpoint(self.state.copy(), self._forgotten + len(self._samples)))
        self._due = self.state.time + CHECKPOINT_INTERVAL
        while len(self._kept) > 1 and self._kept[1].state.time <= self.state.time - MAX_SAMPLE_DELAY:
            self._kept.pop(0)
        passed, late = self._kept[0].n_samples - self._forgotten, self._after_late
        if late is not None and late.n_samples < self._kept[0].n_samples:
            self._after_late = None
        self._samples, self._forgotten = self._samples[passed:], self._forgotten + passed
