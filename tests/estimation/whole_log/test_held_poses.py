"""Poses that a recorder held between two of a tracker's are no noise of the sensor."""

from dataclasses import replace

import numpy as np
import pytest

from cartgrasp.effects import ViscousDrag
from cartgrasp.inertia import Inertia
from cartgrasp.model import CartModel
from estimation.whole_log.replay import estimated

from ..runs import simulate

TRUTH = (24.0, 0.28, 0.06, 2.2, 3.0, 1.2, 0.0)
GUESS = CartModel(Inertia(20.0, (0.3, 0.0), 1.8), effects=(ViscousDrag(linear=2.0, angular=1.0),))


def test_held_poses_teach_as_much_as_poses_that_are_missing_between():
    """Their steps had been taken for noise of 14 mm, where there was 0.4 mm."""
    log = replace(simulate(TRUTH, 0, 20.0)[0], velocity=None)
    fresh = np.arange(len(log)) // 3 * 3
    missing = np.where((fresh == np.arange(len(log)))[:, None], log.pose, np.nan)
    held, sparse = (estimated(replace(log, pose=pose), GUESS).last for pose in (log.pose[fresh], missing))
    for name in ("mass", "com_x", "com_y", "inertia"):
        assert held.parameters[name].std == pytest.approx(sparse.parameters[name].std, rel=0.02)
        assert held.parameters[name].value == pytest.approx(sparse.parameters[name].value, rel=0.02)
