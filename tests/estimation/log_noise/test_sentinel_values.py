"""Numbers that stand for no reading are told and left out, and no others."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cartgrasp.errors import UsageError
from cartgrasp.logs import ArmLog
from cartgrasp.motion import Measurement
from estimation import CartFilter, identify
from estimation.log_noise.sentinel_values import sentinels, without_sentinels
from estimation.sensor_check import look_at
from estimation.whole_log.replay import replay

from ..sensor_check.logs import CART, PLANT, two_hands

MARKS = st.sampled_from([99.0, 999.0, 9999.0, 99999.0, 32767.0, 32768.0, 65535.0, 2147483648.0])
ROWS = st.sets(st.integers(0, 3999), min_size=1, max_size=1200)


@given(MARKS, ROWS, st.sampled_from([-1.0, 1.0]), st.integers(-3, 3), st.floats(0.0, 3.0), st.integers(0, 2**32 - 1))
def test_marks_are_found_whatever_their_number_and_unit(mark, rows, sign, power, offset, seed):
    unit = 10.0**power
    column = unit * (offset + np.random.default_rng(seed).uniform(-1.0, 1.0, 4000))
    column[list(rows)] = sign * mark * unit
    assert set(np.flatnonzero(sentinels(column)).tolist()) == rows


@given(st.floats(-1e4, 1e4), ROWS, st.integers(0, 2**32 - 1))
def test_what_a_hand_or_a_tracker_does_is_no_mark(size, rows, seed):
    """A push as hard as any, for any number of rows, with a sensor's noise."""
    random = np.random.default_rng(seed)
    column = random.standard_normal(4000)
    column[list(rows)] += size
    assert not sentinels(column).any()


@given(st.floats(-2e4, 2e4), st.floats(0.1, 1.0))
def test_a_range_that_holds_a_mark_is_no_mark(middle, share):
    """-999 among other numbers of its size is a number."""
    column = np.linspace(middle - share * abs(middle) - 1.0, middle + share * abs(middle) + 1.0, 300)
    column[150] = np.clip(-999.0, column[0], column[-1])
    assert not sentinels(column).any()


@pytest.mark.parametrize(
    ("others", "mark", "is_told"), [(-0.5, -0.99, False), (-0.5, -9999.0, True), (0.0, 999.0, True)]
)
def test_two_places_of_a_hand_are_no_mark(others, mark, is_told):
    """A hand that went from 0.5 to 0.99 m behind the origin: all rows in which it was there had been left out."""
    column = np.where(np.arange(4000) < 2500, others, mark)
    assert bool(sentinels(column).any()) == is_told


def marked_log(share=0.05, mark=-9999.0, seed=0, duration=40.0):
    log = two_hands(seed, duration=duration)
    random = np.random.default_rng(seed)
    wrench, pose = log.arms["left"].wrench.copy(), log.pose.copy()
    wrench[random.random(len(log)) < share, 0] = mark
    pose[random.random(len(log)) < share] = mark
    return replace(log, pose=pose, arms=log.arms | {"left": ArmLog(log.arms["left"].contact, wrench)})


@pytest.mark.parametrize("share", [0.001, 0.05, 0.3])
def test_marks_are_told_by_column_and_count(share):
    told = [one for one in look_at(marked_log(share), CART).suspicions if one.kind == "jumps"]
    assert [one.where for one in told] == ["x", "y", "theta", "left.fx"]
    assert all("-9999" in one.words and "blank" in one.words and one.put_right for one in told)


def test_fits_and_filters_take_them_for_missing():
    marked_one = marked_log(duration=15.0)
    blank = without_sentinels(marked_one)
    assert np.isnan(blank.pose).any(axis=1).sum() == (marked_one.pose == -9999.0).all(axis=1).sum()
    mass = [identify([log], CART).parameters["mass"].value for log in (marked_one, blank)]
    assert mass[0] == mass[1] == pytest.approx(PLANT[0], rel=0.05)
    told = [replay(log, CartFilter(CART)).last.parameters["mass"] for log in (marked_one, blank)]
    assert told[0] == told[1]


@pytest.mark.parametrize("contact", [(100.0, 0.2, 1.0), (-0.5, 300.0, 1.0)])
def test_a_contact_in_millimetres_is_refused(contact):
    sample = Measurement(0.0, np.zeros(3), np.zeros(3), {"left": np.zeros(6)}, {"left": contact})
    with pytest.raises(UsageError, match=r"measurement: contacts: left: .* m from \{b\}; give m"):
        CartFilter(CART, ["left"]).update(sample)
