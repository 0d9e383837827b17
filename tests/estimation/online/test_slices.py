"""A row that is worked out in slices, as in fast loops, teaches what it teaches at once: a little later. And what
a learner makes of a load that another one found."""

from itertools import pairwise

import numpy as np

from estimation import FilterNoise
from estimation.health import Health
from estimation.online.arguments import checked_arguments
from estimation.online.cart_filter import core_of
from estimation.online.regressor import parameter_learner

from ..runs import simulate_two_hands
from .test_cart_filter import KNOWN, guess

TRUTH, LOADED = (24.0, 0.28, 0.06, 2.2, 3.0, 1.2, 0.0), (36.0, 0.28, 0.06, 3.0, 3.0, 1.2, 0.0)
NOISE = FilterNoise(0.0005, 0.0005, 0.005, 0.005, 3.0, 0.15, disturbance=0.02)
LATER = 6
"""Samples from the first slice to the last: smoothed, a block, its row, taken in, heard, decided, concluded."""
MOST = LATER + 4 * 11
"""With a trial, which begins over so many rows, each of which up to four beliefs may look at."""


def changes(log):
    """Steps at which other parameters are believed, and the parameters."""
    core, found = core_of(checked_arguments(guess(), None, NOISE, KNOWN, None)), []
    for sample in log.measurements():
        core.take(sample)
        found.append(core.learner.learned.theta)
    return [(k + 1, after) for k, (before, after) in enumerate(pairwise(found)) if after is not before]


def test_slices_teach_the_same_a_little_later(monkeypatch):
    log = simulate_two_hands(TRUTH, duration=16.0, change=(8.0, LOADED))
    at_once = changes(log)
    monkeypatch.setattr(parameter_learner, "MIN_UNSLICED_INTERVAL", 1.0)
    sliced = changes(log)
    assert len(at_once) == len(sliced) > 100
    for (_, theta), (_, same) in zip(at_once, sliced, strict=True):
        np.testing.assert_allclose(same, theta, rtol=1e-9, atol=1e-12)
    later = np.array([then - first for (first, _), (then, _) in zip(at_once, sliced, strict=True)])
    assert np.median(later) == later.min() == LATER
    assert LATER < later.max() <= MOST, "no load was thought of: this test asks less than it means to"


def test_a_load_that_another_found_is_the_one_that_was_thought_of_since():
    """What was thought of before is another one: of the new load nothing is known then."""
    core = core_of(checked_arguments(guess(), None, NOISE, KNOWN, None))
    for sample in simulate_two_hands(TRUTH, duration=16.0, change=(8.0, LOADED)).measurements():
        core.take(sample)
        if core.learner.learned.hypotheses is not None and core.learner.learned.hypotheses.rows > 8:
            break
    begun, loaded = core.learner.learned.hypotheses.time, core.learner.learned.hypotheses.if_loaded.concluded()
    assert begun > 8.0
    same, other = core.copy().learner, core.copy().learner
    same.note_load_change(begun - 1.0)
    other.note_load_change(begun + 1.0)
    np.testing.assert_allclose(same.learned.theta, loaded.theta, rtol=1e-9)
    assert same.learned.covariance[0, 0] < 0.25 * other.learned.covariance[0, 0]
    assert same.learned.hypotheses is other.learned.hypotheses is None


def test_a_push_that_another_found_is_no_load():
    """Nor told as one for longer."""
    core, heavy = core_of(checked_arguments(guess(), None, NOISE, KNOWN, None)), (72.0, *LOADED[1:])
    for sample in simulate_two_hands(TRUTH, duration=16.0, change=(8.0, heavy)).measurements():
        core.take(sample)
        if core.learner.learned.hypotheses is not None and core.learner.health == Health.LOAD_CHANGED:
            break
    assert core.learner.learned.hypotheses is not None
    core.learner.note_push()
    assert core.learner.learned.hypotheses is None
    assert core.learner.health != Health.LOAD_CHANGED
    assert abs(core.learner.learned.theta[0] - TRUTH[0]) < 1.0
