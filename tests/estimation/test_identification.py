"""The batch fit on logs made by the tests' own equations: unbiased, honest, and physical."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import lsq_linear, minimize

from cartgrasp.constraints import RollingConstraints
from cartgrasp.effects import ForceBias, RollingResistance, ViscousDrag
from cartgrasp.errors import DataError, UsageError
from cartgrasp.inertia import Inertia, phi_from_physical
from cartgrasp.logs import ArmLog, RunLog
from cartgrasp.model import CartModel
from estimation import FilterNoise, Prior, physical_set
from estimation.batch.block_tridiagonal import BlockTridiagonal
from estimation.batch.identification import fit
from estimation.batch.motion_smoother import smooth_motion
from estimation.batch.wrench_record import WrenchRecord
from estimation.batch.wrench_regression import DELAY, WrenchRegression
from estimation.identification import identify
from estimation.log_noise import noise_of_log
from estimation.physical_set import PhysicalSet

from .runs import simulate, simulate_two_hands

TRUTH = (24.0, 0.28, 0.06, 2.2, 3.0, 1.2, 0.02)
DRAGS = (ViscousDrag(linear=2.0, angular=1.0), RollingResistance(coefficient=0.015))
NAMES = ("mass", "com_x", "com_y", "inertia")


def guess(mass=20.0, com=(0.3, 0.0), inertia=1.8, effects=DRAGS):
    return CartModel(Inertia(mass, com, inertia), effects=effects)


def scores(found, truth=TRUTH):
    """Errors in units of the deviations, in the order of the parameters."""
    return np.array([(p.value - v) / p.std for p, v in zip(found.parameters.values(), truth, strict=True)])


def drawn(force, seed, duration=10.0):
    return simulate(TRUTH, seed, duration, noise=(0.0004, 0.005, force))[0]


@pytest.mark.parametrize("force", [0.0, 1.0, 3.0])
def test_the_load_is_found_within_its_deviations(force):
    found = identify([drawn(force, seed=1)], guess())
    assert np.abs(scores(found)).max() < 4.0
    assert found.parameters["mass"].value == pytest.approx(24.0, rel=0.01 + 0.01 * force)
    assert all(found.parameters[name].identifiable for name in NAMES)
    assert found.logs[0].noise_excess < 6.0
    assert found.cart().inertia.mass == pytest.approx(found.parameters["mass"].value)


@pytest.mark.prove
@pytest.mark.parametrize("force", [0.0, 1.0, 3.0])
@pytest.mark.parametrize("two", [False, True])
def test_bias_and_coverage_over_20_seeds(force, two):
    seeds = range(20)
    if two:
        logs = [simulate_two_hands(TRUTH, seed, noise=(0.0005, 0.005, force)) for seed in seeds]
    else:
        logs = [drawn(force, seed, duration=12.0) for seed in seeds]
    z = np.array([scores(identify([log], guess())) for log in logs])
    assert np.abs(z).max() < 4.5
    assert np.sqrt((z**2).mean()) < 1.2
    assert (np.abs(z) < 1.96).mean() > 0.9
    assert np.abs(z.mean(axis=0)).max() < 1.0


def test_a_straight_push_teaches_neither_com_x_nor_inertia():
    truth = (24.0, 0.28, 0.0, 2.2, 3.0, 1.2, 0.02)
    log, _ = simulate(truth, 4, curved=False, noise=(0.0004, 0.005, 1.0))
    found = identify([log], guess()).parameters
    assert found["mass"].identifiable
    assert abs(found["mass"].value - 24.0) < 4 * found["mass"].std
    for name in ("com_x", "inertia"):
        assert not found[name].identifiable
        assert found[name].std > 0.5 * Prior().deviations(guess())[NAMES.index(name)]


def test_two_logs_teach_what_neither_does():
    """Deviations add in quadrature where both teach, and the joint fit lies between them."""
    logs = [drawn(3.0, seed) for seed in (5, 6)]
    alone = [identify([log], guess()).parameters["mass"] for log in logs]
    together = identify(logs, guess())
    mass = together.parameters["mass"]
    assert mass.std < min(one.std for one in alone)
    assert mass.std == pytest.approx(sum(one.std**-2 for one in alone) ** -0.5, rel=0.25)
    assert min(one.value for one in alone) < mass.value < max(one.value for one in alone)
    assert np.abs(scores(together)).max() < 4.0
    assert len(together.logs) == 2


def at_rest(n=400, force=3.0):
    random = np.random.default_rng(2)
    wrench = force * random.standard_normal((n, 6)) * [1, 1, 1, 0.05, 0.05, 0.05]
    return RunLog(
        time=0.01 * np.arange(n),
        pose=0.0004 * random.standard_normal((n, 3)),
        velocity=0.005 * random.standard_normal((n, 3)),
        arms={"hand": ArmLog(np.tile([-0.3, 0.1, 1.0], (n, 1)), wrench)},
    )


def test_a_log_without_motion_returns_the_prior():
    """Noise that moves nothing is no evidence of an infinite mass."""
    cart = guess(effects=(ViscousDrag(linear=2.0, angular=1.0),))
    found = identify([at_rest()], cart)
    assert not any(p.identifiable for p in found.parameters.values())
    first = Prior().deviations(cart)
    for (name, p), std, value in zip(found.parameters.items(), first, (20.0, 0.3, 0.0, 1.8, 2.0, 1.0), strict=True):
        assert p.value == pytest.approx(value, abs=0.25 * std), name
        assert p.std == pytest.approx(std, rel=0.15), name


def test_without_a_wrench_it_is_the_prior():
    log = drawn(1.0, 3)
    arms = {"hand": ArmLog(log.arms["hand"].contact, np.full((len(log), 6), np.nan))}
    found = identify([replace(log, arms=arms)], guess())
    assert found.model_parameters == pytest.approx(guess().parameters, abs=1e-9)
    assert not any(p.identifiable for p in found.parameters.values())


def test_what_is_known_stays():
    found = identify([drawn(1.0, 3)], guess(), Prior(known=frozenset({"viscous_drag"})))
    drag = found.parameters["viscous_drag.linear"]
    assert (drag.value, drag.std, drag.identifiable) == (2.0, 0.0, False)


def test_an_untared_sensor_is_found():
    log = drawn(1.0, 7)
    hand = log.arms["hand"]
    log = replace(log, arms={"hand": ArmLog(hand.contact, hand.wrench + np.array([2.0, 0, 0, 0, 0, 0.4]))})
    found = identify([log], guess().with_effect(ForceBias(label="hand")))
    bias = found.parameters["force_bias.hand.fx"]
    assert abs(bias.value - 2.0) < 4 * bias.std
    assert bias.identifiable
    assert abs(found.parameters["mass"].value - 24.0) < 4 * found.parameters["mass"].std


def test_rows_that_are_missing_and_a_contact_that_moves():
    """Holes in each sensor, no velocity, and the hand elsewhere from 5 s on with the moment that this gives."""
    log = drawn(1.0, 8)
    hand, random = log.arms["hand"], np.random.default_rng(0)
    contact, wrench, pose = hand.contact.copy(), hand.wrench.copy(), log.pose.copy()
    late = log.time > 5.0
    contact[late, 1] -= 0.3
    wrench[late, 5] -= 0.3 * wrench[late, 0]
    pose[random.random(len(log)) < 0.1, 2] = np.nan
    wrench[random.random(len(log)) < 0.1] = np.nan
    contact[random.random(len(log)) < 0.3] = np.nan
    contact[0], contact[np.flatnonzero(late)[0]] = hand.contact[0], hand.contact[0] - [0.0, 0.3, 0.0]
    keep = (log.time < 3.0) | (log.time > 3.6)
    found = identify([RunLog(log.time[keep], pose[keep], None, {"hand": ArmLog(contact[keep], wrench[keep])})], guess())
    assert np.abs(scores(found)).max() < 4.5
    assert found.parameters["mass"].identifiable


# --- parts ---------------------------------------------------------------------------------------------------


def dense(chain):
    n, d, _ = chain.diagonal.shape
    whole = np.zeros((n * d, n * d))
    for i in range(n):
        whole[i * d : (i + 1) * d, i * d : (i + 1) * d] = chain.diagonal[i]
    for i in range(n - 1):
        whole[(i + 1) * d : (i + 2) * d, i * d : (i + 1) * d] = chain.below[i]
        whole[i * d : (i + 1) * d, (i + 1) * d : (i + 2) * d] = chain.below[i].T
    return whole


@pytest.mark.parametrize(("n", "d"), [(1, 3), (2, 1), (5, 4), (9, 2)])
def test_banded_solutions_are_dense_ones(n, d):
    random = np.random.default_rng(n)
    roots = random.standard_normal((n - 1, 2 * d, d)), random.standard_normal((n - 1, 2 * d, d))
    chain = BlockTridiagonal.of_pairs(*roots, np.tile(np.eye(2 * d), (n - 1, 1, 1)))
    chain = chain + BlockTridiagonal(np.tile(np.eye(d), (n, 1, 1)), np.zeros((n - 1, d, d)))
    right = random.standard_normal((n, d, 3))
    solved = np.linalg.solve(dense(chain), right.reshape(n * d, 3)).reshape(n, d, 3)
    assert chain.factor().solve(right) == pytest.approx(solved, abs=1e-10)
    assert chain.factor().log_determinant == pytest.approx(np.linalg.slogdet(dense(chain))[1])


@pytest.mark.parametrize("f", [1, 2, 3])
def test_rows_between_some_nodes_add_to_a_chain(f):
    """As pairs of all nodes, most of which say nothing."""
    random, n, d = np.random.default_rng(f), 7, 4
    known = BlockTridiagonal(random.standard_normal((n, d, d)), random.standard_normal((n - 1, d, d)))
    nodes, roots = np.array([0, 2, 5]), random.standard_normal((3, f, f))
    parts = random.standard_normal((3, f, d)), random.standard_normal((3, f, d)), roots @ np.swapaxes(roots, 1, 2)
    every = [np.zeros((n - 1, *part.shape[1:])) for part in parts]
    for whole, part in zip(every, parts, strict=True):
        whole[nodes] = part
    found, wanted = known.with_pairs(nodes, *parts), known + BlockTridiagonal.of_pairs(*every)
    assert found.diagonal == pytest.approx(wanted.diagonal)
    assert found.below == pytest.approx(wanted.below)


def test_the_evidence_is_that_of_dense_least_squares():
    """Partials by differences, and the covariance `R + J Σ Jᵀ` written out, J at the usual delay."""
    log = drawn(1.0, 9, duration=0.8)
    cart, delay = guess(effects=DRAGS[:1]), 0.3
    noise = noise_of_log(log, cart)
    regression = WrenchRegression(log, cart, noise)
    motion, record = regression.motion, WrenchRecord.of(log, cart, noise)
    n, d = motion.state.shape

    def residual(parameters, state, late=delay):
        nodes = state.reshape(n, d)
        wrench = cart.required_wrench(nodes[:, :5], nodes[:, 5:], parameters, motion.time)
        return (
            record.reduced(cart.with_parameters(parameters))[:-1] - (1 - late) * wrench[:-1] - late * wrench[1:]
        ).ravel()

    def differences(function, at, step):
        moves = step * np.eye(len(at))
        return np.stack([(function(at + move) - function(at - move)) / (2 * step) for move in moves], axis=1)

    first, state = cart.parameters, motion.state.ravel()
    J = differences(lambda moved: residual(first, moved, DELAY), state, 1e-5)
    G = -differences(lambda moved: residual(moved, state), first, 1e-5)
    late = -differences(lambda moved: residual(first, state, moved[0]), np.array([delay]), 1e-4)
    G = np.hstack([G, late])
    R = np.zeros((2 * (n - 1), 2 * (n - 1)))
    for i in range(n - 1):
        R[2 * i : 2 * i + 2, 2 * i : 2 * i + 2] = record.covariance[i]
    V = R + J @ np.linalg.inv(dense(motion.information)) @ J.T
    evidence = regression.evidence(first, delay)
    scale = 1 / np.sqrt(np.diagonal(G.T @ np.linalg.solve(V, G)) + 1e-9)
    information = G.T @ np.linalg.solve(V, G) * np.outer(scale, scale)
    assert evidence.blocks.sum(axis=0) * np.outer(scale, scale) == pytest.approx(information, abs=2e-3)
    pull = G.T @ np.linalg.solve(V, residual(first, state))
    assert evidence.pulls.sum(axis=0) * scale == pytest.approx(pull * scale, abs=2e-2)


def test_pairs_of_rows_tell_what_rows_tell():
    log = drawn(3.0, 6, duration=20.0)
    cart = guess()
    whole, pairs = (fit(cart, Prior(), [WrenchRegression(log, cart, None, both)]) for both in (False, True))
    free = whole.covariance.any(axis=0)
    std, other = (np.sqrt(np.diagonal(f.covariance)[free]) / f.logs[0].noise_excess ** 0.5 for f in (whole, pairs))
    assert other == pytest.approx(std, rel=0.05)
    assert np.abs(scores(pairs)).max() < 3.5
    apart = (pairs.model_parameters - whole.model_parameters)[free]
    assert np.abs(apart / std).max() < 0.5
    step = np.diff(log.time)[0]
    assert pairs.logs[0].delay * 2 * step == pytest.approx(whole.logs[0].delay * step, abs=0.1 * step)


def test_smoothed_motion_is_as_wrong_as_it_says():
    log, truth = simulate(TRUTH, 11, 2.0)
    motion = smooth_motion(log, guess(), FilterNoise(0.0004, 0.0004, 0.005, 0.005))
    n = len(log)
    covariance = np.linalg.inv(dense(motion.information)).reshape(n, 7, n, 7)[range(n), :, range(n), :]
    error = np.hstack([motion.pose, motion.velocity]) - truth
    z = error / np.sqrt(np.diagonal(covariance, axis1=1, axis2=2)[:, :5])
    assert np.sqrt((z**2).mean(axis=0)) == pytest.approx(np.ones(5), abs=0.45)
    assert (motion.jerk > 0).all()


def projected(parameters, information, least):
    """The nearest physical parameters by a search over mass, CoM and inertia, which keep within bounds there."""

    def cost(physical):
        miss = phi_from_physical(*physical) - parameters
        return miss @ information @ miss

    starts = [(5.0, 0.1, 0.1, 1.0), (10.0, 0.3, -0.2, least[1]), (2.0, 0.0, 0.0, 3.0)]
    bounds = [(least[0], None), (None, None), (None, None), (least[1], None)]
    tried = [minimize(cost, start, bounds=bounds, tol=1e-14, options={"maxiter": 5000}) for start in starts]
    return phi_from_physical(*min(tried, key=lambda one: one.fun).x)


@pytest.mark.parametrize("seed", range(4))
def test_the_nearest_body_is_that_of_a_search(seed):
    random = np.random.default_rng(seed)
    cart = guess(effects=())
    limits = PhysicalSet.of(cart, "a test")
    parameters = np.array([8.0, 6.0, -4.0, 2.0]) + random.standard_normal(4)
    root = random.standard_normal((4, 4)) + 2 * np.eye(4)
    information = root @ root.T
    assert not limits.holds(parameters)
    nearest = limits.nearest(parameters, np.arange(4), information)
    assert limits.holds(nearest)
    assert nearest == pytest.approx(projected(parameters, information, (2.0, 0.09)), abs=3e-3)


@given(st.integers(0, 2**32 - 1))
def test_the_least_step_within_bounds_is_that_of_another_solver(seed):
    random = np.random.default_rng(seed)
    root = random.standard_normal((5, 5))
    metric, low = root @ root.T + 0.1 * np.eye(5), random.normal(-0.5, 1.0, 5)
    high = low + random.exponential(2.0, 5)
    low[0], high[1] = -np.inf, np.inf
    expected = lsq_linear(np.linalg.cholesky(metric).T, np.zeros(5), (low, high), method="bvls").x
    assert physical_set._least(metric, low, high) == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize("seed", range(4))
def test_the_nearest_within_bounds_is_that_of_a_search(seed):
    random = np.random.default_rng(seed)
    cart = guess(effects=DRAGS)
    limits = PhysicalSet.of(cart, "a test")
    parameters = cart.parameters + np.array([0.5, 0.1, 0.1, 1.0, -6.0, 0.3, -0.01]) * random.uniform(0.5, 1.0, 7)
    root = random.standard_normal((7, 7)) + 3 * np.eye(7)
    information = root @ root.T
    nearest = limits.nearest(parameters, np.arange(7), information)
    bounds = [(None, None)] * 4 + [(0.0, None)] * 2 + [(0.0, 1.0)]
    found = minimize(
        lambda p: (p - parameters) @ information @ (p - parameters), cart.parameters, bounds=bounds, tol=1e-12
    )
    assert limits.holds(nearest)
    assert nearest == pytest.approx(found.x, abs=2e-4)


def test_a_fit_that_would_be_no_body_is_brought_to_one():
    """Sure of a tiny inertia, and shown one that is smaller still."""
    log = drawn(3.0, 12, duration=6.0)
    hand = log.arms["hand"]
    wrench = hand.wrench.copy()
    wrench[:, 5] = -wrench[:, 5]
    found = identify([replace(log, arms={"hand": ArmLog(hand.contact, wrench)})], guess())
    assert found.cart().inertia.about_com >= 0.05 * 1.8
    for name, effect in (("viscous_drag.linear", 0.0), ("viscous_drag.angular", 0.0)):
        assert found.parameters[name].value >= effect


def test_a_rail_keeps_what_it_can_not_teach():
    truth = (24.0, 0.0, 0.0, 2.2, 3.0, 1.2, 0.02)
    log, _ = simulate(truth, 5, curved=False, noise=(0.0004, 0.005, 1.0))
    cart = replace(guess(), constraints=RollingConstraints(axle_x=0.0, no_rotation=True))
    found = identify([log], cart)
    assert abs(found.parameters["mass"].value - 24.0) < 4 * found.parameters["mass"].std
    body = found.cart().inertia
    assert (*body.com, body.about_com) == pytest.approx((0.3, 0.0, 1.8))


def test_refusals():
    with pytest.raises(UsageError, match="at least one"):
        identify([], guess())
    log = drawn(0.0, 0, duration=1.0)
    with pytest.raises(DataError, match="SI units"):
        identify([replace(log, pose=log.pose * 1e160)], guess())
