"""What hours of pushing bring: covariances stay sound, faults pass, loads come and go."""

from dataclasses import replace

import numpy as np
import pytest

from cartgrasp.effects import ViscousDrag
from cartgrasp.inertia import Inertia
from cartgrasp.model import CartModel
from cartgrasp.motion import Measurement
from estimation import CartFilter, FilterNoise, Prior

from ..runs import simulate_two_hands, weave

TRUTH = (24.0, 0.28, 0.06, 2.2, 3.0, 1.2, 0.0)
NOISE = FilterNoise(0.0005, 0.0005, 0.005, 0.005, 3.0, 0.15)
DRAG = (ViscousDrag(linear=3.0, angular=1.2),)
HANDS = ("left", "right")
FAULT, FAULT_ENDS = 15.0, 35.0


def online(prior=None):
    return CartFilter(CartModel(Inertia(20.0, (0.3, 0.0), 1.8), effects=DRAG), HANDS, noise=NOISE, prior=prior)


def samples(seed, duration, change=None):
    return list(simulate_two_hands(TRUTH, seed, duration, change=change).measurements())


def walk(n):
    """So many measurements, one after the other, of a cart that weaves; one in a hundred of them absurd."""
    cart = CartModel(Inertia(24.0, (0.28, 0.06), 2.2), effects=DRAG)
    random, state = np.random.default_rng(0), np.zeros(5)
    contacts = {"left": np.array([-0.4, 0.25, 1.0]), "right": np.array([-0.4, -0.25, 1.0])}
    force = np.array([3.0] * 3 + [0.15] * 3)
    for k in range(n):
        fx, tau = weave(0.01 * k, state)
        wrenches = {name: force * random.standard_normal(6) for name in HANDS}
        wrenches["left"][0] += fx / 2 - 2 * tau
        wrenches["right"][0] += fx / 2 + 2 * tau
        _, _, theta, u, r = state.tolist()
        velocity = np.array([u * np.cos(theta), u * np.sin(theta), r]) + 0.005 * random.standard_normal(3)
        spread = 3.0 if random.random() < 0.01 else 0.0005
        yield Measurement(0.01 * k, state[:3] + spread * random.standard_normal(3), velocity, wrenches, contacts)
        push = cart.planar_wrench(np.array([fx, tau]))
        state = cart.dynamics.advanced((state, 0.0, cart.parameters), push, 0.01, 1)


def least_eigenvalue(covariance):
    """Of the correlations, whatever the units."""
    if not (np.isfinite(covariance).all() and (np.diagonal(covariance) > 0).all()):
        return -np.inf
    std = np.sqrt(np.diagonal(covariance))
    return float(np.linalg.eigvalsh(covariance / np.outer(std, std)).min())


@pytest.mark.long
@pytest.mark.parametrize("n", [3_000, pytest.param(1_000_000, marks=pytest.mark.prove)])
def test_covariances_stay_sound(n, record_property):
    estimator, least = online(), 1.0
    for k, measurement in enumerate(walk(n)):
        estimate = estimator.update(measurement)
        if k % 50 == 49:
            least = min(least, *map(least_eigenvalue, (estimator.belief.covariance, estimate.covariance)))
            assert least > -1e-9, k
    mass = estimate.parameters["mass"]
    record_property("least eigenvalue of correlations", least)
    record_property("mass", f"{mass.value} +- {mass.std}")
    assert abs(mass.value - 24.0) < 4 * mass.std + 0.1


def outliers(m, random):
    """A third of the samples, of a pose or of wrenches."""
    if random.random() > 0.3:
        return m
    if random.random() < 0.5:
        return replace(m, pose=m.pose + random.normal(0, 1.0, 3))
    return replace(m, wrenches={arm: wrench + random.normal(0, 200.0, 6) for arm, wrench in m.wrenches.items()})


def nothing_but_outliers(m, random):
    return replace(m, pose=m.pose + random.normal(0, 1.0, 3), velocity=m.velocity + random.normal(0, 1.0, 3))


@pytest.mark.long
@pytest.mark.parametrize("fault", [outliers, nothing_but_outliers])
def test_20_s_of_outliers_pass(fault):
    random, estimator = np.random.default_rng(0), online()
    flagged = set()
    for m in samples(0, 45.0):
        is_faulty = FAULT <= m.time < FAULT_ENDS
        estimate = estimator.update(fault(m, random) if is_faulty else m)
        flagged |= {str(estimate.health)} if is_faulty else set()
        if m.time > FAULT_ENDS + 5.0:
            assert_recovered(estimate)
    assert "outliers" in flagged


def silence(m):
    return None if 10.0 <= m.time < 11.0 else m


def nothing_in_them(m):
    return Measurement(m.time) if 10.0 <= m.time < 11.0 else m


def clock_ahead(m):
    return replace(m, time=m.time + 50.0) if m.time >= 11.0 else m


def clock_back(m):
    return replace(m, time=m.time - 8.0) if m.time >= 11.0 else m


@pytest.mark.long
@pytest.mark.parametrize("fault", [silence, nothing_in_them, clock_ahead, clock_back])
def test_a_drop_out_and_a_clock_that_jumps_pass(fault):
    estimator = online()
    for m in samples(1, 20.0):
        told = fault(m)
        if told is None:
            continue
        estimate = estimator.update(told)
        if m.time > 16.0:
            assert_recovered(estimate)
            assert estimate.time == pytest.approx(told.time, abs=1e-6)


def assert_recovered(estimate):
    mass = estimate.parameters["mass"]
    assert abs(mass.value - 24.0) < 3 * mass.std
    assert estimate.health == "ok"


def loaded(mass, place):
    """The cart with a point mass more, or less."""
    m, x, y, inertia, *drags = TRUTH
    whole = m + mass
    com = (m * np.array([x, y]) + mass * np.array(place)) / whole
    about_b = inertia + m * (x**2 + y**2) + mass * np.dot(place, place)
    return whole, *com.tolist(), about_b - whole * np.dot(com, com), *drags


@pytest.mark.some(2)
@pytest.mark.long
@pytest.mark.parametrize(("mass", "place"), [(14.0, (0.28, 0.06)), (14.0, (0.0, 0.0)), (-8.0, (0.28, 0.06))])
def test_a_load_is_noticed_within_2_s_and_learned_within_5(mass, place):
    """Of a cart that is always accelerated, gently."""
    after, noticed, estimator = loaded(mass, place), [], online()
    for m in samples(2, 30.0, (20.0, after)):
        estimate = estimator.update(m)
        if estimate.health == "load_changed":
            noticed.append(m.time)
        if m.time > 25.0:
            found = estimate.parameters["mass"]
            assert abs(found.value - after[0]) < 3 * found.std
            assert estimate.health == "ok"
    assert 20.0 < noticed[0] < 22.0


@pytest.mark.long
@pytest.mark.parametrize("runs", [5, pytest.param(500, marks=pytest.mark.prove)])
def test_quiet_runs_raise_no_alarm(runs, record_property):
    alarms = set()
    for seed in range(runs):
        estimator = online(Prior())
        found = {str(estimator.update(m).health) for m in samples(100 + seed, 15.0)}
        alarms |= {(seed, health) for health in found - {"ok", "no_wrench"}}
    record_property("alarms", sorted(alarms))
    assert not alarms
