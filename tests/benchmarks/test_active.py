"""The benchmark of proposed motions: what is recorded follows the reference, chance keeps within the same limits."""

import json

import numpy as np
import pytest

from benchmarks.active import CHANCE, EFFECTS, FIRST, LIMITS, MOST, WAYS, Run, recorded, run_one, table
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


@pytest.mark.parametrize("way", CHANCE)
def test_chance_keeps_within_the_limits_of_a_proposal(way):
    random = np.random.default_rng(0)
    known = [CHANCE[way](random, CART) for _ in range(20)]
    assert len({one.stretches for one in known}) > 15
    for one in known:
        path = PathReference(one.stretches)
        assert LIMITS.duration / 2 < path.duration <= LIMITS.duration
        u, r = np.abs([path.at(t).velocity for t in np.arange(0.0, path.duration, 0.1)]).max(axis=0)
        assert u <= LIMITS.speed + 1e-6
        assert r <= LIMITS.yaw_rate + 1e-6
        assert path.at(path.duration).velocity == pytest.approx((0.0, 0.0), abs=1e-9)


def test_what_was_run_is_told_and_not_run_again(tmp_path):
    runs = [
        Run(way, ((), ("a", "b"), ("a",)) if k == 0 else ((),) * (MOST + 1), ("x",) * (MOST + 1), k == 0, 1.0)
        for k, way in enumerate(WAYS)
    ]
    (tmp_path / "a-0-0.8-10.json").write_text(json.dumps([vars(run) for run in runs]), encoding="utf-8")
    found = run_one(("a", 0), tmp_path)
    assert found == {run.way: run for run in runs}
    assert [found[way].logs for way in WAYS] == [2, None, None]
    assert f"| `a` | 0 | 2 (2) | more than {MOST} (-) | more than {MOST} (-) |" in table({("a", 0): found})
