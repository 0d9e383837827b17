"""What a run of the closed loop is, and what is none."""

from __future__ import annotations

import numpy as np
import pytest

import cartgrasp as cg
from cartgrasp.simulation import Loop, ModelPlant, SensorNoise, Sensors, run
from planning import Controller, PathReference, chain, straight

CART = cg.CartModel(cg.Inertia(24.0, (0.3, 0.0), 2.0))


def loop():
    controller = Controller(CART, [cg.Arm("hand", [(-0.25, 0.0, 1.0)])], PathReference(chain(straight(1.0, 0.5))))
    return Loop(controller, ModelPlant(CART), Sensors(CART, SensorNoise()))


def test_a_run_has_a_row_for_each_period():
    assert run(loop(), 0.05).time == pytest.approx([0.0, 0.01, 0.02, 0.03, 0.04])


@pytest.mark.parametrize("duration", [0.0, 0.004, -1.0, np.nan, np.inf, "long"])
def test_durations_without_a_period_are_refused(duration):
    with pytest.raises(cg.UsageError, match="run: duration"):
        run(loop(), duration)
