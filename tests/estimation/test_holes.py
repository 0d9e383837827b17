"""Stretches in which nobody saw the cart are no motion."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cartgrasp.errors import DataError
from cartgrasp.logs import ArmLog, RunLog
from estimation import diagnose
from estimation.discrepancy.holes import without_holes

from .runs import simulate
from .test_discrepancy_parts import guess

TRUTH = (24.0, 0.28, 0.06, 2.2, 3.0, 1.2, 0.0)
LOG, _ = simulate(TRUTH, 3, 20.0, noise=(0.0004, 0.004, 1.0))


def unseen(log, *stretches):
    """Without poses and velocities in rows from one to another."""
    rows = np.arange(len(log))
    gone = np.any([(rows >= a) & (rows < b) for a, b in stretches], axis=0)[:, None]
    return replace(log, pose=np.where(gone, np.nan, log.pose), velocity=np.where(gone, np.nan, log.velocity))


@settings(max_examples=60)
@given(st.lists(st.booleans(), min_size=40, max_size=200))
def test_rows_that_nobody_saw_are_kept_if_they_are_few(seen):
    """By a walk from row to row."""
    if not any(seen):
        return
    n = len(seen)
    pose = np.where(np.array(seen)[:, None], 1.0, np.nan) * np.ones((n, 3))
    log = RunLog(np.arange(n) * 0.07, pose, None, {"hand": ArmLog(np.zeros((n, 3)), np.zeros((n, 6)))})
    kept = []
    for i in range(n):
        before = max((k for k in range(i + 1) if seen[k]), default=None)
        after = min((k for k in range(i, n) if seen[k]), default=None)
        if seen[i] or (before is not None and after is not None and (after - before) * 0.07 < 0.3):
            kept.append(i)
    found = without_holes(log)
    assert found.time.tolist() == log.time[kept].tolist()
    assert len(found.arms["hand"].wrench) == len(kept)


def test_a_log_that_is_seen_all_along_stays_as_it_is():
    assert without_holes(LOG) is LOG
    few = unseen(LOG, (300, 320))
    assert without_holes(few) is few


def test_velocity_alone_is_motion():
    blind = replace(LOG, pose=np.where(np.arange(len(LOG))[:, None] // 500 == 1, np.nan, LOG.pose))
    assert without_holes(blind) is blind
    assert len(without_holes(replace(blind, velocity=None))) == len(LOG) - 500


@pytest.mark.parametrize("stretches", [[(600, 1000)], [(0, 300), (1700, 2000)], [(200, 300), (500, 620), (900, 1000)]])
def test_nothing_is_named_for_what_nobody_saw(stretches):
    found = diagnose(unseen(LOG, *stretches), guess())
    assert not found.effects
    assert found.gap.refitted < 2 * found.gap.noise_floor
    assert found.checks[0].rows == len(LOG)
    lost = sum(b - a for a, b in stretches)
    assert found.checks[0].distance < diagnose(LOG, guess()).checks[0].distance * (1.1 - lost / len(LOG))


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
        diagnose([LOG, bad], guess())


def test_wrenches_that_never_come_with_poses_are_refused():
    """Each has enough, and no row has both."""
    hand = LOG.arms["hand"]
    rows = np.arange(len(LOG))[:, None] < 1000
    late = replace(unseen(LOG, (0, 1000)), arms={"hand": ArmLog(hand.contact, np.where(rows, hand.wrench, np.nan))})
    with pytest.raises(DataError, match="wrenches come with poses in 0 rows"):
        diagnose(late, guess())


def test_equations_without_a_solution_are_no_traceback(monkeypatch):
    def singular(*_):
        raise np.linalg.LinAlgError("Singular matrix")

    monkeypatch.setattr("estimation.discrepancy.diagnosis.select", singular)
    with pytest.raises(DataError, match="no solution"):
        diagnose(LOG, guess())
