"""The online filter on logs made by the tests' own equations: consistent, honest, and hard to break."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import chi2

from cartgrasp.constraints import RollingConstraints
from cartgrasp.effects import CasterRealignment, ForceBias, RollingResistance, ViscousDrag
from cartgrasp.errors import UsageError
from cartgrasp.inertia import Inertia, physical_from_phi
from cartgrasp.model import CartModel
from cartgrasp.motion import Measurement
from cartgrasp.wheels import Wheel
from estimation import CartFilter, FilterNoise, PaperFilter, Prior, RegressorEstimator
from estimation.gaussian import Gaussian
from estimation.whole_log.replay import replay

from ..runs import CONTACT, simulate, simulate_two_hands

TRUTH = (24.0, 0.28, 0.06, 2.2, 3.0, 1.2, 0.0)
WITH_COULOMB = (*TRUTH[:-1], 0.02)
NAMES = ("mass", "com_x", "com_y", "inertia")
DRAG = (ViscousDrag(linear=3.0, angular=1.2),)
NARROW = Prior(0.15, 0.06, 0.2, known=frozenset({"viscous_drag"}))
KNOWN = Prior(known=frozenset({"viscous_drag"}))
NOISE = FilterNoise(0.0004, 0.0004, 0.005, 0.005, 0.0, 0.0, disturbance=0.02, slip=0.00005)

ONLINE = pytest.mark.parametrize("online", [CartFilter, RegressorEstimator])
"""Both sit the same exam."""


def guess(mass=20.0, com=(0.3, 0.0), inertia=1.8, effects=DRAG):
    return CartModel(Inertia(mass, com, inertia), effects=effects)


def drawn_guess(seed, prior):
    """A first guess drawn from the prior around the truth, as NEES needs."""
    random = np.random.default_rng(1000 + seed)
    m, dx, dy, inertia = TRUTH[:4]
    return guess(
        mass=m * (1 + prior.mass * float(random.standard_normal())),
        com=(dx + prior.com * float(random.standard_normal()), dy + prior.com * float(random.standard_normal())),
        inertia=inertia * (1 + prior.inertia * float(random.standard_normal())),
    )


def errors(log, truth, estimator, every=50):
    """NEES over (motion, mass, CoM, inertia) and NIS sums, at some steps."""
    nees, nis = [], []
    for i, measurement in enumerate(log.measurements()):
        estimate = estimator.update(measurement)
        if i % every == every - 1:
            motion = np.concatenate([estimate.motion.pose_sb, estimate.motion.velocity]) - truth[i]
            covariance = estimator.belief.covariance[:5, :5]
            nees.append(motion @ np.linalg.solve(covariance, motion))
            nis.append(sum(value for sensor, (value, _) in estimator.nis.items() if sensor != "wrench"))
    return np.array(nees), np.array(nis), estimate


def consistency(truth_cart, runs, seed=0):
    nees, nis, scores = [], [], []
    for run in range(seed, seed + runs):
        log, truth = simulate(truth_cart, run)
        first = drawn_guess(run, NARROW)
        a, b, last = errors(log, truth, CartFilter(first, ["hand"], noise=NOISE, prior=NARROW))
        nees.append(a)
        nis.append(b)
        learned = [last.parameters[name] for name in NAMES]
        scores.append([(p.value - v) / p.std for p, v in zip(learned, TRUTH[:4], strict=True)])
    return np.mean(nees, axis=0), np.mean(nis, axis=0), np.array(scores)


def share_inside(values, dimension, runs):
    low, high = chi2.ppf([0.025, 0.975], dimension * runs) / runs
    return np.mean((values >= low) & (values <= high)), np.mean(values <= high)


@pytest.mark.long
def test_consistent_over_many_runs():
    """Mean NEES of the motion and NIS stay in their 95 % band, and parameters within their own deviations."""
    runs = 8
    nees, nis, scores = consistency(TRUTH, runs)
    assert share_inside(nees, 5, runs)[1] >= 0.9
    assert share_inside(nis, 5, runs)[0] >= 0.8
    assert np.abs(scores).max() < 4.0
    assert np.sqrt((scores**2).mean()) < 1.3


@pytest.mark.long
def test_a_wrong_model_fails_the_same_test():
    """Rolling resistance is in the data and not in the model."""
    _, nis, scores = consistency(WITH_COULOMB, 2)
    inside, _ = share_inside(nis, 5, 2)
    assert inside < 0.8 or np.abs(scores).max() > 4.0


def test_nothing_is_learned_below_the_least_speed():
    """A gate above the log's speeds leaves the first guess alone; one below them all but the starts."""
    log, truth = simulate(TRUTH, 5, duration=4.0)
    fast = np.abs(truth[:, 3]).max()
    gated = replay(log, CartFilter(guess(), ["hand"], noise=NOISE, prior=KNOWN, least_speed=1.01 * fast + 0.1)).last
    assert gated.parameters["mass"].value == pytest.approx(20.0)
    assert gated.motion.velocity == pytest.approx(truth[-1, 3:], abs=0.02)
    some = replay(log, CartFilter(guess(), ["hand"], noise=NOISE, prior=KNOWN, least_speed=0.05)).last
    every = replay(log, CartFilter(guess(), ["hand"], noise=NOISE, prior=KNOWN, least_speed=1e-6)).last
    assert every.parameters["mass"].std < some.parameters["mass"].std < 0.2 * gated.parameters["mass"].std
    assert some.parameters["mass"].value == pytest.approx(24.0, rel=0.02)


@pytest.mark.prove
def test_consistent_over_500_runs():
    runs = 500
    _, nis, scores = consistency(TRUTH, runs)
    assert share_inside(nis, 5, runs)[1] >= 0.5
    assert np.abs(scores.mean(axis=0)).max() < 0.2
    assert np.sqrt((scores**2).mean()) < 1.15


@ONLINE
def test_learns_the_load_and_the_drags(online):
    log, _ = simulate(WITH_COULOMB, 3, duration=18.0, noise=(0.0004, 0.005, 0.3))
    cart = guess(effects=(ViscousDrag(linear=1.0, angular=0.5), RollingResistance(coefficient=0.01)))
    noise = replace(NOISE, force=0.3, moment=0.015, disturbance=0.1)
    last = replay(log, online(cart, ["hand"], noise=noise)).last
    assert last.parameters["mass"].value == pytest.approx(24.0, rel=0.02)
    assert last.parameters["com_x"].value == pytest.approx(0.28, abs=0.02)
    assert last.parameters["com_y"].value == pytest.approx(0.06, abs=0.01)
    assert last.parameters["inertia"].value == pytest.approx(2.2, rel=0.1)
    assert last.parameters["rolling_resistance.coefficient"].value == pytest.approx(0.02, abs=0.003)
    assert all(last.parameters[name].identifiable for name in NAMES)
    assert last.health == "ok"


@ONLINE
def test_a_straight_push_teaches_neither_com_x_nor_inertia(online):
    """d/d(com_x) and d/dJ of the equations vanish where r = 0 and r' = 0 (physics.md)."""
    cart = (24.0, 0.28, 0.0, 2.2, 3.0, 1.2, 0.0)
    log, _ = simulate(cart, 4, curved=False)
    last = replay(log, online(guess(), ["hand"], noise=NOISE, prior=KNOWN)).last
    assert last.parameters["mass"].value == pytest.approx(24.0, rel=0.01)
    assert last.parameters["mass"].identifiable
    assert last.parameters["com_y"].value == pytest.approx(0.0, abs=0.01)
    for name in ("com_x", "inertia"):
        assert not last.parameters[name].identifiable
        assert abs(last.parameters[name].value - {"com_x": 0.28, "inertia": 2.2}[name]) < 3 * last.parameters[name].std


@pytest.mark.long
@pytest.mark.some(1)
@ONLINE
def test_noisy_forces_do_not_inflate_the_mass(online):
    """3 N of noise: taken as exact inputs they bias the mass by kilograms (physics.md)."""
    noise = replace(NOISE, force=3.0, moment=0.15, disturbance=0.05)
    scores = []
    for seed in range(4):
        log, _ = simulate(TRUTH, seed, duration=18.0, noise=(0.0004, 0.005, 3.0))
        mass = replay(log, online(guess(), ["hand"], noise=noise, prior=KNOWN)).last.parameters["mass"]
        assert mass.value == pytest.approx(24.0, abs=1.5)
        scores.append((mass.value - 24.0) / mass.std)
    assert abs(np.mean(scores)) < 1.5


@pytest.mark.long
@ONLINE
@pytest.mark.parametrize("seed", [0, pytest.param(1, marks=pytest.mark.prove)])
def test_two_noisy_hands_under_feedback(seed, online):
    """4 N of noise on a push of 6 N (rms): once 5-6 % too heavy, and 20 % too much inertia."""
    noise = replace(NOISE, force=3.0, moment=0.15, disturbance=0.06)
    log = simulate_two_hands(TRUTH, seed)
    found = replay(log, online(guess(), ["left", "right"], noise=noise)).last.parameters
    assert found["mass"].value == pytest.approx(24.0, rel=0.04)
    assert abs(found["mass"].value - 24.0) < 3 * found["mass"].std
    assert abs(found["com_y"].value - 0.06) < 3 * found["com_y"].std


@pytest.mark.some(2)
@pytest.mark.long
@ONLINE
@pytest.mark.parametrize("coulomb", [0.02, 0.03])
def test_from_rest_with_a_friction_underestimated(coulomb, online):
    """Guesses that are no body, on the way, once ended with a mass half as large again."""
    noise = replace(NOISE, force=1.0, moment=0.05, disturbance=0.06)
    log = simulate_two_hands((*TRUTH[:-1], coulomb), 0, noise=(0.0005, 0.005, 1.0))
    believed = guess(effects=(ViscousDrag(2.0, 1.0), RollingResistance(0.005)))
    found = replay(log, online(believed, ["left", "right"], noise=noise)).last.parameters
    assert found["mass"].value == pytest.approx(24.0, rel=0.03)
    assert found["rolling_resistance.coefficient"].value == pytest.approx(coulomb, rel=0.1)


@pytest.mark.long
def test_the_papers_literal_form_fails_where_the_filter_does_not():
    log, _ = simulate(TRUTH, 5, noise=(0.005, 0.005, 0.0))
    noise = replace(NOISE, position=0.005, heading=0.005)
    literal = replay(log, PaperFilter(guess(), ["hand"], noise=noise)).last
    sound = replay(log, CartFilter(guess(), ["hand"], noise=noise, prior=KNOWN)).last
    wrong = abs(literal.parameters["com_x"].value - 0.28)
    assert (
        literal.health == "diverged"
        or wrong > 0.05
        or literal.parameters["mass"].std < 0.3 * abs(literal.parameters["mass"].value - 24.0)
    )
    assert abs(sound.parameters["com_x"].value - 0.28) < 0.02


@pytest.mark.long
@ONLINE
def test_a_load_put_on_is_noticed_and_learned(online):
    before, _ = simulate(TRUTH, 6, duration=12.0)
    after, _ = simulate((32.0, 0.28, 0.06, 2.2, 3.0, 1.2, 0.0), 7, duration=12.0)
    estimator = online(guess(), ["hand"], noise=NOISE, prior=KNOWN)
    assert replay(before, estimator).last.parameters["mass"].value == pytest.approx(24.0, rel=0.02)
    later = replace(after, time=after.time + 12.0 + 2.0)
    assert replay(later, estimator).last.parameters["mass"].value == pytest.approx(32.0, rel=0.05)


@pytest.mark.long
@ONLINE
@pytest.mark.parametrize("seed", [0, *(pytest.param(seed, marks=pytest.mark.prove) for seed in (1, 2))])
def test_survives_what_sensors_do(seed, online):
    """Drop-outs, NaN, outliers, repeated and backward times, a gap: no NaN, a sound covariance, mass still right."""
    log, _ = simulate(TRUTH, 20 + seed, duration=18.0)
    random = np.random.default_rng(seed)
    estimator = online(guess(), ["hand"], noise=NOISE, prior=KNOWN)
    for i, m in enumerate(log.measurements()):
        kind = random.integers(0, 12)
        if kind == 0:
            m = replace(m, pose=None)
        elif kind == 1:
            m = replace(m, velocity=np.array([np.nan, 0.0, 0.0]))
        elif kind == 2:
            m = replace(m, wrenches={})
        elif kind == 3 and i > 200:
            m = replace(m, pose=m.pose + np.array([5.0, 0.0, 0.0]))
        elif kind == 4:
            assert estimator.update(replace(m, time=m.time - 1.0)).health == "clock_went_back" or i == 0
        if 900 <= i < 1000:
            m = Measurement(m.time)
        estimate = estimator.update(m)
        estimator.update(Measurement(m.time))
        assert np.isfinite(estimator.belief.mean).all()
    assert np.linalg.eigvalsh(estimator.belief.covariance).min() > -1e-9
    assert estimate.parameters["mass"].value == pytest.approx(24.0, rel=0.1)


@pytest.mark.some(4)
@ONLINE
@pytest.mark.parametrize("gap", [0.2, 0.36, 0.5, 0.6, 1.0])
def test_wrenches_alone_tell_no_load(gap, online):
    """Where nobody saw the motion, nothing of it is known."""
    log = simulate_two_hands(TRUTH, 5, duration=20.0)
    noise = FilterNoise(0.0005, 0.0005, 0.005, 0.005, force=3.0, moment=0.05)
    estimator, found = online(guess(), noise=noise, prior=KNOWN), []
    for sample in log.measurements():
        is_unseen = 6.0 <= sample.time < 6.0 + gap
        found.append(
            estimator.update(
                Measurement(sample.time, None, None, sample.wrenches, sample.contacts) if is_unseen else sample
            )
        )
    assert not {one.health for one in found} & {"load_changed", "inconsistent"}
    for one in found[700::100]:
        for name, true in zip(NAMES, TRUTH, strict=False):
            assert abs(one.parameters[name].value - true) < 4.5 * one.parameters[name].std


@ONLINE
def test_no_wrench_is_said(online):
    estimator = online(guess(), ["hand"])
    estimate = estimator.update(Measurement(0.0, np.zeros(3), np.zeros(3)))
    assert estimate.health == "no_wrench"
    assert estimate.parameters["mass"].value == pytest.approx(20.0)
    assert not estimate.parameters["mass"].identifiable


@ONLINE
def test_a_time_that_is_not_finite_is_refused(online):
    with pytest.raises(UsageError, match="time"):
        online(guess()).update(Measurement(np.nan, np.zeros(3)))


@ONLINE
def test_a_rail_learns_its_mass_alone(online):
    cart = CartModel(Inertia(60.0, (0, 0), 1.0), RollingConstraints(no_rotation=True), (ViscousDrag(linear=50.0),))
    estimator = online(cart, ["hand"], noise=replace(NOISE, position=1e-4))
    x = u = 0.0
    for k in range(1500):
        force = 200.0 * np.sin(2 * np.pi * k / 300)
        pose = np.array([x, 0.0, 0.0])
        wrench = np.array([force, 0, 0, 0, 0, 0.0])
        estimate = estimator.update(Measurement(k * 0.01, pose, None, {"hand": wrench}, {"hand": np.zeros(3)}))
        for _ in range(10):
            u += 0.001 * (force - 80.0 * u) / 95.0
            x += 0.001 * u
    assert estimate.parameters["mass"].value == pytest.approx(95.0, rel=0.01)
    assert estimate.parameters["viscous_drag.linear"].value == pytest.approx(80.0, rel=0.02)
    assert not any(estimate.parameters[name].identifiable for name in ("com_x", "com_y", "inertia"))


def test_on_a_rail_com_and_inertia_go_with_the_mass():
    """Nothing tells of them; a cart of 5 kg with the first moment of one of 20 is no body, and had ended a loop."""
    cart = CartModel(Inertia(20.0, (0.25, 0.0), 2.0), RollingConstraints(no_rotation=True), (ViscousDrag(3.0, 1.2),))
    learned = CartFilter(cart).update(Measurement(0.0, np.zeros(3)))
    lighter = learned._replace(model_parameters=np.array([5.0, *cart.parameters[1:4], 4.0, 1.2])).cart()
    assert lighter.inertia.mass == 5.0
    assert tuple(lighter.inertia.com) == pytest.approx((0.25, 0.0))
    assert lighter.inertia.about_com == pytest.approx(0.5)
    assert lighter.effects[0].linear == 4.0


@ONLINE
def test_a_cart_on_casters_learns_all_four(online):
    """No rolling constraint: Newton-Euler of a free planar body, integrated here."""
    m, d, inertia = 80.0, np.array([0.1, -0.05]), 14.0
    cart = CartModel(Inertia(60.0, (0.0, 0.0), 10.0), RollingConstraints(axle_x=None))
    estimator = online(cart, ["hand"], noise=replace(NOISE, position=1e-4, heading=1e-4))
    origin, theta, velocity, r = np.zeros(2), 0.0, np.zeros(2), 0.0
    random = np.random.default_rng(0)
    for k in range(1200):
        t = k * 0.01
        force_b = np.array([40 * np.sin(1.3 * t), 30 * np.sin(0.9 * t + 1)])
        tau = 12 * np.sin(1.7 * t)
        turned = np.array([[np.cos(theta), -np.sin(theta)], [np.sin(theta), np.cos(theta)]])
        pose = np.array([*origin, theta]) + 1e-4 * random.standard_normal(3)
        sensed = np.array([*velocity, r]) + 0.005 * random.standard_normal(3)
        wrench = np.array([*force_b, 0, 0, 0, tau])
        estimate = estimator.update(Measurement(t, pose, sensed, {"hand": wrench}, {"hand": np.zeros(3)}))
        for _ in range(10):
            turned = np.array([[np.cos(theta), -np.sin(theta)], [np.sin(theta), np.cos(theta)]])
            arm = turned @ d
            force = turned @ force_b
            alpha = (tau - (d[0] * force_b[1] - d[1] * force_b[0])) / inertia
            com_acceleration = force / m
            acceleration = com_acceleration - alpha * np.array([-arm[1], arm[0]]) + r**2 * arm
            origin, theta = origin + 0.001 * velocity, theta + 0.001 * r
            velocity, r = velocity + 0.001 * acceleration, r + 0.001 * alpha
    expected = {"mass": m, "com_x": d[0], "com_y": d[1], "inertia": inertia}
    for name, value in expected.items():
        assert estimate.parameters[name].value == pytest.approx(value, rel=0.03, abs=0.01)
        assert estimate.parameters[name].identifiable


@pytest.mark.long
@ONLINE
def test_a_sensor_offset_is_learned_on_the_way(online):
    log, _ = simulate(TRUTH, 9, duration=18.0, noise=(0.0004, 0.005, 0.1))
    arm = log.arms["hand"]
    shifted = replace(log, arms={"hand": replace(arm, wrench=arm.wrench + np.array([2.0, 0, 0, 0, 0, 0.4]))})
    cart = guess(effects=(ViscousDrag(linear=3.0, angular=1.2), ForceBias()))
    noise = replace(NOISE, force=0.1, moment=0.005)
    level = replace(KNOWN, slope=0.0)  # on a slope, an offset is told by turning round
    last = replay(shifted, online(cart, ["hand"], noise=noise, prior=level)).last
    assert last.parameters["force_bias.fx"].value == pytest.approx(2.0, abs=0.3)
    tz, fy = last.parameters["force_bias.tz"], last.parameters["force_bias.fy"]
    assert tz.value + CONTACT[0] * fy.value == pytest.approx(0.4, abs=0.1), "one contact: only their sum acts"
    assert not any(offset.identifiable for offset in (tz, fy))
    assert last.parameters["mass"].value == pytest.approx(24.0, rel=0.02)


@ONLINE
def test_an_unknown_name_in_the_prior_is_refused(online):
    with pytest.raises(UsageError, match="weight"):
        online(guess(), prior=Prior(known=frozenset({"weight"})))


@pytest.mark.parametrize("torque", [0.05, 0.1, 0.4, 0.8])
@pytest.mark.parametrize("smoothing", [0.05, 0.1, 0.2])
def test_a_caster_believed_turned_round_is_not_believed_for_long(torque, smoothing):
    """A heading against the way is an equilibrium too, and no force tells it from the stable one. With no moment at all
    round-off decides the sign of its variance, and a moment that is no more than round-off is not trusted."""
    casters, wheels = CasterRealignment(torque, smoothing_rate=smoothing), (Wheel("caster", 0.7, 0.0, 0.05),)
    cart = CartModel(Inertia(24.0, (0.3, 0.0), 2.0), effects=(casters,), wheels=wheels)
    watching = CartFilter(cart, ["hand"], noise=NOISE)
    for i in range(300):
        watching.update(Measurement(0.01 * i, np.array([0.005 * i, 0.0, 0.0]), np.array([0.5, 0.0, 0.0])))
        if i == 100:
            belief = watching.belief
            mean, covariance = belief.mean.copy(), belief.covariance.copy()
            mean[cart.memory_slice], covariance[cart.memory_slice, cart.memory_slice] = np.pi, 1e-6
            watching._core._belief = Gaussian(mean, covariance)
    heading = watching.belief.mean[cart.memory_slice][0]
    assert abs(np.angle(np.exp(1j * heading))) < 0.2


def test_the_covariance_of_the_model_parameters():
    """Of phi and effects: brought to mass, CoM and inertia by differences, it is what is reported of each."""
    log, _ = simulate(TRUTH, 3, duration=6.0)
    estimator = CartFilter(guess(), ["hand"], noise=NOISE)
    for measurement in log.measurements():
        estimate = estimator.update(measurement)
    theta, covariance = estimate.model_parameters, estimate.covariance
    assert covariance.shape == (6, 6)
    steps = 1e-6 * np.eye(4)
    slopes = [(physical_from_phi(theta[:4] + h) - physical_from_phi(theta[:4] - h)) / 2e-6 for h in steps]
    std = np.sqrt(np.diag(np.array(slopes).T @ covariance[:4, :4] @ np.array(slopes)))
    assert std == pytest.approx([estimate.parameters[name].std for name in NAMES], rel=1e-5)
    drags = ("viscous_drag.linear", "viscous_drag.angular")
    assert np.sqrt(np.diag(covariance)[4:]) == pytest.approx([estimate.parameters[n].std for n in drags])
    assert np.linalg.eigvalsh(covariance).min() > -1e-12
    known = CartFilter(guess(), ["hand"], noise=NOISE, prior=KNOWN)
    for measurement in log.measurements():
        estimate = known.update(measurement)
    assert not estimate.covariance[4:].any()


@pytest.mark.parametrize("force", [0.0, 3.0])
def test_a_first_pose_is_as_good_as_its_sensor(force):
    """Of position and of heading, by the EKF and by the filter for noisy wrenches."""
    noise = FilterNoise(position=0.003, heading=0.02, force=force)
    estimator = CartFilter(guess(), ["hand"], noise=noise)
    estimator.update(Measurement(0.0, pose=[1.0, 2.0, 0.3]))
    std = np.sqrt(np.diagonal(estimator.belief.covariance)[:3])
    assert std == pytest.approx([0.003, 0.003, 0.02], rel=1e-6)
