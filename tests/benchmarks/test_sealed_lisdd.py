"""LISDD: regimes and terms that are there, and none where there is noise alone; its tests against their definitions."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from benchmarks.sealed import lisdd
from benchmarks.sealed.columns import Candidate
from benchmarks.sealed.lisdd import Partition, Rows, Term, confirmed, localised, rejected
from benchmarks.sealed.recorded import Cart, Recorded

STEP, N = 0.1, 600
CART = Cart(30.0, (0.3, 0.05), 2.0, (4.0, 1.5))


def driven(seed, push=0.0, patch=0.0):
    """A cart in curves by Newton and Euler, with white noise of 0.5 N, 0.5 N m and 1 mm/s; pushed from 20 to 26 s, and
    braked where x is above 1 m."""
    random = np.random.default_rng(seed)
    time = STEP * np.arange(N)
    a, b, p, q = random.uniform(0.3, 0.9, 4)
    u, du = a * np.sin(p * time), a * p * np.cos(p * time)
    r, dr = b * np.sin(q * time + 1), b * q * np.cos(q * time + 1)
    x, y = 2 * np.sin(0.21 * time), 2 * np.cos(0.16 * time)
    (dx, dy), yaw = CART.com, CART.body[3]
    force = (
        30 * (du - dr * dy - r**2 * dx)
        + 4 * u
        - push * ((time > 20) & (time < 26))
        + patch * (x > 1) * np.tanh(u / 0.01)
    )
    moment = yaw * dr + 30 * (dx * u * r - dy * du) + 1.5 * r
    force, moment = (one + 0.5 * random.standard_normal(N) for one in (force, moment))
    zero = np.zeros(N)
    wrench, rate = np.column_stack([force, zero, zero, zero, zero, moment]), np.zeros((N, 2))
    side = 1e-3 * random.standard_normal(N)
    contact = {"arm": np.zeros((N, 3))}
    return Recorded(time, x, y, np.cumsum(r) * STEP, u, side, r, du, dr, {"arm": wrench}, contact, rate)


def inside(report, log):
    return np.any([(log.time >= a) & (log.time <= b) for a, b in report["where"][0]["intervals"]], axis=0)


@pytest.mark.parametrize("seed", range(3))
def test_a_push_is_named_in_its_time(seed):
    log = driven(seed, push=4.0)
    report = localised(log, CART)
    assert [one["name"] for one in report["effects"]] == ["external_push"]
    told = {name: one["value"] for name, one in report["effects"][0]["parameters"].items()}
    assert told["force"] == pytest.approx(4.0, abs=1.0)
    assert told["start"] == pytest.approx(20.0, abs=2.0)
    assert told["start"] + told["duration"] == pytest.approx(26.0, abs=2.0)
    assert (inside(report, log) == ((log.time > 20) & (log.time < 26))).mean() > 0.93


@pytest.mark.parametrize("seed", range(3))
def test_a_carpet_is_named_in_its_place(seed):
    log = driven(seed, patch=4.0)
    report = localised(log, CART)
    assert {one["name"] for one in report["effects"]} == {"floor_patch"}
    assert report["effects"][0]["parameters"]["x_min"]["value"] == pytest.approx(1.0, abs=0.5)
    assert (inside(report, log) == (log.x > 1)).mean() > 0.85


def test_noise_alone_is_seldom_told():
    told = [localised(driven(seed), CART) for seed in range(100, 130)]
    assert sum(bool(one["effects"]) for one in told) <= 2
    assert all(one["where"] == [] for one in told if one["verdict"] == "no_discrepancy")
    assert sum(one["verdict"] == "no_discrepancy" for one in told) >= 22


@given(st.lists(st.floats(0, 1) | st.floats(0, 0.02), max_size=12))
def test_the_false_discovery_rate_is_controlled_by_the_step_up_rule(p):
    ordered = sorted(p)
    most = max((k for k in range(1, len(p) + 1) if ordered[k - 1] <= lisdd.LEVEL * k / len(p)), default=0)
    assert rejected(np.array(p)).sum() >= most
    assert (
        sorted(np.array(p)[rejected(np.array(p))])
        == ordered[: len([one for one in p if most and one <= ordered[most - 1]])]
    )


def test_the_f_test_is_exact(monkeypatch):
    """At a level of a half, a half of the terms that have nothing to do with white noise are confirmed."""
    monkeypatch.setattr(lisdd, "LEVEL", 0.5)
    random, every = np.random.default_rng(7), np.ones(12, dtype=bool)
    found = []
    for _ in range(600):
        rows = Rows(random.standard_normal((3, 12)), random.standard_normal((3, 12, 4)), 100.0)
        term = Term(Candidate("force_bias", np.empty(0)), every, random.standard_normal((3, 12, 2)))
        found.append(bool(confirmed(rows, Partition("all", ~every, [every]), [term], every)))
    assert np.mean(found) == pytest.approx(0.5, abs=0.06)  # three deviations
