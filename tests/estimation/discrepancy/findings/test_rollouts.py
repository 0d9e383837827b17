"""Rollouts against closed forms, and what noise alone does to them against a plant of the tests' own."""

from dataclasses import replace

import numpy as np
import pytest

from cartgrasp.effects import CasterRealignment, ViscousDrag
from cartgrasp.errors import DataError
from cartgrasp.inertia import Inertia
from cartgrasp.logs import ArmLog
from cartgrasp.model import CartModel
from cartgrasp.wheels import Wheel
from estimation import diagnose
from estimation.discrepancy.findings import rollouts as module
from estimation.discrepancy.findings.fast_noise import MAX_FAST_NOISE_RATIO
from estimation.discrepancy.findings.gap import measured_gap
from estimation.discrepancy.findings.held_out import floor_rollouts
from estimation.discrepancy.findings.rollouts import HORIZONS, joined, rolled_out, rollouts, starts
from estimation.discrepancy.search.model import Model
from estimation.weak_form.balances import Balances

from ...runs import STEP, reduced_rate, simulate, simulate_two_hands
from ..logs import straight

TRUTH = (24.0, 0.28, 0.06, 2.2, 3.0, 1.2, 0.0)
DRAG = (ViscousDrag(linear=3.0, angular=1.2),)
CART = CartModel(Inertia(24.0, (0.28, 0.06), 2.2), effects=DRAG)
ROWS = 100
"""Of a rollout of 1 s."""


def test_a_rollout_of_a_wrong_mass_errs_by_its_acceleration():
    cart = CartModel(Inertia(25.0, (0.3, 0.0), 2.0))
    balances = Balances.of(straight(speed=0.1 * 2**0.5), cart)  # from rest, poses would be whole numbers of steps
    found = rollouts(balances, cart, starts(balances))
    first = found.error[:, HORIZONS.index(1.0)]
    assert len(first) >= 4
    assert first[:, 0] == pytest.approx(0.5 * (20.0 / 25.0 - 1.0) / 2, abs=2e-4)
    assert first[:, 1:] == pytest.approx(0.0, abs=1e-6)
    assert found.gaps()[HORIZONS.index(1.0)] == pytest.approx(0.05, abs=3e-4)


@pytest.mark.parametrize("origin", [(5e5, 4e6), (-3e6, 0.0)])
def test_where_a_map_has_its_origin_changes_no_rollout(origin):
    """Metres of a map's grid are millions: places as far as a rollout that has run away had been taken for one."""
    log = simulate(TRUTH, 0, 8.0)[0]
    cart = CartModel(Inertia(20.0, (0.28, 0.06), 2.2), effects=DRAG)
    near, far = (Balances.of(replace(log, pose=log.pose + np.append(there, 0.0)), cart) for there in ((0, 0), origin))
    first = starts(near)
    expected = rollouts(near, cart, first).gaps()
    assert (expected > 1e-3).all()
    assert rollouts(far, cart, first).gaps() == pytest.approx(expected, rel=0.02)


def test_where_no_rollout_begins_nothing_is_told_to_agree():
    """Of wrenches that are blank for 60 ms in every 0.95 s; the cart has a drag that its model lacks. As of a cart at
    rest, the gap had been told as the noise of its poses."""
    log = simulate((*TRUTH[:6], 0.03), 0, 12.0)[0]
    (name, arm), *_ = log.arms.items()
    blank = (log.time[:, None] % 0.95) < 0.06
    gaps = replace(log, arms={name: ArmLog(arm.contact, np.where(blank, np.nan, arm.wrench))})
    with pytest.raises(DataError, match="for 1 s on end"):
        diagnose(gaps, CART)


def test_of_no_rollouts_there_are_none():
    assert joined([]).error.shape == (0, len(HORIZONS), 3)


@pytest.mark.long
def test_rollouts_of_stiff_swivels_are_those_of_finer_steps(monkeypatch):
    """A light cart on heavy casters: in steps of 5 ms it would shake itself off its way."""
    wheels = (Wheel("fixed", 0.0, 0.2), Wheel("fixed", 0.0, -0.2), Wheel("caster", 0.8, 0.2, 0.04))
    cart = CartModel(Inertia(12.0, (0.28, 0.06), 1.0), effects=(*DRAG, CasterRealignment(0.8)), wheels=wheels)
    log, _ = simulate(TRUTH, 0, 12.0)
    balances = Balances.of(log, cart)
    first = starts(balances)
    found = rolled_out(balances, cart, first)[:, :2]
    monkeypatch.setattr(module, "MAX_ROLLOUT_STEP", 2e-4)
    assert np.isfinite(found).all()
    assert found == pytest.approx(rolled_out(balances, cart, first)[:, :2], abs=1e-3)


def slow_noise(n, columns, time_constant, seed):
    random = np.random.default_rng(seed)
    fade = np.exp(-STEP / time_constant)
    noise = random.standard_normal((n, columns))
    for k in range(1, n):
        noise[k] = fade * noise[k - 1] + (1 - fade**2) ** 0.5 * noise[k]
    return noise


def recorded(seed, force, slow, memory):
    """A log with white wrench noise of `force` (N), and slow noise of `slow` (N) that remembers for `memory` (s)."""
    log = simulate_two_hands(TRUTH, seed, 24.0, noise=(0.0004, 0.005, force))
    scale, arms = slow * np.array([1.0, 1.0, 1.0, 0.05, 0.05, 0.05]), {}
    for k, (name, arm) in enumerate(log.arms.items()):
        arms[name] = ArmLog(arm.contact, arm.wrench + scale * slow_noise(len(log), 6, memory, 100 + 2 * seed + k))
    return replace(log, arms=arms)


def reduced(log):
    """Forward force and moment about {b} (n, 2), of both hands."""
    return sum(
        np.column_stack([w[:, 0], w[:, 5] + px * w[:, 1] - py * w[:, 0]])
        for w, (px, py, _) in ((arm.wrench, arm.contact[0]) for arm in log.arms.values())
    )


def misses(balances, log):
    """Squared distances (r,) by which the true cart, pushed by the recorded wrenches, misses the motion after 1 s. Its
    velocities at the start are those that it gained, but for what an average over 0.4 s has beside: a road of its own
    to what the engine's splines say."""
    wrench, found = reduced(log), []
    poses, heading = balances.motion.pose, balances.motion.pose[:, 2]
    state_of = balances.state(CART)
    rates = np.array([reduced_rate(state, *own, TRUTH)[3:] for state, own in zip(state_of, wrench, strict=False)])
    gained, window = STEP * (np.cumsum(rates, axis=0) - rates / 2), np.hanning(43)[1:-1]
    recorded = np.array([np.interp(balances.motion.time, log.time, axis) for axis in log.velocity.T])
    measured = np.array([np.cos(heading) * recorded[0] + np.sin(heading) * recorded[1], recorded[2]])
    whole = np.convolve(np.ones(len(gained)), window, "same")
    for k in range(2):
        state_of[:, 3 + k] = gained[:, k] + np.convolve(measured[k] - gained[:, k], window, "same") / whole
    for first in starts(balances):
        state = state_of[first].copy()
        for k in range(first, first + ROWS):
            fx, tau = wrench[k]
            k1 = reduced_rate(state, fx, tau, TRUTH)
            k2 = reduced_rate(state + STEP / 2 * k1, fx, tau, TRUTH)
            k3 = reduced_rate(state + STEP / 2 * k2, fx, tau, TRUTH)
            k4 = reduced_rate(state + STEP * k3, fx, tau, TRUTH)
            state = state + STEP / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
        found.append(((state[:2] - poses[first + ROWS, :2]) ** 2).sum())
    return found


@pytest.mark.long
@pytest.mark.some(1)
@pytest.mark.parametrize(
    ("force", "slow", "memory"), [(1.0, 0.0, 0.04), (3.0, 0.0, 0.04), (0.5, 3.0, 0.04), (0.5, 3.0, 0.07)]
)
def test_the_floor_is_what_a_true_model_does(force, slow, memory):
    """But for noise that remembers for more than 50 ms: it counts as MAX_FAST_NOISE_RATIO times as loud as it looks."""
    fade = np.exp(-STEP / memory)
    told = min(MAX_FAST_NOISE_RATIO / np.sqrt((1 + fade) / (1 - fade)), 1.0) if slow else 1.0
    true, floors = [], []
    for seed in range(6):
        log = recorded(seed, force, slow, memory)
        balances = Balances.of(log, CART)
        true += misses(balances, log)
        floors.append(floor_rollouts(Model.started([balances], CART)).gaps()[HORIZONS.index(1.0)])
    assert np.sqrt(np.mean(np.square(floors))) == pytest.approx(told * np.sqrt(np.mean(true)), rel=0.25)


def test_simulations_that_run_away_are_refused(monkeypatch):
    """As they do on a log in mN or mm."""
    model = Model.started([Balances.of(simulate(TRUTH, 0, 12.0)[0], CART)], CART)
    monkeypatch.setattr(module.Rollouts, "gaps", lambda self: np.full(len(HORIZONS), np.nan))
    with pytest.raises(DataError, match=r"run: .*SI units"):
        measured_gap(model, model)
