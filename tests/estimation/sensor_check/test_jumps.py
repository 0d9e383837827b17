"""Trackers that lose the cart and find it elsewhere."""

from dataclasses import replace

import numpy as np
import pytest

from estimation.sensor_check import check_sensors
from estimation.sensor_check.jumps import jumps

from .logs import CART, found, sealed, two_hands


@pytest.mark.parametrize(("where", "by"), [("pose", (0.05, 0, 0)), ("pose", (0, -2, 0)), ("heading", (0, 0, 0.2))])
def test_a_jump_is_told_with_its_size_and_time(where, by):
    log = two_hands(0)
    moved = replace(log, pose=log.pose + np.outer(log.time > 17.0, by))
    (told,) = jumps(moved)
    assert (told.kind, told.where) == ("jumps", where)
    assert told.factor == pytest.approx(np.linalg.norm(by), rel=0.2)
    assert "once" in told.words
    assert "at t = 17" in told.words
    assert ("jumps", where) in found(check_sensors(moved, CART))


@pytest.mark.long
def test_what_is_no_jump():
    """A cart that is stopped by a wall, coarse steps, rows that repeat, rows that are lost, and single wild rows."""
    log = two_hands(0)
    at = np.minimum(log.time, 17.0)
    stopped = np.column_stack([0.8 * at, 0 * at, 0 * at])
    rows = np.arange(len(log))
    assert jumps(replace(log, pose=stopped + np.random.default_rng(0).normal(0, 5e-4, stopped.shape))) == ()
    assert jumps(replace(log, pose=np.round(log.pose / 0.01) * 0.01)) == ()
    assert jumps(replace(log, pose=log.pose[rows // 3 * 3])) == ()
    lost = np.where((rows % 50 < 20)[:, None], np.nan, log.pose)
    assert jumps(replace(log, pose=lost)) == ()
    for seed in range(3):
        assert jumps(sealed("nothing", seed)[0]) == ()
