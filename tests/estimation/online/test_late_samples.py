"""Late samples give what samples in order give, and one that is late as its fellows are costs little more."""

from __future__ import annotations

from dataclasses import dataclass, field

import pytest
from hypothesis import given
from hypothesis import strategies as st

import cartgrasp as cg
from estimation.online.late_samples import CHECKPOINT_INTERVAL, MAX_SAMPLE_DELAY, LateSamples


@dataclass
class Diary:
    """A filter that writes down what it takes."""

    taken: tuple[float, ...] = ()
    time: float = -1.0
    work: list[int] = field(default_factory=lambda: [0])  # shared by copies
    took_long: bool = False

    def take(self, measurement):
        assert measurement.time >= self.time - 1e-9
        self.taken, self.time = (*self.taken, measurement.time), measurement.time
        self.work[0] += 1

    def copy(self):
        return Diary(self.taken, self.time, self.work)

    def scale_noise(self, noise_factors):
        pass


@given(
    st.lists(st.floats(0.0, MAX_SAMPLE_DELAY - CHECKPOINT_INTERVAL - 0.01), min_size=1, max_size=120),
    st.sampled_from([0.002, 0.01, 0.03]),
)
def test_any_order_comes_to_the_same(lateness, period):
    samples = LateSamples(Diary())
    stamps = [period * k for k in range(len(lateness))]
    arriving = sorted(zip((t + late for t, late in zip(stamps, lateness, strict=True)), stamps, strict=True))
    taken = [stamp for _, stamp in arriving if samples.take(cg.Measurement(stamp))]
    # Before the first state is kept nothing can be gone back to.
    first = arriving[0][1]
    assert list(samples.state.taken) == sorted(taken)
    assert all(stamp >= first for stamp in taken)
    assert len(taken) == sum(stamp >= first for stamp in stamps)


def test_no_state_is_kept_with_a_sample_that_takes_long():
    """What is kept then makes the longest ticks longer still; the next sample is as good."""
    samples = LateSamples(Diary(took_long=True))
    samples.take(cg.Measurement(0.0))
    samples.take(cg.Measurement(0.02))
    assert not samples.take(cg.Measurement(0.01))
    samples.state.took_long = False
    samples.take(cg.Measurement(0.03))
    samples.take(cg.Measurement(0.05))
    assert samples.take(cg.Measurement(0.04))
    assert samples.state.taken == (0.0, 0.02, 0.03, 0.04, 0.05)


@pytest.mark.parametrize("late", [1, 5, 20])
def test_what_is_always_late_goes_back_no_farther_than_it_must(late):
    """A wrench and a pose every 2 ms, of which wrenches are late by so many."""
    samples, n = LateSamples(Diary()), 1000
    for k in range(n):
        samples.take(cg.Measurement(0.002 * k))
        if k >= late:
            samples.take(cg.Measurement(0.002 * (k - late) + 1e-4))
    assert list(samples.state.taken) == sorted(samples.state.taken)
    assert len(samples.state.taken) == 2 * n - late
    assert samples.state.work[0] < (2 + late + 2) * n  # 50 and more a sample before
