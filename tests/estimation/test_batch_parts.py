"""Parts of the batch fit by smoothed motion, by dense algebra and drawing."""

import numpy as np
import pytest

from estimation import FilterNoise, Prior
from estimation.batch.block_tridiagonal import BlockTridiagonal
from estimation.batch.identification import fit
from estimation.batch.motion_smoother import smooth_motion
from estimation.batch.wrench_record import WrenchRecord
from estimation.batch.wrench_regression import DELAY, WrenchRegression
from estimation.log_noise import noise_of_log

from .runs import simulate
from .test_identification import DRAGS, TRUTH, drawn, guess, scores


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
