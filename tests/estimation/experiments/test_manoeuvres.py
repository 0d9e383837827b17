"""Pieces of manoeuvres against the references that run them."""

import numpy as np
import pytest

from cartgrasp.constraints import RollingConstraints
from cartgrasp.errors import UsageError
from estimation.experiments.manoeuvres import HOLD_DURATION, MANOEUVRE_TIME_STEP, Limits, path, pieces, said, sampled
from planning.references import PathReference

FIXED = RollingConstraints(0.0)
LIMITS = Limits(speed=0.7)
START = np.array([0.4, -0.2, 0.3])


@pytest.mark.parametrize("piece", pieces(LIMITS, FIXED), ids=lambda piece: piece.says)
def test_a_piece_is_what_the_reference_runs(piece):
    """Whose poses are quadratures; ours are sums over middles of steps, off by their square."""
    reference = PathReference(piece.stretches, FIXED, tuple(START))
    time, velocity_b, _ = sampled(piece)
    poses, end = path(velocity_b, START)
    known = [reference.at(float(t)) for t in time]
    assert velocity_b[:, [0, 2]] == pytest.approx(np.array([one.velocity for one in known]), abs=1e-9)
    assert poses == pytest.approx(np.array([one.pose_sb for one in known]), abs=2 * MANOEUVRE_TIME_STEP**2)
    assert end == pytest.approx(reference.at(reference.duration).pose_sb, abs=MANOEUVRE_TIME_STEP**2)
    assert (np.abs(velocity_b).max(axis=0) <= [LIMITS.speed + 1e-9, 0.0, LIMITS.yaw_rate + 1e-9]).all()
    assert piece.duration > HOLD_DURATION


def test_only_a_cart_that_may_turns():
    assert not any(
        velocity[:, 2].any() for _, velocity, _ in map(sampled, pieces(LIMITS, RollingConstraints(0.0, True)))
    )


def test_words_count():
    roll, *_, turn = pieces(LIMITS, FIXED)
    assert said([roll, roll, turn, roll]) == f"{roll.says} twice, {turn.says}, {roll.says}"


@pytest.mark.parametrize("wrong", [{"speed": 0.0}, {"speed": float("nan")}, {"duration": 3.0}, {"duration": 1e9}])
def test_limits_are_checked(wrong):
    with pytest.raises(UsageError, match="limits"):
        Limits(**wrong)
