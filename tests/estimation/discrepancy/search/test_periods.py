"""Scans of periods against sums over the motion, and against least squares at each period."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cartgrasp.effects import LearnedForce
from estimation.discrepancy.search.course import Course
from estimation.discrepancy.search.periods import HARMONICS, OF, Scan

FREQUENCIES = np.arange(0.5, 4.0, 0.02)


@pytest.mark.parametrize(("variable", "lever"), [("time", 0.0), ("way", 0.0), ("way", 0.3), ("x", 0.0)])
def test_power_is_that_of_the_sum_over_the_motion(variable, lever):
    """Against sines and cosines at each frequency, of a motion to and fro whose samples crowd where it turns."""
    random, time = np.random.default_rng(0), np.linspace(0.0, 20.0, 2001)
    way, heading = 3.0 * np.sin(0.7 * time), 0.8 * np.sin(0.3 * time)
    place = np.column_stack([way * np.cos(heading), way * np.sin(heading)])
    course = Course(time, way, np.abs(way), heading, np.gradient(way), np.zeros(2001), place, np.abs(way))
    pull = random.standard_normal((2001, 2))
    acts_on = "world_force" if variable == "x" else "forward_force"
    scan = Scan(variable, LearnedForce(acts_on, OF[variable], lever=lever, period=1.0), "", FREQUENCIES)
    weight = pull[:, 0] - lever * pull[:, 1]
    weight = weight * (np.cos(heading) if variable == "x" else 1.0)
    phase = 2j * np.pi * (getattr(course, variable) - lever * heading)
    power, frequencies = scan.power([course], [pull])
    inside = (frequencies > scan.frequencies[0]) & (frequencies < scan.highest)
    direct = np.abs(np.exp(frequencies[inside, None] * phase) @ weight) ** 2
    assert power[inside] == pytest.approx(direct, abs=0.12 * direct.max())
    assert np.argmax(power[inside]) == np.argmax(direct)


@settings(max_examples=20, deadline=None)
@given(
    harmonics=st.sampled_from(HARMONICS),
    frequency=st.floats(0.6, 3.5),
    seed=st.integers(0, 1000),
)
def test_a_comb_is_highest_where_least_squares_leave_least(harmonics, frequency, seed):
    """A pulse has next to nothing in its first harmonic: the period is told by all of them."""
    random, time = np.random.default_rng(seed), np.linspace(0.0, 20.0, 2001)
    sizes = random.uniform(0.5, 1.0, harmonics) * np.minimum(np.arange(1, harmonics + 1) / harmonics, 1.0)
    phases = random.uniform(0.0, 2 * np.pi, harmonics)
    turns = 2 * np.pi * np.arange(1, harmonics + 1)
    pull = np.cos(np.outer(frequency * time, turns) + phases) @ sizes + 0.3 * random.standard_normal(2001)
    none = np.zeros(2001)
    course = Course(time, time, time, none, none, none, np.zeros((2001, 2)), time)
    scan = Scan("time", LearnedForce("forward_force", "time", period=1.0), "", FREQUENCIES)
    power, frequencies = scan.power([course], [np.column_stack([pull, none])])
    combs = [one for one in scan.combs(power, frequencies) if one[2] == harmonics]

    def left(at):
        columns = np.exp(1j * np.outer(at * time, turns))
        own = np.hstack([columns.real, columns.imag])
        return ((pull - own @ np.linalg.lstsq(own, pull)[0]) ** 2).sum()

    _, found, _ = max(combs)
    near = min((at for _, at, _ in combs), key=lambda at: abs(at - frequency))
    assert near == pytest.approx(frequency, abs=scan.spacing / harmonics)
    assert left(found) <= 1.3 * min(left(at) for _, at, _ in sorted(combs, reverse=True)[:40])
