"""The benchmark of proposed motions: what is recorded follows the reference, chance keeps within the same limits."""

import json

import numpy as np
import pytest

from benchmarks.active import EFFECTS, FIRST, LIMITS, MOST, PROPOSED, RANDOM, Run, at_random, recorded, run_one, table
from benchmarks.sealed.cases import draw_case
from cartgrasp.constraints import RollingConstraints
from cartgrasp.inertia import Inertia
from cartgrasp.model import CartModel
from planning.references import PathReference

CART = CartModel(Inertia(20.0, (0.3, 0.0), 2.0), RollingConstraints(0.0))


def test_at_least_eight_kinds_are_hidden():
    assert len(EFFECTS) >= 8


def test_the_hidden_cart_follows_the_reference():
    """By feedback of its speed alone, against noise and what is hidden."""
    log = recorded(draw_case("rolling_resistance", 0, "straight"), FIRST, np.random.default_rng(0))
    path = PathReference(FIRST)
    assert log.time[-1] == pytest.approx(path.duration)
    wanted = np.array([path.at(float(t)).pose_sb[0] for t in log.time])
    assert np.abs(np.hypot(*log.pose[:, :2].T) - wanted).max() < 0.2


def test_chance_keeps_within_the_limits_of_a_proposal():
    random = np.random.default_rng(0)
    known = [at_random(random, CART) for _ in range(20)]
    assert len({one.stretches for one in known}) > 15
    for one in known:
        path = PathReference(one.stretches)
        assert LIMITS.duration / 2 < path.duration <= LIMITS.duration
        u, r = np.abs([path.at(t).velocity for t in np.arange(0.0, path.duration, 0.1)]).max(axis=0)
        assert u <= LIMITS.speed + 1e-6
        assert r <= LIMITS.yaw_rate + 1e-6


def test_what_was_run_is_told_and_not_run_again(tmp_path):
    runs = [
        Run(PROPOSED, ((), ("a", "b"), ("a",)), ("x", "y", "z"), True, 1.0),
        Run(RANDOM, ((),) * (MOST + 1), ("x",) * (MOST + 1), False, 1.0),
    ]
    (tmp_path / "a-0-0.8-10.json").write_text(json.dumps([vars(run) for run in runs]), encoding="utf-8")
    found = run_one(("a", 0), tmp_path)
    assert found == {run.way: run for run in runs}
    assert (found[PROPOSED].logs, found[RANDOM].logs) == (2, None)
    assert f"| `a` | 0 | 2 (2) | more than {MOST} (-) |" in table({("a", 0): found})
