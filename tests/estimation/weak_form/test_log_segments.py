"""A log is cut where the cart was hit, and where nobody saw it for long."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cartgrasp.errors import DataError
from estimation.discrepancy import diagnose
from estimation.impacts.impacts import Impact
from estimation.weak_form.log_segments import (
    IMPACT_MARGIN,
    MIN_SEGMENT_DURATION,
    MIN_STOP_DISTANCE,
    segments,
    split_at_gaps,
)

from ..weak_form.motions import TRUE, cart_of, noisy, weaving

CART, LOG = cart_of(TRUE), weaving(TRUE, 12.0)


def hit(time, x=0.0, before=0.5, after=-0.3):
    return Impact(time, np.array([x, 0.0, 0.0]), before, after)


@pytest.mark.long
@settings(max_examples=15, deadline=None)
@given(times=st.lists(st.floats(0.0, 12.0), min_size=1, max_size=2))
def test_parts_lie_between_impacts(times):
    """No part holds a touch; what lies between and is long enough is there, every row of it."""
    parts = segments(LOG, CART, [hit(t) for t in times])
    ends = np.sort([0.0, *times, 12.0])
    long_ones = [(a, b) for a, b in pairwise(ends) if b - a > MIN_SEGMENT_DURATION + 2 * IMPACT_MARGIN + 0.03]
    assert len(parts) >= len(long_ones)
    for part in parts:
        time = part.log.time
        assert time[-1] - time[0] > MIN_SEGMENT_DURATION
        assert all(np.abs(time - t).min() > IMPACT_MARGIN for t in times)
        assert np.diff(time).max() < 0.011
    kept = np.concatenate([part.log.time for part in parts])
    for a, b in long_ones:
        inside = LOG.time[(LOG.time > a + IMPACT_MARGIN + 1e-9) & (LOG.time < b - IMPACT_MARGIN - 1e-9)]
        assert np.isin(inside, kept).all()


def test_rows_keep_their_wrenches():
    early, late = segments(LOG, CART, [hit(5.0)])
    own = LOG.time < 5.0 - IMPACT_MARGIN
    assert early.log.arms["arm"].wrench == pytest.approx(LOG.arms["arm"].wrench[own])
    assert early.log.pose == pytest.approx(LOG.pose[own])
    assert late.log.velocity == pytest.approx(LOG.velocity[LOG.time > 5.0 + IMPACT_MARGIN + 1e-9])
    assert early.log.name == LOG.name


def test_near_a_stop_nothing_is_believed():
    """Hit three times at one place, a cart may lean there unseen: only what is away from it is kept."""
    place = float(LOG.pose[900, 0])
    parts = segments(LOG, CART, [hit(t, place) for t in (0.05, 0.1, 0.15)])
    kept = np.concatenate([part.log.pose[:, 0] for part in parts])
    assert np.abs(kept - place).min() >= MIN_STOP_DISTANCE
    assert len(parts) == 2


def test_a_log_that_is_hit_all_the_time_is_refused():
    with pytest.raises(DataError, match="weaving: it is hit so often"):
        segments(LOG, CART, [hit(t) for t in np.arange(0.0, 12.1, 0.8)])


@given(hole=st.floats(0.5, 100.0), at=st.integers(100, 1100), missing=st.integers(0, 80))
def test_no_part_has_a_hole(hole, at, missing):
    """A clock that jumps, behind poses that are missing: every row is in one part."""
    pose = LOG.pose.copy()
    pose[at - missing : at] = np.nan
    paused = replace(LOG, time=LOG.time + hole * (np.arange(len(LOG)) >= at), pose=pose)
    parts = split_at_gaps(paused, 1.0)
    assert len(parts) == 1 + (hole + 0.01 * (missing + 1) > 1.0)
    np.testing.assert_array_equal(np.concatenate([part.time for part in parts]), paused.time)


@pytest.mark.long
def test_a_pause_of_an_hour_makes_two_logs():
    """Its parts tell what they tell as two logs, and nothing is simulated in between."""
    first, last = LOG.time < 6.0, LOG.time >= 6.0
    log = noisy(LOG, 0)
    paused = replace(log, time=log.time + 3600.0 * last)
    found = diagnose(paused, CART)
    assert [check.rows for check in found.checks] == [first.sum(), last.sum()]
    assert [check.name for check in found.checks] == [f"{LOG.name}, part 1", f"{LOG.name}, part 2"]
    assert found.verdict == "no_discrepancy"
    assert found.certainty.cart.inertia.mass == pytest.approx(CART.inertia.mass, rel=0.01)
