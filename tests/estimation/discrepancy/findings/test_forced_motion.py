"""The motion as forces make it: nearer to the truth than a smooth one, whatever point of the cart is tracked."""

from dataclasses import replace

import numpy as np
import pytest

from cartgrasp.effects import PoseOffset
from cartgrasp.frames import rotation_planar
from estimation.discrepancy.findings.forced_motion import ForcedMotion
from estimation.weak_form.balances import Balances

from ..search.test_laws import CART, TRUTH, simulate

OFFSET = np.array([0.3, -0.2, 0.4])
"""Where {b} is in the frame that is tracked."""


def recorded(seed):
    return simulate(TRUTH, seed, 30.0, noise=(0.0005, 0.005, 1.0))


def tracked(log):
    """The log of another frame of the same body, by rigid-body kinematics."""
    heading = log.pose[:, 2] - OFFSET[2]
    arm = np.array([rotation_planar(h) @ OFFSET[:2] for h in heading])
    pose = np.column_stack([log.pose[:, :2] - arm, heading])
    turn = log.velocity[:, 2:]
    velocity = np.column_stack([log.velocity[:, :2] - turn * np.column_stack([-arm[:, 1], arm[:, 0]]), turn])
    return replace(log, pose=pose, velocity=velocity)


@pytest.mark.parametrize("seed", [4, 6, 8])
def test_a_right_model_is_nearer_to_the_truth_than_what_is_smooth(seed):
    """Forces there jump by up to 40 N."""
    log, truth = recorded(seed)
    balances = Balances.of(log, CART)
    driven, motion = ForcedMotion.of(balances, CART), balances.motion
    true = np.column_stack([np.interp(motion.time, log.time, axis) for axis in truth.T])
    off = [np.sqrt(((one - true[:, 3:]) ** 2).mean(axis=0)) for one in (driven.velocity, motion.velocity)]
    assert (off[0] < 0.85 * off[1]).all()
    assert np.abs(driven.pose - true[:, :3]).max() < 1e-3


def test_wrenches_that_are_lost_bend_nothing_beside():
    """Five times for 0.1 s."""
    log, truth = recorded(4)
    lost = np.abs((log.time % 5.0) - 2.0) < 0.05
    arms = {name: replace(arm, wrench=np.where(lost[:, None], np.nan, arm.wrench)) for name, arm in log.arms.items()}
    balances = Balances.of(replace(log, arms=arms), CART)
    driven, motion = ForcedMotion.of(balances, CART), balances.motion
    true = np.column_stack([np.interp(motion.time, log.time, axis) for axis in truth[:, 3:].T])
    near = balances.wrenches.seen & (np.abs((motion.time % 5.0) - 2.0) < 0.5)
    off = [np.sqrt(((one - true)[near] ** 2).mean(axis=0)) for one in (driven.velocity, motion.velocity)]
    assert (off[0] < off[1]).all()


def test_it_does_not_matter_which_point_is_tracked():
    log, _ = recorded(4)
    cart = CART.with_effect(PoseOffset(*OFFSET))
    here = ForcedMotion.of(Balances.of(log, CART), CART)
    there = ForcedMotion.of(Balances.of(tracked(log), cart), cart)
    assert there.wrench == pytest.approx(here.wrench, abs=1e-9)
    assert there.pose == pytest.approx(here.pose, abs=5e-4)
    assert np.sqrt(((there.velocity - here.velocity) ** 2).mean()) < 1e-3
