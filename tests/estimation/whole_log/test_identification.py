"""`identify` on logs made by the tests' own equations: unbiased, honest, and physical."""

from dataclasses import replace

import numpy as np
import pytest

from cartgrasp.constraints import RollingConstraints
from cartgrasp.effects import ForceBias, RollingResistance, ViscousDrag
from cartgrasp.errors import DataError, UsageError
from cartgrasp.inertia import Inertia
from cartgrasp.logs import ArmLog, RunLog
from cartgrasp.model import CartModel
from estimation import Prior
from estimation.whole_log.identification import identify

from ..runs import simulate, simulate_two_hands

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


@pytest.mark.long
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


@pytest.mark.long
def test_a_straight_push_teaches_neither_com_x_nor_inertia():
    truth = (24.0, 0.28, 0.0, 2.2, 3.0, 1.2, 0.02)
    log, _ = simulate(truth, 4, curved=False, noise=(0.0004, 0.005, 1.0))
    found = identify([log], guess()).parameters
    assert found["mass"].identifiable
    assert abs(found["mass"].value - 24.0) < 4 * found["mass"].std
    for name in ("com_x", "inertia"):
        assert not found[name].identifiable
        assert found[name].std > 0.5 * Prior().deviations(guess())[NAMES.index(name)]


@pytest.mark.long
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


def test_wrenches_beyond_reason_are_refused_with_their_place():
    log = drawn(1.0, 3)
    hand = log.arms["hand"]
    with pytest.raises(DataError, match=r"the wrench of arm hand at t = .* is beyond"):
        identify([replace(log, arms={"hand": ArmLog(hand.contact, 1e300 * hand.wrench)})], guess())


@pytest.mark.parametrize("rows", [[0], [0, 400, 800]])
def test_single_rows_return_the_prior(rows):
    """Alone, or seconds apart: no two tell how fast rows come."""
    log, cart = drawn(0.0, 0), guess()
    arms = {name: ArmLog(arm.contact[rows], arm.wrench[rows]) for name, arm in log.arms.items()}
    few = replace(log, time=log.time[rows], pose=log.pose[rows], velocity=log.velocity[rows], arms=arms)
    found = identify([few], cart)
    assert found.parameters["mass"].value == pytest.approx(cart.inertia.mass)
    assert "rows have a pose" in found.logs[0].words[0]


@pytest.mark.long
@pytest.mark.some(1)
@pytest.mark.parametrize("column", [0, 1, 2])
def test_a_velocity_without_samples_in_one_column(column):
    log = drawn(1.0, 3)
    velocity = log.velocity.copy()
    velocity[:, column] = np.nan
    found = identify([replace(log, velocity=velocity)], guess())
    assert np.abs(scores(found)).max() < 4.0
    whole, mass = identify([log], guess()).parameters["mass"], found.parameters["mass"]
    assert abs(mass.value - whole.value) < 0.5 * mass.std < 0.5


@pytest.mark.long
def test_what_is_known_stays():
    found = identify([drawn(1.0, 3)], guess(), Prior(known=frozenset({"viscous_drag"})))
    drag = found.parameters["viscous_drag.linear"]
    assert (drag.value, drag.std, drag.identifiable) == (2.0, 0.0, False)


@pytest.mark.long
def test_an_untared_sensor_is_found():
    log = drawn(1.0, 7)
    hand = log.arms["hand"]
    log = replace(log, arms={"hand": ArmLog(hand.contact, hand.wrench + np.array([2.0, 0, 0, 0, 0, 0.4]))})
    found = identify([log], guess().with_effect(ForceBias(label="hand")))
    bias = found.parameters["force_bias.hand.fx"]
    assert abs(bias.value - 2.0) < 4 * bias.std
    assert bias.identifiable
    assert abs(found.parameters["mass"].value - 24.0) < 4 * found.parameters["mass"].std


@pytest.mark.long
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


@pytest.mark.long
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


@pytest.mark.long
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
