"""Trackers that fall silent for good, while something pushes."""

from __future__ import annotations

import numpy as np
import pytest

from cartgrasp.arms import Arm
from cartgrasp.contacts import ContactWrenches
from cartgrasp.effects import RollingResistance, ViscousDrag
from cartgrasp.inertia import Inertia
from cartgrasp.model import CartModel
from estimation import DisturbedFilter, FilterNoise
from planning import Controller, PathReference, chain, pause
from planning.references import speed_change, turn

from .driving import ticks

TRUTH = CartModel(Inertia(24.0, (0.3, 0.05), 2.2), effects=(ViscousDrag(3.0, 1.2), RollingResistance(0.01)))
GUESS = TRUTH.with_inertia(Inertia(20.0, (0.25, 0.0), 2.0))
HOLDS = {"left": (-0.25, 0.2, 1.0), "right": (-0.25, -0.2, 1.0)}
PATH = PathReference(chain(speed_change(0.6), turn(0.8, 0.3), pause(6.0), speed_change(-0.6)))
SILENT, RAMP = 2.0, 2.5
"""s, from which on nothing is seen of the motion; and until a cart whose pose is lost was to rest, 0.5 s after that."""


def beside(push, begin, end):
    """What a force (N) at the front adds to what the arms give, which they don't feel."""

    def spoiled(felt, given):
        if not begin <= felt.time < end:
            return felt, given
        wrenches, contacts = {"it": np.array([push, 0, 0, 0, 0, 0])}, {"it": np.array([0.3, 0.05, 1.0])}
        return felt, ContactWrenches({**given.wrenches, **wrenches}, {**given.contacts, **contacts}, given.yaws)

    return spoiled


@pytest.mark.some(2)
@pytest.mark.parametrize(("push", "seed"), [(30.0, 21), (-30.0, 22), (60.0, 23)])
def test_nobody_pushes_against_what_has_ended_unseen(push, seed):
    """With that in its prediction a cart was driven at 1 m/s, and turned with 4 rad/s, by 30 N without end."""
    hands = [Arm(name, [at], force_limit=(60.0,) * 3, moment_limit=(8.0,) * 3) for name, at in HOLDS.items()]
    learner = DisturbedFilter(GUESS, list(HOLDS), noise=FilterNoise(force=1.0, moment=0.05))
    controller = Controller(GUESS, hands, PATH, estimator=learner, regrasp=None)
    spoiled = beside(push, SILENT - 0.5, SILENT + 0.1)
    driven = list(ticks(controller, TRUTH, 7.0, seed=seed, blind=lambda time: time >= SILENT, spoiled=spoiled))
    pushed, silent = driven[round(100 * SILENT) - 5].step, driven[-1].step
    assert pushed.disturbance.wrench[0] == pytest.approx(push, abs=8.0)
    assert silent.health == "stale"
    assert not silent.disturbance.acts
    assert not silent.disturbance.wrench.any()
    assert silent.disturbance.std[0] > 30.0
    forces = [tick.step.given.wrench_b[0] for tick in driven[round(100 * (SILENT + 0.5 + RAMP)) :]]
    assert np.abs(forces).max() < 5.0
    assert abs(driven[-1].motion.velocity[0]) < 0.3  # by what was given until it was forgotten, less friction
    assert abs(driven[-1].motion.velocity[1]) < 0.5
