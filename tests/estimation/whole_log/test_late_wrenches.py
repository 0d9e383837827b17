"""Wrenches that come late, by filters, drivers and clocks that nobody told."""

from dataclasses import replace

import numpy as np
import pytest

from cartgrasp.effects import ViscousDrag
from cartgrasp.logs import ArmLog
from estimation.whole_log.identification import identify

from ..sensor_check.logs import cart_of, two_hands


@pytest.mark.some(1)
@pytest.mark.parametrize("lag", [-0.06, 0.02, 0.05])
def test_late_wrenches_are_no_drag(lag):
    """Wrenches that come late by as much as filters and clocks make them. Before, of 50 ms, drags were told that were
    5 to 8 deviations off, with as many words as of a sound log."""
    log = two_hands(3)
    late = {
        name: ArmLog(arm.contact, np.column_stack([np.interp(log.time - lag, log.time, c) for c in arm.wrench.T]))
        for name, arm in log.arms.items()
    }
    cart = replace(cart_of(0.8), effects=(ViscousDrag(2.0, 1.0),))
    found = identify([replace(log, arms=late)], cart)
    for name, true in (("mass", 24.0), ("viscous_drag.linear", 3.0), ("viscous_drag.angular", 1.2)):
        assert abs(found.parameters[name].value - true) < 3.0 * found.parameters[name].std
    assert found.parameters["viscous_drag.linear"].identifiable
    (words,) = found.logs[0].words
    assert ("after" if lag > 0 else "before") in words
    assert f"{abs(lag):.2f}"[:-1] in words


def test_of_wrenches_in_time_no_lateness_is_told():
    cart = replace(cart_of(0.8), effects=(ViscousDrag(2.0, 1.0),))
    assert identify([two_hands(3)], cart).logs[0].words == ()
