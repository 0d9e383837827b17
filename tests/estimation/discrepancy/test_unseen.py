"""Stretches in which nobody saw the cart are no motion, and absurd samples no cart's."""

from dataclasses import replace

import numpy as np
import pytest

from cartgrasp.effects import ViscousDrag
from cartgrasp.errors import DataError
from cartgrasp.inertia import Inertia
from cartgrasp.logs import ArmLog
from cartgrasp.model import CartModel
from estimation.discrepancy import diagnose

from ..runs import simulate

TRUTH = (24.0, 0.28, 0.06, 2.2, 3.0, 1.2, 0.0)
LOG, _ = simulate(TRUTH, 3, 20.0, noise=(0.0004, 0.004, 1.0))
CART = CartModel(Inertia(24.0, (0.28, 0.06), 2.2), effects=(ViscousDrag(linear=3.0, angular=1.2),))


@pytest.fixture(scope="module")
def whole():
    return diagnose(LOG, CART)


def unseen(log, *stretches):
    """Without poses and velocities in rows from one to another."""
    rows = np.arange(len(log))
    gone = np.any([(rows >= a) & (rows < b) for a, b in stretches], axis=0)[:, None]
    return replace(log, pose=np.where(gone, np.nan, log.pose), velocity=np.where(gone, np.nan, log.velocity))


@pytest.mark.long
@pytest.mark.some(1)
@pytest.mark.parametrize("stretches", [[(600, 1000)], [(0, 300), (1700, 2000)], [(200, 300), (500, 620), (900, 1000)]])
def test_nothing_is_named_for_what_nobody_saw(whole, stretches):
    found = diagnose(unseen(LOG, *stretches), CART)
    assert not found.effects
    assert found.gap.refitted < 2 * found.gap.noise_floor
    assert found.checks[0].rows == len(LOG)
    lost = sum(b - a for a, b in stretches)
    assert found.checks[0].distance < whole.checks[0].distance * (1.1 - lost / len(LOG))


@pytest.mark.long
def test_velocity_alone_is_motion(whole):
    """Without poses for 5 s, twice."""
    blind = replace(LOG, pose=np.where(np.arange(len(LOG))[:, None] // 500 % 2 == 1, np.nan, LOG.pose))
    found = diagnose(blind, CART)
    assert not found.effects
    assert found.checks[0].distance == pytest.approx(whole.checks[0].distance, rel=0.05)


@pytest.mark.parametrize(
    ("spoil", "said"),
    [
        (lambda arm: ArmLog(arm.contact * np.nan, arm.wrench), "contact point of arm hand is whole in 0 rows"),
        (lambda arm: ArmLog(arm.contact, np.where(np.arange(2000)[:, None] < 120, arm.wrench, np.nan)), "1.2 s"),
    ],
)
def test_a_log_without_wrenches_or_contacts_is_refused_by_its_name(spoil, said):
    """Beside a good one, too."""
    bad = replace(LOG, arms={"hand": spoil(LOG.arms["hand"])}, name="bad.csv")
    with pytest.raises(DataError, match=f"bad.csv.*{said}"):
        diagnose([LOG, bad], CART)


def test_wrenches_that_never_come_with_poses_are_refused():
    """Each has enough, and no row has both."""
    hand = LOG.arms["hand"]
    rows = np.arange(len(LOG))[:, None] < 1000
    late = replace(unseen(LOG, (0, 1000)), arms={"hand": ArmLog(hand.contact, np.where(rows, hand.wrench, np.nan))})
    with pytest.raises(DataError, match=r"poses and wrenches come together for 0\.0 s"):
        diagnose(late, CART)


def test_equations_without_a_solution_are_no_traceback(monkeypatch):
    def singular(*_):
        raise np.linalg.LinAlgError("Singular matrix")

    monkeypatch.setattr("estimation.discrepancy.search.search_in_band.search", singular)
    with pytest.raises(DataError, match="no solution"):
        diagnose(LOG, CART)


def agrees(found, whole):
    """Whether nothing is named, and the mass is as it is without the absurd samples, to a deviation."""
    mass, other = (one.certainty.parameters["mass"] for one in (found, whole))
    return not found.effects and abs(mass.value - other.value) < other.std


@pytest.mark.long
@pytest.mark.some(1)
@pytest.mark.parametrize("size", [60.0, 1e3, 1e9])
def test_spikes_of_a_force_are_no_force(whole, size):
    """Of one to three rows, four times, while the hand's own force is steady."""
    rows = np.arange(len(LOG))
    spiked = np.any([(rows >= a) & (rows < a + b) for a, b in ((130, 1), (640, 2), (1100, 3), (1750, 1))], axis=0)
    arm = LOG.arms["hand"]
    wrench = arm.wrench + np.outer(spiked, [size, 0, 0, 0, 0, 0])
    assert agrees(diagnose(replace(LOG, arms={"hand": ArmLog(arm.contact, wrench)}), CART), whole)


@pytest.mark.long
def test_a_pose_that_jumps_for_a_moment_is_no_motion(whole):
    pose = LOG.pose.copy()
    pose[700:702, 1] += 0.4
    assert agrees(diagnose(replace(LOG, pose=pose), CART), whole)
