"""Samples late, out of order, of sensors with rates of their own, missing or absurd: flagged, and survived."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cartgrasp.constraints import RollingConstraints
from cartgrasp.effects import ContactOffset, ForceMisalignment, ViscousDrag
from cartgrasp.errors import UsageError
from cartgrasp.inertia import Inertia
from cartgrasp.model import CartModel
from cartgrasp.motion import Measurement
from estimation import CartFilter, DisturbedFilter, FilterNoise, Prior, RegressorEstimator
from estimation.health import Health
from estimation.online.late_samples import MAX_SAMPLE_DELAY, LateSamples

from ..runs import integrate, record, simulate, simulate_two_hands

TRUTH = (24.0, 0.28, 0.06, 2.2, 3.0, 1.2, 0.0)
NOISE = FilterNoise(0.0004, 0.0004, 0.005, 0.005, 0.0, 0.0, disturbance=0.02, slip=0.00005)
KNOWN = Prior(known=frozenset({"viscous_drag"}))
ONLINE = pytest.mark.parametrize("online", [CartFilter, RegressorEstimator])


def guess():
    return CartModel(Inertia(20.0, (0.3, 0.0), 1.8), RollingConstraints(), (ViscousDrag(linear=3.0, angular=1.2),))


def parted(log, by=0.004):
    """Motion and wrenches as measurements of their own, the wrenches' a little later."""
    for m in log.measurements():
        yield Measurement(m.time, m.pose, m.velocity)
        yield Measurement(m.time + by, wrenches=m.wrenches, contacts=m.contacts)


class Diary:
    """A state that writes down what it is told."""

    def __init__(self, told=()):
        self.told = tuple(told)

    @property
    def time(self):
        return self.told[-1].time if self.told else -np.inf

    def take(self, measurement):
        assert measurement.time >= self.time - 1e-9
        self.told = (*self.told, measurement)

    def copy(self):
        other = Diary(self.told)
        other.factors = self.factors
        return other

    factors, took_long = None, False

    def scale_noise(self, noise_factors):
        self.factors = noise_factors


@given(st.lists(st.tuples(st.integers(0, 2000), st.integers(0, int(1200 * MAX_SAMPLE_DELAY))), min_size=1, max_size=60))
def test_every_sample_stands_where_it_belongs_or_is_refused(samples):
    """Milliseconds, and how late. Against sorting; only what is later than the reach may be refused."""
    arriving = [(time / 1000, late) for time, late in sorted(samples, key=sum)]
    kept, newest, taken = LateSamples(Diary()), -np.inf, []
    for time, _ in arriving:
        sample = Measurement(time)
        if kept.take(sample):
            taken.append(sample)
        else:
            assert newest - time > MAX_SAMPLE_DELAY or time < taken[0].time
        newest = max(newest, time)
        assert kept.state.time == pytest.approx(max(m.time for m in taken), abs=1e-9)
    assert sorted(m.time for m in taken) == [m.time for m in kept.state.told]
    assert {id(m) for m in taken} == {id(m) for m in kept.state.told}


def test_what_is_refused_leaves_the_reach_as_it_is():
    kept = LateSamples(Diary())
    for k in range(200):
        assert kept.take(Measurement(0.01 * k))
        assert not kept.take(Measurement(0.01 * k - 0.5))
    assert kept.take(Measurement(2.0 - MAX_SAMPLE_DELAY))


def test_what_is_known_of_noise_stays_where_time_goes_back():
    kept = LateSamples(Diary())
    for k in range(30):
        assert kept.take(Measurement(0.01 * k))
    kept.scale_noise(2.0)
    assert kept.take(Measurement(0.155))
    assert kept.state.factors == 2.0


@pytest.mark.parametrize("arms", [["left", "right"], None])
def test_arms_in_samples_of_their_own(arms):
    """As from two drivers: each arm's wrench counts until its next one."""
    log = simulate_two_hands(TRUTH, 5, duration=14.0, noise=(0.0004, 0.005, 1.0))
    noise, prior = replace(NOISE, force=1.0, moment=0.05), replace(KNOWN, slope=0.0)
    both, each = (CartFilter(guess(), arms, noise=noise, prior=prior) for _ in "12")
    for m in log.measurements():
        whole = both.update(m)
        each.update(Measurement(m.time, m.pose, m.velocity))
        for late, arm in ((0.001, "left"), (0.003, "right")):
            own = {arm: m.wrenches[arm]}
            estimate = each.update(Measurement(m.time + late, wrenches=own, contacts={arm: m.contacts[arm]}))
    assert estimate.health == whole.health == Health.OK
    assert estimate.parameters["mass"].value == pytest.approx(24.0, rel=0.03)
    assert estimate.parameters["mass"].value == pytest.approx(whole.parameters["mass"].value, rel=0.01)


def test_an_arm_that_falls_silent_makes_the_total_unknown():
    log = simulate_two_hands(TRUTH, 5, duration=4.0)
    cart_filter = CartFilter(guess(), ["left", "right"], prior=KNOWN)
    for m in log.measurements():
        wrenches = {"left": m.wrenches["left"]} if m.time > 3.0 else m.wrenches
        estimate = cart_filter.update(replace(m, wrenches=wrenches))
    assert estimate.health == Health.NO_WRENCH


@ONLINE
@pytest.mark.parametrize("fault", ["frozen wrench", "frozen pose", "gap"])
def test_a_clock_that_was_set_back_blinds_no_monitor(online, fault):
    """Faults come half a second after the clock went back by a minute: they are told as with a steady clock."""
    log, _ = simulate(TRUTH, 3, duration=8.0, noise=(0.0004, 0.005, 1.0))
    samples, healths, masses = list(log.measurements()), [], []
    for set_back in (0.0, 60.0):
        learner = online(guess(), ["hand"], noise=replace(NOISE, force=1.0, moment=0.05), prior=KNOWN)
        for k, sample in enumerate(samples):
            if fault == "frozen wrench" and k >= 500:
                sample = replace(sample, wrenches=samples[500].wrenches)
            if fault == "frozen pose" and k >= 500:
                sample = replace(sample, pose=samples[500].pose, velocity=samples[500].velocity)
            if fault == "gap" and 500 <= k < 700:
                continue
            estimate = learner.update(replace(sample, time=sample.time - set_back * (k >= 400)))
            if fault == "gap" and k == 700:
                break
        healths.append(str(estimate.health))
        masses.append(estimate.parameters["mass"].value)
    assert healths[0] == healths[1] == {"frozen wrench": "no_wrench", "frozen pose": "stale", "gap": "stale"}[fault]
    assert masses[1] == pytest.approx(masses[0], rel=0.02)


@pytest.mark.parametrize("ahead", [5.0, 1000.0])
def test_one_stamp_far_ahead_is_left_behind(ahead):
    log, _ = simulate(TRUTH, 3, duration=6.0, noise=(0.0004, 0.005, 1.0))
    learner, refused = CartFilter(guess(), ["hand"], noise=replace(NOISE, force=1.0, moment=0.05), prior=KNOWN), 0
    for k, sample in enumerate(log.measurements()):
        estimate = learner.update(replace(sample, time=sample.time + ahead) if k == 300 else sample)
        refused += estimate.health == Health.CLOCK
    assert refused == pytest.approx(0.5 / 0.01, abs=2)
    assert estimate.time == pytest.approx(sample.time, abs=1e-6)
    assert estimate.health == Health.OK
    np.testing.assert_allclose(estimate.motion.pose_sb[:2], sample.pose[:2], atol=0.005)


def test_what_comes_too_late_is_left_out():
    """However old the kept states are: here the last two samples are a second apart."""
    log, _ = simulate(TRUTH, 3, duration=3.0)
    learner, samples = CartFilter(guess(), ["hand"], prior=KNOWN), list(log.measurements())
    for sample in (*samples[:150], samples[250]):
        learner.update(sample)
    assert learner.update(samples[250 - 20]).health != Health.CLOCK
    assert learner.update(samples[250 - 40]).health == Health.CLOCK


@pytest.mark.parametrize(
    ("arms", "holds", "words"),
    [
        (["Left"], {"left": (0.0, 0.0, 1.0)}, "Left: no wrench of it has come; those that came are of left"),
        (None, {}, "left: its wrenches come without a contact; give contacts={'left': (x, y, z)} once"),
        (["left"], {}, "left: its wrenches come without a contact; give contacts={'left': (x, y, z)} once"),
        (
            ["left"],
            {"left": (np.nan, 0.0, 1.0)},
            "left: its wrenches come without a contact; give contacts={'left': (x, y, z)} once",
        ),
    ],
)
def test_arms_without_a_usable_wrench_are_named(arms, holds, words):
    learner = CartFilter(guess(), arms)
    for k in range(60):
        estimate = learner.update(Measurement(0.01 * k, np.zeros(3), np.zeros(3), {"left": np.zeros(6)}, holds))
    assert estimate.health == "no_wrench"
    assert [(one.kind, one.words) for one in estimate.suspicions] == [("missing", words)]


@cache
def estimates_where_arms_tell(number, arms, online):
    """For 0.7 s, instead of their wrenches."""
    estimator, found = online(guess(), ["left", "right"], noise=replace(NOISE, force=1.0, moment=0.05)), []
    for m in simulate_two_hands(TRUTH, 4, duration=3.0).measurements():
        if 1.0 <= m.time < 1.7:
            m = replace(m, wrenches={**m.wrenches, **dict.fromkeys(arms, np.full(6, number))})
        found.append(estimator.update(m))
    return found


@pytest.mark.some(12)
@pytest.mark.parametrize("arms", [("left", "right"), ("left",)], ids=["both", "one"])
@pytest.mark.parametrize("size", [-9999.0, 32767.0, 1e5, np.inf])
@pytest.mark.parametrize("online", [CartFilter, RegressorEstimator, DisturbedFilter])
def test_what_no_arm_gives_is_no_wrench(online, size, arms):
    """As if nothing had been recorded, to the last bit."""
    found, unrecorded = (estimates_where_arms_tell(number, arms, online) for number in (size, np.nan))
    words = "times the weight of the cart: that is no reading, or it is not in N and N·m"
    for estimate in found:
        if 1.65 < estimate.time < 1.7:
            assert estimate.health == "no_wrench"
            assert [one.where for one in estimate.suspicions if words in one.words] == list(arms)
    assert found[-1].health == unrecorded[-1].health
    np.testing.assert_array_equal(found[-1].model_parameters, unrecorded[-1].model_parameters)
    np.testing.assert_array_equal(found[-1].motion.pose_sb, unrecorded[-1].motion.pose_sb)


@ONLINE
def test_a_spike_after_a_gap_is_a_spike(online):
    """It moves no cart: followed, 2 kN for a hundredth of a second made 2 m/s."""
    log, _ = simulate(TRUTH, 3, duration=5.0, noise=(0.0004, 0.005, 1.0))
    noise, found = replace(NOISE, force=1.0, moment=0.05), []
    for spike in (0.0, 2000.0):
        estimator, speeds = online(guess(), ["hand"], noise=noise, prior=KNOWN), []
        for k, m in enumerate(log.measurements()):
            if k == 300:
                m = replace(m, wrenches={"hand": np.full(6, np.nan)})
            if k == 301:
                m = replace(m, wrenches={"hand": m.wrenches["hand"] + spike})
            speeds.append(estimator.update(m).motion.velocity)
        found.append(np.array(speeds))
    np.testing.assert_allclose(*found, atol=2e-3)


def test_a_time_that_is_refused_blinds_no_watch():
    log, _ = simulate(TRUTH, 3, duration=3.0)
    cart_filter = CartFilter(guess(), ["hand"], prior=KNOWN)
    for k, m in enumerate(log.measurements()):
        if k == 100:
            with pytest.raises(UsageError, match="time"):
                cart_filter.update(replace(m, time=np.inf))
        estimate = cart_filter.update(m)
    assert estimate.health != Health.STALE
    assert cart_filter.update(replace(m, time=m.time + 30.0)).health == Health.STALE


@pytest.mark.long
@ONLINE
def test_out_of_order_is_as_in_order(online):
    """With the walk of the wrench, too, which the EKF learns from noisy samples."""
    log, _ = simulate(TRUTH, 3, duration=3.0)
    samples = list(parted(log))
    random = np.random.default_rng(0)
    arriving = sorted(samples, key=lambda m: m.time + random.uniform(0.0, 0.2))
    arriving.remove(samples[0])
    noise = replace(NOISE, force=0.015)
    estimators = [online(guess(), ["hand"], noise=noise, prior=KNOWN) for _ in range(2)]
    for m in samples:
        in_order = estimators[0].update(m)
    for m in (samples[0], *arriving):
        shuffled = estimators[1].update(m)
    np.testing.assert_allclose(shuffled.model_parameters, in_order.model_parameters, rtol=1e-12)
    np.testing.assert_allclose(shuffled.motion.pose_sb, in_order.motion.pose_sb, atol=1e-12)
    assert shuffled.health == in_order.health


@ONLINE
def test_sensors_with_rates_of_their_own(online):
    """Wrenches five times as often as poses; all in one, or each on its own."""
    log, _ = simulate(TRUTH, 5, duration=14.0, noise=(0.0004, 0.005, 1.0))
    noise = replace(NOISE, force=1.0, moment=0.05)
    estimator = online(guess(), ["hand"], noise=noise, prior=KNOWN)
    for i, m in enumerate(log.measurements()):
        wrenches = Measurement(m.time, wrenches=m.wrenches, contacts=m.contacts)
        estimate = estimator.update(replace(wrenches, pose=m.pose, velocity=m.velocity) if i % 5 == 0 else wrenches)
    mass = estimate.parameters["mass"]
    assert mass.value == pytest.approx(24.0, rel=0.03)
    assert abs(mass.value - 24.0) < 3 * mass.std


@pytest.mark.long
@ONLINE
@pytest.mark.parametrize("kept", ["fifth of a second", "at random"])
def test_rows_farther_apart_than_a_block_of_the_regression(kept, online):
    """At 5 Hz, and with holes of 0.1 to 0.3 s among rows that come fast."""
    log = simulate_two_hands(TRUTH, 1)
    random = np.random.default_rng(1)
    rows = np.arange(0, len(log), 20) if kept == "fifth of a second" else np.flatnonzero(random.random(len(log)) < 0.3)
    samples = list(log.measurements())
    noise = replace(NOISE, force=3.0, moment=0.15)
    estimator = online(guess(), ["left", "right"], noise=noise, prior=KNOWN)
    for i in rows:
        estimate = estimator.update(samples[i])
    mass = estimate.parameters["mass"]
    assert mass.std < 4.0
    assert abs(mass.value - TRUTH[0]) < 3 * mass.std


def flags(estimator, measurements):
    return [str(estimator.update(m).health) for m in measurements]


def test_a_sensor_that_falls_silent_is_missed():
    log, _ = simulate(TRUTH, 8, duration=6.0)
    samples = list(log.measurements())
    estimator = CartFilter(guess(), ["hand"], noise=NOISE, prior=KNOWN)
    for m in samples[:200]:
        estimator.update(m)
    without_wrench = [replace(m, wrenches={}) for m in samples[200:300]]
    assert flags(estimator, without_wrench)[-1] == "no_wrench"
    assert estimator.sensors["wrench"].is_missed
    assert "no_wrench" not in flags(estimator, samples[300:400])[-50:]
    without_pose = [replace(m, pose=None, velocity=None) for m in samples[400:480]]
    assert flags(estimator, without_pose)[-1] == "stale"
    assert estimator.sensors["pose"].is_missed
    assert flags(estimator, samples[480:])[-1] != "stale"


def test_an_arm_that_vanishes_is_no_wrench():
    log = simulate_two_hands(TRUTH, 0)
    estimator = CartFilter(guess(), ["left", "right"], noise=replace(NOISE, force=3.0, moment=0.15), prior=KNOWN)
    samples = list(log.measurements())
    for m in samples[:300]:
        estimator.update(m)
    lost = [replace(m, wrenches={"left": m.wrenches["left"]}) for m in samples[300:500]]
    flags(estimator, lost[:50])
    before = estimator.estimate.parameters["mass"]
    assert flags(estimator, lost[50:])[-1] == "no_wrench"
    assert estimator.estimate.parameters["mass"] == before, "half of a push teaches nothing"


@ONLINE
def test_degrees_for_radians_are_flagged(online):
    """From the middle of a run: headings that no cart can have."""
    log, _ = simulate(TRUTH, 9, duration=12.0)
    samples = list(log.measurements())
    estimator = online(guess(), ["hand"], noise=NOISE, prior=KNOWN)
    for m in samples[:600]:
        estimator.update(m)
    before = estimator.estimate.parameters["mass"]
    wrong = [replace(m, pose=m.pose * [1, 1, np.rad2deg(1)], velocity=m.velocity) for m in samples[600:700]]
    if online is CartFilter:
        assert "outliers" in flags(estimator, wrong)
        assert estimator.sensors["pose"].ratio > 1.0
    else:
        flags(estimator, wrong)
    after = flags(estimator, samples[700:])
    found = estimator.estimate.parameters["mass"]
    assert after[-1] in ("ok", "load_changed", "outliers")
    assert np.isfinite([found.value, found.std]).all()
    assert abs(found.value - before.value) < 0.2 * before.value


@pytest.mark.some(2)
@pytest.mark.long
@ONLINE
@pytest.mark.parametrize("mass", [0.5, 20_000.0])
def test_a_first_guess_in_wrong_units_is_overcome_or_called_inconsistent(mass, online):
    log, _ = simulate(TRUTH, 10, duration=12.0)
    cart = CartModel(Inertia(mass, (0.3, 0.0), 1.8 * mass / 20), RollingConstraints(), guess().effects)
    estimator = online(cart, ["hand"], noise=NOISE, prior=KNOWN)
    health = flags(estimator, log.measurements())
    found = estimator.estimate.parameters["mass"]
    assert np.isfinite([found.value, found.std]).all()
    assert found.value == pytest.approx(24.0, rel=0.1) or {"inconsistent", "load_changed", "outliers"} & set(health)


@pytest.mark.long
@ONLINE
@settings(max_examples=15, deadline=None)
@given(data=st.data())
def test_nothing_that_a_sensor_says_poisons(online, data):
    log, _ = simulate(TRUTH, 11, duration=2.0)
    estimator = online(guess(), ["hand"], noise=NOISE, prior=KNOWN)
    absurd = st.sampled_from([np.nan, np.inf, -np.inf, 1e9, -1e9, 1e-300])
    for i, m in enumerate(log.measurements()):
        if i % 20 == 10:
            value = data.draw(absurd)
            part = data.draw(st.sampled_from(["pose", "velocity", "wrench", "contact", "time"]))
            if part == "pose":
                m = replace(m, pose=np.where([True, False, False], value, m.pose))
            elif part == "velocity":
                m = replace(m, velocity=np.full(3, value))
            elif part == "wrench":
                m = replace(m, wrenches={"hand": np.full(6, value)})
            elif part == "contact":
                m = replace(m, contacts={"hand": np.full(3, value if abs(value) < 1 else np.nan)})
            else:
                m = replace(m, time=m.time - 0.05)
        with np.errstate(all="ignore"):
            estimate = estimator.update(m)
        assert np.isfinite(estimate.motion.pose_sb).all()
        assert np.isfinite(estimate.model_parameters).all()
    assert np.linalg.eigvalsh(estimate.covariance[:4, :4]).min() > -1e-9


@ONLINE
@pytest.mark.parametrize("force", [0.0, 1.0])
@pytest.mark.parametrize("part", ["pose", "velocity"])
def test_a_number_whose_square_overflows_is_no_sample(online, force, part):
    """1e300 for one sample: what is learned is what is learned where that sample is missing."""
    log, _ = simulate(TRUTH, 3, duration=5.0)
    noise = replace(NOISE, force=force, moment=force / 20)
    found = []
    for odd in (np.full(3, 1e300), None):
        learner = online(guess(), noise=noise, prior=KNOWN)
        for k, sample in enumerate(log.measurements()):
            estimate = learner.update(replace(sample, **{part: odd}) if k == 300 else sample)
        found.append(estimate.model_parameters)
    assert np.allclose(*found, rtol=1e-9)


@pytest.mark.some(6)
@pytest.mark.long
@ONLINE
@pytest.mark.parametrize("force", [0.05, 1.0])
@pytest.mark.parametrize("spike", [150.0, -1e3, 1e6])
def test_a_wrench_that_jumps_and_comes_back_is_no_sample(online, force, spike):
    """What is learned is what is learned where that sample is missing."""
    log, _ = simulate(TRUTH, 3, duration=5.0)
    noise, found = replace(NOISE, force=force, moment=force / 20), []
    for odd in (spike, np.nan):
        learner = online(guess(), noise=noise, prior=KNOWN)
        for k, sample in enumerate(log.measurements()):
            if k == 300:
                wrenches = {arm: wrench + np.array([odd, 0, 0, 0, 0, 0]) for arm, wrench in sample.wrenches.items()}
                sample = replace(sample, wrenches=wrenches)
            estimate = learner.update(sample)
        found.append(estimate.model_parameters)
    np.testing.assert_allclose(*found, rtol=1e-9)


@ONLINE
def test_a_wrench_that_jumps_and_stays_is_believed(online):
    """From 60 N one way to 60 N the other at once, 0.6 of the cart's weight."""
    truth, wrenches = integrate(TRUTH, lambda time, _: (60.0 * (-1) ** int(2 * time + 0.5), 0.0), 8.0)
    wrench = np.pad(wrenches[:, :1], ((0, 0), (0, 5)))
    log = record(truth, {"hand": (np.array([0.0, 0.0, 1.0]), wrench)}, (0.0004, 0.005, 1.0), 3)
    learner = online(guess(), ["hand"], noise=replace(NOISE, force=1.0, moment=0.05), prior=KNOWN)
    for sample in log.measurements():
        estimate = learner.update(sample)
    assert estimate.parameters["mass"].value == pytest.approx(24.0, rel=0.02)
    assert estimate.health == "ok"


@ONLINE
def test_components_that_push_no_planar_cart_may_jump(online):
    log, _ = simulate(TRUTH, 3, duration=6.0, noise=(0.0004, 0.005, 1.0))
    learners = [online(guess(), ["hand"], noise=replace(NOISE, force=1.0, moment=0.05)) for _ in range(2)]
    for k, sample in enumerate(log.measurements()):
        weighed = np.array(sample.wrenches["hand"])
        weighed[2:5] = 200.0 * (k % 2), -30.0 * (k % 3), 10.0 * (k % 5)
        still = learners[0].update(sample)
        jumping = learners[1].update(replace(sample, wrenches={"hand": weighed}))
        np.testing.assert_array_equal(jumping.model_parameters, still.model_parameters)
        assert jumping.health == still.health


@ONLINE
@pytest.mark.parametrize("effects", [(), (ContactOffset(0.0, 0.02), ForceMisalignment(0.05))])
def test_what_pushes_no_planar_cart_may_be_missing(online, effects):
    """fz, tx, ty and the contact's height: nothing is learned otherwise, nor said of the wrench."""
    log, _ = simulate(TRUTH, 3, duration=4.0, noise=(0.0004, 0.005, 1.0))
    cart, found = CartModel(guess().inertia, effects=(*guess().effects, *effects)), []
    for value in (0.0, np.nan, np.inf):
        learner = online(cart, noise=replace(NOISE, force=1.0, moment=0.05))
        for sample in log.measurements():
            wrenches = {arm: np.array([fx, fy, *[value] * 3, tz]) for arm, (fx, fy, *_, tz) in sample.wrenches.items()}
            contacts = {arm: np.array([x, y, value]) for arm, (x, y, _) in sample.contacts.items()}
            estimate = learner.update(replace(sample, wrenches=wrenches, contacts=contacts))
            assert estimate.health != "no_wrench"
        found.append(estimate.model_parameters)
    np.testing.assert_array_equal(found[1:], [found[0]] * 2)


@pytest.mark.parametrize("fault", ["not a number", "too large", "frozen", "silent"])
@pytest.mark.parametrize("arms", [["left", "right"], None], ids=["declared", "seen"])
def test_an_arm_is_named_in_every_sample(fault, arms):
    """Arms may come in samples of their own: the other's took the name away. A silent arm had no name at all."""
    random = np.random.default_rng(2)
    learner, last, kinds = CartFilter(guess(), arms, noise=NOISE, prior=KNOWN), np.zeros(6), []
    for k in range(400):
        for name, late in (("left", 0.0), ("right", 0.004)):
            felt = random.normal(size=6)
            if name == "left" and k >= 250:
                felt = {"not a number": np.full(6, np.nan), "too large": np.full(6, 1e5)}.get(fault, last)
                if fault == "silent":
                    continue
            last = felt if name == "left" else last
            hold = {name: (-0.3, 0.2 if name == "left" else -0.2, 1.0)}
            told = learner.update(Measurement(0.01 * k + late, np.zeros(3), None, {name: felt}, hold))
            if k >= 320:
                assert told.health == "no_wrench"
                kinds.append({(one.kind, one.where) for one in told.suspicions})
    assert all(one == {("repeated" if fault == "frozen" else "missing", "left")} for one in kinds)
