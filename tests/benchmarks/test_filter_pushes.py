"""A push and a load of the table, which takes some minutes as a whole."""

import pytest

from benchmarks.filter_pushes import CONTROL_PERIOD, KINDS, drive


@pytest.mark.parametrize("kind", KINDS)
def test_what_is_told_at_the_end_is_so(kind):
    run = drive(900, kind)
    assert run.wrong < 0.5
    assert abs(run.deviations) < 4.0
    assert run.unsound >= CONTROL_PERIOD * (kind != "nothing")
