"""The online filter among faults, on two logs; the whole table takes some minutes."""

import math
from functools import cache

import pytest

from benchmarks.filter_faults import FAULTS, IN_TIME, MASS, NEES, drawn, noise, reversals, told

UNTOLD = ("lbf", "contacts", "one wrench")
"""Which a wide guess explains as well, or nobody tells."""


@cache
def sound(seed):
    return told(drawn(seed), None)


@pytest.mark.some(1)
@pytest.mark.parametrize("seed", [2000, 2001])
def test_sound_logs_are_not_suspected(seed):
    assert not sound(seed).others


@pytest.mark.some(3)
@pytest.mark.parametrize("seed", [2000, 2001])
@pytest.mark.parametrize("name", [name for name in FAULTS if not name.startswith(UNTOLD)])
def test_faults_are_told(name, seed):
    fault = FAULTS[name]
    found = told(drawn(seed), fault)
    if name.startswith("the "):  # in time in eleven of twelve runs
        assert math.isfinite(found.after)
        return
    assert not found.others
    if not fault.kinds:
        assert abs(found.off - sound(seed).off) < 1e-12
        return
    assert found.after <= IN_TIME
    assert not found.is_sure


def test_degrees_that_look_like_another_heading_are_told_by_where_they_begin():
    """Of a straight path; its radians, three turns up, are nobody's degrees."""
    run = drawn(7302)
    assert told(run, FAULTS["theta in degrees"]).after <= IN_TIME
    assert not told(run, FAULTS["theta begins three turns up"]).others


def test_loud_velocities_leave_the_filter_consistent():
    """A table's line for the size of the noise, and one for all: here of one log."""
    *_, whole = noise([2002])
    runs, nees, off = (cell.strip() for cell in whole.split("|")[2:5])
    assert runs == "1"
    assert float(nees) < NEES
    assert abs(float(off.removesuffix(" %"))) < 100 * MASS


@pytest.mark.prove
def test_straight_reversals_are_a_line_for_each_run():
    """Its shares are those of all ticks, and the mass at the end is about right, whatever casters do."""
    *_, row = reversals([3])
    _, seed, *shares, _, mass, _ = (cell.strip() for cell in row.split("|"))
    assert seed == "3"
    assert abs(sum(float(share.removesuffix(" %")) for share in shares) - 100.0) <= 2.0
    assert abs(float(mass.split()[0]) - 29.7) < 1.5
