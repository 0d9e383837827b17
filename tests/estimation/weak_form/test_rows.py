"""What rows are whitened by: where dry friction is known least, and how much forms and white noise explain."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.signal import lfilter
from scipy.sparse import csr_array

from cartgrasp.effects import RollingResistance, WheelDragImbalance
from cartgrasp.model import CartModel
from cartgrasp.wheels import Wheel
from estimation.weak_form.balances import Balances
from estimation.weak_form.rows import DRY_FRICTION_SPEED, Errors, excess_noise, model_error, motion_noise

from .motions import TRUE, cart_of, noisy, weaving

TRACK = (Wheel("fixed", 0.0, 0.3), Wheel("fixed", 0.0, -0.3))


@pytest.fixture(scope="module")
def balances():
    return Balances.of(noisy(weaving(TRUE, 20.0), 3), cart_of(TRUE))


def with_effect(effect):
    cart = cart_of(TRUE)
    return CartModel(cart.inertia, cart.constraints, (*cart.effects, effect), TRACK)


def test_a_wheel_that_stands_drags_nobody_knows_which_way(balances):
    """A right wheel that drags alone, by 10 N at a lever of 0.3 m: where it rolls at less than a fifth of
    `DRY_FRICTION_SPEED`, nearly all of that is open, whatever the cart does; where it rolls fast, and no caster turns
    round, next to nothing."""
    motion = balances.motion
    whole = with_effect(WheelDragImbalance(10.0, -3.0))
    bare = with_effect(WheelDragImbalance(0.0, 0.0))
    more = np.sqrt(np.maximum(model_error(balances, whole)[1] ** 2 - model_error(balances, bare)[1] ** 2, 0.0))
    rolls = np.abs(motion.velocity[:, 0] + 0.3 * motion.velocity[:, 1])
    stands, fast = (
        rolls < DRY_FRICTION_SPEED / 5,
        (rolls > 8 * DRY_FRICTION_SPEED) & (np.abs(motion.velocity[:, 0]) > 0.4),
    )
    assert stands.any()
    assert fast.any()
    assert (more[stands, 0] > 7.0).all()
    assert (more[stands, 1] > 2.0).all()
    away = fast & (
        motion.way - np.maximum.accumulate(np.where(np.abs(motion.velocity[:, 0]) < 0.02, motion.way, 0)) > 1
    )
    assert (more[away] < 0.05 * np.array([10.0, 3.0])).all()


def whole(whiten, k, count):
    """What whitens all rows of all balances, as one matrix (k count, k count), each row as if it counted."""
    unit = np.eye(k * count).reshape(k, count, -1)
    return replace(whiten, counts=np.ones_like(whiten.counts))(unit).reshape(k * count, -1)


def noise_of(balances, excess, form, friction, memory=0.0, seed=0):
    """Raw rows (k, c) of such noise, and their errors."""
    errors, count = Errors.of(balances, with_effect(RollingResistance(0.03))), balances.n_balances(cart_of(TRUE))
    sizes = (
        np.append(np.full(2, size), np.full(count - 2, least))
        for size, least in zip((excess, form, friction, memory), (*LEAST, 0.0), strict=True)
    )
    k, white = len(balances.used), np.random.default_rng(seed).standard_normal(len(balances.used) * count)
    return np.linalg.solve(whole(errors.whitening(*sizes), k, count), white).reshape(k, count), errors


def told_of(balances, *sizes):
    """What is told of rows whose noise is so large: excess, form, friction and memory (2,) of the free directions."""
    left, errors = noise_of(balances, *sizes)
    return [one[:2] for one in excess_noise([(errors, left)], 0.0)[1:]]


LEAST = 1e-6, 0.02, 0.02


def test_forms_explain_no_more_than_there_is(balances):
    """Rows with the sensors' noise alone leave next to nothing for what forms may be wrong by; forces that no sensor
    made are told as white noise of their density."""
    excess, form, *_ = told_of(balances, 1e-6, 0.02, 1.0)
    assert (form < 0.25).all()
    assert (excess < 0.5).all()
    excess, form, *_ = told_of(balances, np.array([20.0, 5.0]), 1.0, 1.0)
    assert excess == pytest.approx([20.0, 5.0], rel=0.2)
    assert form == pytest.approx(1.0)


@pytest.mark.parametrize("true", [0.02, 0.3, 1.0])
def test_rows_tell_how_wrong_friction_is_near_standstill(balances, true):
    """To a factor of two: they are a few, and some count as if it were as wrong as it may be."""
    _, _, friction, _ = told_of(balances, 1e-6, 0.02, true)
    assert (friction > true / 2).all()
    assert (friction < max(2 * true, 0.3)).all()


@pytest.mark.parametrize("true", [0.0, 0.2, 0.4])
def test_rows_tell_what_neighbours_share(balances, true):
    """In the mean of eight logs of 200 rows, each told to 0.1 and never below nought, with a slow force beside, as a
    model lacks one, three times as large as the noise."""
    slow = 3.0 * np.sin(balances.time)[:, None] * [0.3, 0.1, 0.0]
    draws = [noise_of(balances, np.array([2.0, 0.6]), 0.02, 0.02, true, seed) for seed in range(8)]
    found = np.array([excess_noise([(errors, left + slow)], 0.0)[4][:2] for left, errors in draws])
    assert found.mean(axis=0) == pytest.approx(true, abs=0.12)


def aside():
    """Rows of a log whose hand holds 0.4 m beside {b}'s x, with errors whose motion has no noise."""
    log = noisy(weaving(TRUE, 20.0), 3)
    (name, arm), *_ = log.arms.items()
    balances = Balances.of(
        replace(log, arms={name: replace(arm, contact=arm.contact + np.array([0.0, 0.4, 0.0]))}), cart_of(TRUE)
    )
    errors = Errors.of(balances, cart_of(TRUE), compares=True)
    together, *rest = errors.forces
    return balances, replace(errors, forces=(together._replace(motion=0.0 * together.motion), *rest))


def drawn(balances, random, memory=0.0, forward=0.0):
    """Raw rows (k, c) of one draw of its sensor's noise, of which a sample keeps a share (`memory`) of the last one's;
    and of a force that no sensor made, N/√Hz."""
    count = len(balances.motion.time)
    wrench = lfilter([1.0], [1.0, -memory], random.standard_normal((count + 500, 6)), axis=0)[500:]
    wrench *= balances.wrench_densities[0] / balances.motion.step**0.5
    planar = (balances.wrenches.grasps[0] @ wrench[..., None])[..., 0] @ cart_of(TRUE).basis_b
    planar[:, 0] += forward / balances.motion.step**0.5 * random.standard_normal(count)
    return np.pad(balances.integrated(planar), ((0, 0), (0, balances.n_balances(cart_of(TRUE)) - 2)))


@pytest.mark.parametrize("forward", [0.0, 0.06])
def test_a_force_at_a_lever_is_no_second_witness(forward):
    """Noise of a force sensor 0.4 m beside {b}'s x is a moment, too, and what a model is wrong by is not: after
    whitening, forward force and yaw moment are independent, and as loud as they should be; before, they go together."""
    balances, errors = aside()
    none = np.full(balances.n_balances(cart_of(TRUE)), 1e-9)
    whiten = errors.whitening(np.where(np.arange(len(none)) == 0, forward, none), none, none)
    random = np.random.default_rng(0)
    rows = [drawn(balances, random, forward=forward) for _ in range(40)]
    counted = (whiten.counts[:, :2] > 0.99).all(axis=1)
    raw, white = (np.concatenate([one[counted, :2] for one in each]) for each in (rows, map(whiten, rows)))
    assert abs(np.corrcoef(raw.T)[0, 1]) > 0.3
    assert abs(np.corrcoef(white.T)[0, 1]) < 0.05
    assert white.std(axis=0) == pytest.approx(1.0, abs=0.05)


@pytest.mark.parametrize(("memory", "forward", "true"), [(0.0, 0.0, 1.0), (0.6, 0.0, 2.5), (0.0, 0.3, 1.0)])
def test_rows_tell_how_loud_sensors_are(memory, forward, true):
    """Noise of which a sample keeps 0.6 of the last one's has 1 / 0.4 times the root of the density, over a row; what
    is in the forward balance alone is none of a sensor, which would be heard in the other. A mean of eight logs."""
    balances, errors = aside()
    random = np.random.default_rng(1)
    told = [excess_noise([(errors, drawn(balances, random, memory, forward))], 0.0)[0] for _ in range(8)]
    assert np.mean(told) == pytest.approx(true, rel=0.1)


def test_rows_count_where_nothing_holds_the_cart(balances):
    errors = Errors.of(balances, cart_of(TRUE))
    none = np.zeros(balances.n_balances(cart_of(TRUE)))
    counts = errors.whitening(none, none, none).counts
    slow = np.interp(balances.time, balances.motion.time, balances.turning_speed)
    assert (counts[slow > 0.2] > 0.99).all()
    assert (counts >= 0.0).all()
    assert (counts <= 1.0).all()


@given(st.integers(0, 1000))
@settings(max_examples=10, deadline=None)
def test_whitening_its_transpose_and_its_deviations_are_one_matrix(balances, seed):
    random, count = np.random.default_rng(seed), balances.n_balances(cart_of(TRUE))
    errors, k = Errors.of(balances, cart_of(TRUE), compares=True), len(balances.used)
    whiten = errors.whitening(*random.uniform(0.02, 1.0, (3, count)), random.uniform(0.0, 0.5, count))
    x, y = random.standard_normal((2, k, count))
    assert (whiten(x) * y).sum() == pytest.approx((x * whiten.transposed(y)).sum())
    weights, matrix = random.standard_normal((3, k)), np.linalg.inv(whole(whiten, k, count))
    spread = np.einsum("bk,kcj->bcj", weights, matrix.reshape(k, count, -1))
    assert whiten.deviations(csr_array(weights)) == pytest.approx(np.sqrt((spread**2).sum(axis=2)))


@pytest.mark.parametrize("every", [1, 5])
@pytest.mark.parametrize("has_velocity", [False, True])
def test_rows_are_as_loud_as_samples_of_the_motion_are_rare(every, has_velocity):
    """Scatter of what is left of the true cart, by noise of poses, or of velocities, in every row or in every fifth."""
    log, cart = weaving(TRUE, 60.0), cart_of(TRUE)
    log = noisy(log, 1, 1e-3 if not has_velocity else 0.02, 2e-3, 0.0)
    gone = np.arange(len(log.time)) % every != 0
    pose, velocity = (np.where(gone[:, None], np.nan, each) for each in (log.pose, log.velocity))
    balances = Balances.of(replace(log, pose=pose, velocity=velocity if has_velocity else None), cart).every(0.4)
    density, order = motion_noise(balances, cart)
    told = density * balances.overlap(order, 0) ** 0.5
    left = balances.residual(cart)[0][:, :2]
    assert left.std(axis=0) / told == pytest.approx(1.0, rel=0.3)
