"""Steps of the observed disturbance, which are kernels, against the same in numpy; with effects from outside, too."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import event, given, settings
from hypothesis import strategies as st

import cartgrasp as cg
from cartgrasp.effects import CasterRealignment, LateralSlip, LoadSlosh, RollingResistance, ViscousDrag
from cartgrasp.frames import body_to_world, rotation_planar
from cartgrasp.rigid_body import regressor_b
from estimation import FilterNoise, Prior
from estimation.gaussian import Gaussian
from estimation.online.disturbance.observer import PUSH_FORCE_STD, DisturbanceObserver
from estimation.online.kernels.correction import MIN_ROW_VARIANCE
from estimation.online.kernels.observed_motion import MAX_PUSH_ACCELERATION, MAX_VELOCITY_AGE, SURPRISE_CHI2
from estimation.online.kernels.observed_wrench import MAX_OBSERVER_STEP
from estimation.online.kernels.relocalisation import (
    MAX_DRIFT_SPEED,
    MAX_RELOCALISATION_SPEED,
    MIN_MOVED_SOURCE_DURATION,
)
from estimation.online.load_change import load_covariance

from ...core.drawn import CONSTRAINTS, SHOPPING_CART, vectors
from ...core.test_kernels import Lag
from .reference_filtering import exponential_step, innovation, predicted, updated

NOISE = FilterNoise(0.002, 0.003, 0.01, 0.02, 2.0, 0.1, disturbance=0.3, slip=0.004)
SMALL = vectors(9, -1.0, 1.0)


EFFECTS = {
    "drags": (ViscousDrag(3.0, 1.2), RollingResistance(0.02)),
    "casters and a load that swings": (CasterRealignment(0.3), LoadSlosh(4.0)),
    "wheels that creep": (ViscousDrag(3.0, 1.2), LateralSlip(2000.0)),
    "one's own": (ViscousDrag(3.0, 1.2), Lag()),
}
KINDS = "casters only", "axle ahead", "rail"
CASES = [(kind, what) for kind in KINDS for what in EFFECTS if kind == "axle ahead" or "creep" not in what]
few = settings(max_examples=15)


def observer(kind, what):
    inertia = cg.Inertia(30.0, (0.3, 0.05), 2.7)
    cart = cg.CartModel(inertia, CONSTRAINTS[kind], EFFECTS[what], SHOPPING_CART, com_height=0.4)
    return DisturbanceObserver(cart, NOISE, 0.2, Prior())


def drawn(of, numbers):
    """A state of belief, pushed, with parameters that are not those of the cart as it was made."""
    k, random = of.cart.constraints.n_free, np.random.default_rng(int(1e6 * abs(numbers).sum()))
    n = 3 + 2 * k
    root = 0.05 * random.normal(size=(n, n))
    mean = np.concatenate([numbers[:3], numbers[3 : 3 + k], 20.0 * numbers[-k:]])
    seen = replace(of.start(0.3, np.zeros(3)), belief=Gaussian(mean, root @ root.T + 1e-4 * np.eye(n)))
    noise = 0.3 * random.normal(size=(k, k))
    theta = of.cart.parameters * (1.0 + 0.1 * random.uniform(-1, 1, len(of.cart.parameters)))
    memory = 0.3 * random.normal(size=len(of.cart.memory_names))
    return of.pushed(seen, 30.0 * random.normal(size=k), noise @ noise.T), memory, theta


def stepped(of, seen, time, memory, theta):
    cart, noise, k = of.cart, NOISE, seen.k
    lift, belief, at = cart.planar_wrench(np.eye(k)).T, seen.belief, seen.time
    n, moved, walk = 3 + 2 * k, slice(3 + k), np.arange(3 + k, 3 + 2 * k)
    count = int(np.ceil((time - at) / MAX_OBSERVER_STEP - 1e-6))
    step = (time - at) / count
    for i in range(count):
        mean = belief.mean
        state = np.concatenate([mean[: 3 + k], memory])
        flow = cart.rate(state, lift @ (seen.given + mean[3 + k :]), theta, at + i * step)
        jacobian, rate, density = np.zeros((n, n)), np.zeros(n), np.zeros((n, n))
        reach = flow.by_wrench[moved] @ lift
        jacobian[moved, moved], jacobian[moved, walk], rate[moved] = (
            flow.by_state[moved, moved],
            reach,
            flow.value[moved],
        )
        white = flow.by_wrench[moved] * np.array([1.0, 1.0, noise.lever]) * noise.disturbance
        sideways = rotation_planar(mean[2]) @ cart.rolling.across_b
        density[moved, moved] = reach @ seen.given_noise @ reach.T * step + white @ white.T
        density[:2, :2] += noise.sideways(cart) ** 2 * np.outer(sideways, sideways)
        density[2, 2] += noise.slip**2
        per_root = theta[0] / cart.inertia.mass * of._inertias * (2.93 / of.response) ** 2 * of._heard
        density[walk, walk] = per_root**2 * step
        belief = predicted(belief, exponential_step(rate, jacobian, density, step))
    return belief


@pytest.mark.some(4)
@pytest.mark.parametrize(("kind", "what"), CASES)
@few
@given(numbers=SMALL, gap=st.floats(1e-3, 0.09))
def test_advanced(kind, what, numbers, gap):
    of = observer(kind, what)
    seen, memory, theta = drawn(of, numbers)
    found = of.advanced(seen, 0.3 + gap, memory, theta)
    expected = stepped(of, seen, 0.3 + gap, memory, theta)
    scale = np.abs(expected.covariance).max()
    np.testing.assert_allclose(found.belief.mean, expected.mean, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(found.belief.covariance, expected.covariance, rtol=1e-8, atol=1e-11 * scale)
    assert found.time == 0.3 + gap
    assert found.surprised == seen.surprised


MISSING = st.sets(st.integers(0, 5))


@pytest.mark.parametrize("surprised", [0, 1, 4, 12])
@pytest.mark.parametrize("kind", KINDS)
@few
@given(
    numbers=SMALL,
    off=vectors(6, -1.0, 1.0),
    size=st.sampled_from([0.1, 0.2, 1.0, 10.0]),
    known=st.sampled_from([1.0, 1e-4]),
    missing=MISSING,
    ago=st.sampled_from([0.01, 0.2]),
    agreed=st.sampled_from([0.05, 0.2]),
    moved=st.sampled_from([None, 1.0, 3.0]),
    believed=st.sampled_from([np.inf, 1.5, 3.5]),
    grown=st.sampled_from([1.0, 3.0]),
    left_out=st.booleans(),
)
def test_seen(kind, surprised, numbers, off, size, known, missing, ago, agreed, moved, believed, grown, left_out):
    """`known` so well that what surprises may be a push, or one that is over; the last calm sample was so long ago. The
    last velocity that was as believed came so long ago; for as long the source of poses seems to have moved, and what
    was believed before was `believed`; poses are so many times as far off by now; and velocities may be left out."""
    of = observer(kind, "drags")
    seen = drawn(of, numbers)[0]
    jumped = np.append(size / grown * np.sqrt(known) * off[:3], [np.inf if moved is None else seen.time - moved])
    source = np.append(jumped, [seen.time - agreed, seen.time - believed, left_out])
    seen = replace(seen, surprised=surprised, calm=seen.time - ago, source=source)
    seen = replace(seen, belief=Gaussian(seen.belief.mean, known * seen.belief.covariance))
    off = np.append(np.sqrt(known) * off[:3], off[3:])
    k, mean, to_free = seen.k, seen.belief.mean, np.linalg.pinv(of.cart.basis_b) @ body_to_world(numbers[2]).T
    pose = mean[:3] + size * off[:3]
    velocity = np.linalg.pinv(to_free) @ (mean[3 : 3 + k] + size * off[3 : 3 + k])
    for i in missing:
        (pose if i < 3 else velocity)[i % 3] = np.nan
    residual = np.append(size * off[:3] + 0.0 * pose, to_free @ velocity - mean[3 : 3 + k])
    residual[2] = (residual[2] + np.pi) % (2 * np.pi) - np.pi
    R = 1e-12 * np.eye(3 + k)
    R[:3, :3] += NOISE.pose_covariance
    R[3:, 3:] += to_free @ NOISE.velocity_covariance @ to_free.T
    told = np.isfinite(residual)
    found = of.seen(seen, pose, velocity)
    if told[3:].all():
        P, own = seen.belief.covariance, np.s_[3 : 3 + k]
        free = residual[3:] @ np.linalg.solve(P[own, own] + R[3:, 3:] + MIN_ROW_VARIANCE * np.eye(k), residual[3:])
        in_b = body_to_world(mean[2]).T @ velocity
        sideways = (in_b - of.cart.basis_b @ np.linalg.pinv(of.cart.basis_b) @ in_b)[:2]
        most = MAX_DRIFT_SPEED + 6.0 * np.sqrt(np.trace(NOISE.velocity_covariance[:2, :2]))
        agreed = 0.0 if free <= SURPRISE_CHI2 and np.linalg.norm(sideways) < most else np.inf
        jumps = np.linalg.norm((velocity - body_to_world(mean[2]) @ of.cart.basis_b @ mean[3 : 3 + k])[:2])
        if told.all() and agreed > 0.0 and jumps > MAX_PUSH_ACCELERATION * ago:
            event("its velocity jumps")
            S = P[:3, :3] + R[:3, :3] + MIN_ROW_VARIANCE * np.eye(3)
            left_out |= residual[:3] @ np.linalg.solve(S, residual[:3]) <= SURPRISE_CHI2
        left_out = left_out and agreed > 0.0
        told[3:] &= not left_out
    if not told.any():
        assert found is seen
        return
    H, R, residual, belief = np.eye(3 + k, 3 + 2 * k)[told], R[np.ix_(told, told)], residual[told], seen.belief
    floor = MIN_ROW_VARIANCE * np.eye(len(R))  # which kernels put under what they factorise
    square = innovation(belief, residual, H, R + floor).nis
    if abs(square - SURPRISE_CHI2) < 1e-6:
        return  # rounding decides
    now = surprised + 1 if square > SURPRISE_CHI2 else 0
    is_elsewhere = now > 0 and told[:3].all() and agreed < MAX_VELOCITY_AGE and not left_out
    tolerance = 6.0 * np.sqrt(2.0 * np.diag(NOISE.pose_covariance))
    far, jump = max(np.hypot(*jumped[:2]), abs(jumped[2])), np.zeros(3)
    if is_elsewhere:
        jump = residual[:3] - jumped[:3]
        jump[2] = (jump[2] + np.pi) % (2 * np.pi) - np.pi
    quick = moved is not None and (np.abs(jump) >= MAX_RELOCALISATION_SPEED * moved + tolerance).any()
    if is_elsewhere and moved is not None and (np.abs(jump) >= far + tolerance).any() and not quick:
        event("it goes on to go elsewhere")
        told, is_elsewhere = told & (np.arange(3 + k) < 3), False
        H, R, residual = H[:3], R[:3, :3], residual[:3]
        floor = MIN_ROW_VARIANCE * np.eye(3)
        square = innovation(belief, residual, H, R + floor).nis
        assert found.source[6] == 1.0
    if is_elsewhere:
        event("its source has moved")
        lasted = moved is not None and moved > min(MIN_MOVED_SOURCE_DURATION, believed - moved)
        if lasted and (np.abs(jump) < MAX_DRIFT_SPEED * moved + tolerance).all():
            assert found.surprised == 0
            assert np.array_equal(found.belief.mean[:3], pose)
            np.testing.assert_allclose(found.belief.covariance[:3, :3], NOISE.pose_covariance)
            assert not found.belief.covariance[:3, 3:].any()
            turned = np.linalg.pinv(of.cart.basis_b) @ body_to_world(pose[2]).T @ velocity
            nu = turned if np.isfinite(velocity).all() else mean[3 : 3 + k]
            np.testing.assert_allclose(found.belief.mean[3 : 3 + k], nu, atol=1e-9)
            assert np.array_equal(found.belief.mean[3 + k :], mean[3 + k :])
            return
        H, R, residual, square = H[3:], R[3:, 3:], residual[3:], 0.0  # the velocity alone
    elif now > 1:
        P, since, stronger = belief.covariance.copy(), max(now * MAX_OBSERVER_STEP, ago), 2.0 ** min(now - 2, 5)
        usual = np.diag((stronger * PUSH_FORCE_STD * NOISE.wrench_scale(of.cart)) ** 2 + mean[3 + k :] ** 2)
        moments = [[since**2 / 3, since / 2], [since / 2, 1.0]]  # of nu' for a while, and of d
        to_nu = np.diag(1.0 / of._inertias)
        lever = np.block([[to_nu, np.zeros((k, k))], [np.zeros((k, k)), np.eye(k)]])
        P[3:, 3:] += lever @ np.kron(moments, usual) @ lever.T
        ways = np.linalg.pinv(of.cart.basis_b)
        ways = ways / np.square(ways).sum(axis=1, keepdims=True)
        squares = np.diagonal(to_nu @ usual @ to_nu) @ np.square(ways)
        P[np.arange(3), np.arange(3)] += since**4 / 20 * np.array([squares[0] + squares[1]] * 2 + [squares[2]])
        opened = Gaussian(belief.mean, P)
        if innovation(opened, residual, H, R + floor).nis <= SURPRISE_CHI2:
            belief, now, square = opened, 1, 0.0
            event("explained by a push")
    news = innovation(belief, residual, H, R)
    wider = max(1.0, square / SURPRISE_CHI2)
    R = R + (wider - 1.0) * news.covariance
    expected = updated(belief, innovation(belief, residual, H, R), H, R)
    scale = np.abs(expected.covariance).max()
    assert found.surprised == now
    goes_on = now > 1 or (now == 1 and surprised == 0)
    assert found.calm == (seen.calm if goes_on else seen.time)
    np.testing.assert_allclose(found.belief.mean, expected.mean, rtol=1e-6, atol=1e-7)
    np.testing.assert_allclose(found.belief.covariance, expected.covariance, rtol=1e-5, atol=1e-8 * scale)


@pytest.mark.parametrize(("kind", "what"), CASES)
@few
@given(numbers=SMALL, is_told=st.booleans())
def test_squares(kind, what, numbers, is_told):
    of = observer(kind, what)
    seen, memory, theta = drawn(of, numbers)
    cart, k, p = of.cart, seen.k, len(theta)
    root = 0.03 * theta * np.random.default_rng(p).normal(size=(p, p)).T
    unknown = root.T @ root if is_told else None
    squares, covariance = of.squares(seen, memory, theta, unknown)
    state, lift, d = seen.state(memory), cart.planar_wrench(np.eye(k)).T, seen.wrench
    alone, whole = (
        cart.state_rate(state, lift @ given, theta, seen.time)[cart.velocity_slice]
        for given in (seen.given, seen.given + d.mean)
    )
    same = np.where(alone * whole > 0, np.sign(alone) * np.minimum(np.abs(alone), np.abs(whole)), 0.0)
    expected, S = [], cart.basis_b
    for nu_rate in (np.zeros(k), same, whole):
        by = cart.inverse(state, nu_rate, theta, seen.time).by_parameters
        known = d.covariance + (by @ unknown @ by.T if is_told else 0.0)
        load = load_covariance(cart, Prior(), theta[0])
        expected.append(d.mean @ np.linalg.solve(known + by @ load @ by.T, d.mean))
        rigid = S.T @ regressor_b(S @ state[3 : 3 + k], S @ nu_rate)
        alone_by_mass = d.mean @ np.linalg.solve(known + rigid @ load[:4, :4] @ rigid.T, d.mean)
        expected.append(alone_by_mass)
    np.testing.assert_allclose(squares, [expected[0], expected[2], expected[3]], rtol=1e-5, atol=1e-9)
    np.testing.assert_allclose(covariance, known, rtol=1e-8, atol=1e-12)


@given(push=st.floats(150.0, 400.0), sign=st.sampled_from([-1.0, 1.0]))
@few
def test_a_push_that_is_over_is_let_go_however_strong_it_was(push, sign):
    """It is many deviations of what may set in, and the cart that it was believed to push stands still."""
    of = observer("axle ahead", "drags")
    memory = np.zeros(len(of.cart.memory_names))
    seen = of.start(0.0, np.zeros(3))
    covariance = np.diag([*np.diagonal(seen.belief.covariance)[:3], 1e-5, 1e-5, 36.0, 4.0])
    seen = of.pushed(
        replace(seen, belief=Gaussian(np.array([0, 0, 0, 0, 0, sign * push, 0]), covariance)), np.zeros(2), np.eye(2)
    )
    for i in range(1, 11):
        seen = of.seen(of.advanced(seen, 0.01 * i, memory, of.cart.parameters), np.zeros(3), np.zeros(3))
    assert np.abs(seen.wrench.mean[0]) < 3.0 * np.sqrt(seen.wrench.covariance[0, 0])
