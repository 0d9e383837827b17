"""Whether the online filter says that sensors don't mean what they say, and keeps silent where they do."""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest

from cartgrasp.constraints import RollingConstraints
from cartgrasp.effects import FloorSlope, TimeDelay, ViscousDrag
from cartgrasp.first_guess import FirstGuess
from cartgrasp.inertia import Inertia
from cartgrasp.logs import ArmLog, RunLog
from cartgrasp.model import CartModel
from cartgrasp.motion import Measurement
from estimation import CartFilter, DisturbedFilter, FilterNoise, RegressorEstimator
from estimation.health import Health
from estimation.online.sensor_block import (
    HEADING_FACTORS,
    SensorBlock,
    poses_jump,
    poses_of,
    velocities_of,
    wrenches_of,
)
from estimation.online.sensor_monitor import SensorMonitor
from estimation.whole_log.replay import replay

from ..runs import CONTACT, simulate, simulate_two_hands

PLANT = (24.0, 0.28, 0.06, 2.2, 3.0, 1.2, 0.01)
GUESS = CartModel(Inertia(20.0, (0.3, 0.0), 1.8), effects=(ViscousDrag(2.0, 1.0),))
NOISY = FilterNoise(0.0004, 0.0004, 0.005, 0.005, 1.0, 0.05, disturbance=0.05, slip=0.0002)
EXACT = replace(NOISY, force=0.05, moment=0.005, disturbance=0.3)
KINDS = {"noisy": (CartFilter, NOISY), "exact": (CartFilter, EXACT), "regressor": (RegressorEstimator, NOISY)}


def run(seed=4, noise=0.005):
    return simulate(PLANT, seed, duration=8.0, noise=(0.0004, noise, 0.3))[0]


def with_wrenches(log, factor):
    return replace(log, arms={name: ArmLog(arm.contact, factor * arm.wrench) for name, arm in log.arms.items()})


def turned(log, angle):
    """In a world that is turned."""
    turn = np.array([[np.cos(angle), -np.sin(angle), 0.0], [np.sin(angle), np.cos(angle), 0.0], [0.0, 0.0, 1.0]])
    return replace(log, pose=log.pose @ turn.T + [0.0, 0.0, angle], velocity=log.velocity @ turn.T)


FAULTS = {
    "reversed": (lambda log: with_wrenches(log, -1.0), ("sign", "wrench")),
    "kN": (lambda log: with_wrenches(log, 1e-3), ("unit", "wrench")),
    "degrees": (lambda log: replace(log, pose=log.pose * [1.0, 1.0, 180 / np.pi]), ("unit", "heading")),
    "mm": (lambda log: replace(log, pose=log.pose * [1000.0, 1000.0, 1.0]), ("unit", "pose")),
    "theta reversed": (lambda log: replace(log, pose=log.pose * [1.0, 1.0, -1.0]), ("sign", "heading")),
    "mm, no velocities": (
        lambda log: replace(log, pose=log.pose * [1000.0, 1000.0, 1.0], velocity=None),
        ("unit", "pose"),
    ),
}


@pytest.mark.some(1)
@pytest.mark.parametrize("every", [5, 10])
def test_slow_sensors_are_looked_at_too(every):
    """At 20 and 10 Hz: at the last each sample brings a row of the regression."""
    log = simulate(PLANT, 4, duration=20.0, noise=(0.0004, 0.005, 0.3))[0]
    log = RunLog.from_measurements(list(log.measurements())[::every], ["hand"])
    sound, found = (replay(one, CartFilter(GUESS)).estimates[-1] for one in (log, with_wrenches(log, -1.0)))
    assert not sound.suspicions
    assert ("sign", "wrench") in {(one.kind, one.where) for one in found.suspicions}


def at_rate(rate, duration=5.0):
    """Motion and wrenches of a run with sensors that are so quick (Hz), n of each."""
    log, truth = simulate(PLANT, 4, duration=duration, noise=(0.0, 0.0, 0.0))
    time, random = np.arange(round(duration * rate)) / rate, np.random.default_rng(5)
    held = np.minimum((time / 0.01 + 1e-9).astype(int), len(log) - 1)
    pose, velocity = (
        np.stack([np.interp(time, log.time, column) for column in seen.T], axis=1)
        for seen in (truth[:, :3], log.velocity)
    )
    pose, velocity = pose + 0.0004 * random.normal(size=pose.shape), velocity + 0.005 * random.normal(size=pose.shape)
    wrench = log.arms["hand"].wrench[held] + random.normal(size=(len(time), 6)) * [0.3, 0.3, 0.3, 0.02, 0.02, 0.02]
    return time, pose, velocity, wrench


@pytest.mark.some(4)
@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize(
    ("rate", "way"),
    [
        *((rate, "in turn") for rate in (100, 200, 250, 500)),
        *((250, "together"), (100, "contacts once"), (25, "poses late")),
    ],
)
def test_a_sign_is_told_however_samples_come(rate, way, sign):
    """Whether motion and wrenches are one sample or two, and a contact comes once or always, at any rate. Samples were
    thinned across sensors: at 200, 250, 500 and 1000 Hz a wrench in a sample of its own was never looked at."""
    made, contact, told, waiting = CartFilter(GUESS, ["hand"], noise=NOISY), {"hand": CONTACT}, None, []
    for k, (time, pose, velocity, wrench) in enumerate(
        zip(*at_rate(rate, 8.0 if way == "poses late" else 5.0), strict=True)
    ):
        seen, felt = (
            Measurement(float(time), pose, velocity),
            Measurement(float(time), None, None, {"hand": sign * wrench}),
        )
        holds = contact if k == 0 or way != "contacts once" else {}
        if way == "together":
            made.update(replace(seen, wrenches=felt.wrenches, contacts=holds))
            continue
        waiting.append(seen)
        while waiting and (way != "poses late" or waiting[0].time < time - 0.27):
            made.update(waiting.pop(0))
        made.update(replace(felt, contacts=holds))
    told = made.estimate
    signs = [one.where for one in told.suspicions if one.kind == "sign"]
    assert signs == (["wrench"] if sign < 0 else [])


@pytest.mark.some(1)
@pytest.mark.parametrize("wrong", ["left", "right"])
def test_one_arm_of_two_that_is_reversed_is_told_by_its_name(wrong):
    log = simulate_two_hands(PLANT, 4, duration=10.0)
    arm = log.arms[wrong]
    reversed_one = replace(log, arms=log.arms | {wrong: ArmLog(arm.contact, -arm.wrench)})
    sound, found = (replay(one, CartFilter(GUESS, ["left", "right"])).estimates for one in (log, reversed_one))
    assert not any(one.suspicions for one in sound)
    assert {(one.kind, one.where) for one in found[-1].suspicions} == {("sign", wrong)}
    assert found[-1].health == Health.INCONSISTENT


@pytest.mark.parametrize("wrong", [("right",), ("left", "right")])
def test_a_sign_that_turns_on_the_way_is_told_until_it_turns_back(wrong):
    """From 8 to 13 s. That had taken 22 s, or for ever."""
    log = simulate_two_hands(PLANT, 4, duration=22.0)
    sign = np.where((log.time >= 8.0) & (log.time < 13.0), -1.0, 1.0)[:, None]
    arms = {
        name: ArmLog(arm.contact, sign * arm.wrench if name in wrong else arm.wrench) for name, arm in log.arms.items()
    }
    found = replay(replace(log, arms=arms), CartFilter(GUESS, ["left", "right"])).estimates
    told = {one.time: {s.where for s in one.suspicions if s.kind == "sign"} for one in found}
    expected = {wrong[0] if len(wrong) == 1 else "wrench"}
    assert not any(named for time, named in told.items() if time < 8.0)
    assert all(named == expected for time, named in told.items() if 12.0 < time < 13.0)
    assert not told[found[-1].time]


def test_an_arm_that_comes_later_is_looked_at_from_then_on():
    log = simulate_two_hands(PLANT, 4, duration=12.0)
    cart_filter, found = CartFilter(GUESS), []
    for measurement in log.measurements():
        if measurement.time < 3.0:
            measurement = replace(measurement, wrenches={"left": measurement.wrenches["left"]})
        found.append(cart_filter.update(measurement))
    assert not found[-1].suspicions


@pytest.mark.parametrize("axle_x", [-0.4, 0.15, 0.0, 0.03])
def test_an_axle_that_is_elsewhere_is_told_with_where_it_is(axle_x):
    """From where poses say that nothing goes sideways; a few centimetres may be the tracker's."""
    cart = replace(GUESS, constraints=RollingConstraints(axle_x=axle_x))
    told = replay(run(), CartFilter(cart, noise=NOISY)).last.suspicions
    if abs(axle_x) < 0.1:
        assert not told
    else:
        (one,) = told
        assert (one.kind, one.where) == ("offset", "pose")
        assert one.factor == pytest.approx(-axle_x, abs=0.01)
        assert f"the file has the axle at {axle_x:g} m" in one.words


@pytest.mark.some(10)
@pytest.mark.long
@pytest.mark.parametrize(("fault", "which"), list(product(FAULTS, KINDS)))
def test_a_fault_is_told_within_five_seconds(fault, which):
    change, told = FAULTS[fault]
    kind, noise = KINDS[which]
    found = replay(change(turned(run(), 0.8)), kind(GUESS, ["hand"], noise=noise)).estimates
    at_five = next(one for one in found if one.time >= 5.0)
    assert {(one.kind, one.where) for one in at_five.suspicions} == {told}
    assert at_five.health != Health.OK
    assert not any(parameter.identifiable for parameter in at_five.parameters.values())


@pytest.mark.some(5)
@pytest.mark.parametrize("which", KINDS)
@pytest.mark.parametrize("share", [1 / 3, 1.0, 3.0])
def test_sound_sensors_are_not_suspected(which, share):
    kind, noise = KINDS[which]
    body = GUESS.inertia
    cart = CartModel(Inertia(share * body.mass, body.com, share * body.about_com), effects=GUESS.effects)
    found = replay(turned(run(), -2.0), kind(cart, ["hand"], noise=noise)).estimates
    assert not any(one.suspicions for one in found)


def test_a_mass_that_the_file_knows_tells_pounds():
    """Without what the file says, a guess that is too heavy explains as much."""
    log = with_wrenches(run(), 1 / 4.4482216)
    guess = CartModel(GUESS.inertia, effects=GUESS.effects, first_guess=FirstGuess((("mass", 3.0),)))
    told = replay(log, CartFilter(guess, ["hand"], noise=NOISY)).last.suspicions
    assert [(one.kind, one.where) for one in told] == [("unit", "wrench")]
    assert told[0].factor == pytest.approx(4.4482216)


@pytest.mark.long
def test_it_ends_with_the_fault():
    """A quarter of a minute after a plug was turned."""
    log = simulate(PLANT, 3, duration=20.0, noise=(0.0004, 0.005, 0.3))[0]
    arm = log.arms["hand"]
    sign = np.where(log.time < 5.0, -1.0, 1.0)[:, None]
    found = replay(
        replace(log, arms={"hand": ArmLog(arm.contact, sign * arm.wrench)}), CartFilter(GUESS, ["hand"], noise=NOISY)
    )
    assert any(one.suspicions for one in found.estimates if one.time < 5.0)
    assert not found.last.suspicions


def test_noise_is_heard_and_taken_as_such():
    """So that the filter stays sound, and right."""
    log, _ = simulate((*PLANT[:-1], 0.0), 5, duration=12.0, noise=(0.0004, 0.015, 0.3))
    told = replay(log, CartFilter(GUESS, ["hand"], noise=NOISY)).last
    assert {one.kind for one in told.suspicions} == {"noise"}
    assert [one.factor for one in told.suspicions] == pytest.approx([3.0, 3.0], rel=0.25)
    assert told.health == Health.OK
    assert told.parameters["mass"].value == pytest.approx(PLANT[0], rel=0.03)


def test_an_observer_of_disturbances_hears_of_noise_too():
    """Where nothing pushes, nothing acts: of velocities three times as noisy as declared it told pushes of 14 N rms
    (± 6) in a quarter of all ticks, with health ok."""
    log, _ = simulate((*PLANT[:-1], 0.0), 5, duration=12.0, noise=(0.0004, 0.015, 0.3))
    found = [one for one in replay(log, DisturbedFilter(GUESS, ["hand"], noise=NOISY)).estimates if one.time > 4.0]
    ratios = [one.disturbance.wrench / one.disturbance.std for one in found]
    assert np.sqrt(np.mean(np.square(ratios))) < 1.3
    assert np.mean([one.disturbance.acts for one in found]) < 0.02


@pytest.mark.parametrize("effect", [TimeDelay(0.08), FloorSlope(0.05, 0.0)])
def test_what_the_model_knows_is_no_fault(effect):
    """Late wrenches; a slope on which the cart brakes itself, or needs twice the push."""
    from cartgrasp.contacts import ContactWrenches
    from cartgrasp.simulation.plant import ModelPlant
    from cartgrasp.simulation.sensors import SensorNoise, Sensors

    cart = CartModel(Inertia(24.0, (0.28, 0.0), 2.2), effects=(ViscousDrag(3.0, 1.2),)).with_effect(effect)
    plant, sensors = ModelPlant(cart), Sensors(cart, SensorNoise(force=1.0), 2)
    filtered = CartFilter(cart, ["hand"], noise=NOISY)
    for k in range(700):
        time, speed = 0.01 * k, 0.4 * np.sin(0.9 * 0.01 * k)
        push = 60.0 * (speed - plant.motion.velocity[0])
        given = ContactWrenches({"hand": np.array([push, 0, 0, 0, 0, 0])}, {"hand": np.array([-0.25, 0.0, 1.0])})
        seen, felt = sensors.motion(time, plant.motion), sensors.wrenches(time, given)
        told = filtered.update(replace(seen, wrenches=felt.wrenches, contacts=felt.contacts))
        assert not told.suspicions
        plant.step(given, 0.01)


def test_block_means():
    """Against numpy's, whatever the heading's turn."""
    log = turned(run(), 3.0)
    rows = list(log.measurements())[300:325]
    poses, time, place, headings = poses_of(rows)
    np.testing.assert_array_equal(poses[:, 1:], log.pose[300:325])
    assert time == pytest.approx(np.mean(log.time[300:325]))
    assert place == pytest.approx(log.pose[300:325, :2].mean(axis=0))
    theta = np.unwrap(log.pose[300:325, 2]).mean()
    assert np.exp(1j * np.array(headings)) == pytest.approx(np.exp(1j * np.array(HEADING_FACTORS) * theta), abs=1e-6)
    velocity, noise = velocities_of(rows)
    assert velocity == pytest.approx(log.velocity[300:325].mean(axis=0))
    assert np.sqrt(noise) == pytest.approx([0.005, 0.005], rel=0.5)
    arm = log.arms["hand"]
    x, y, _ = arm.contact[0]
    fx, fy, tau = arm.wrench[300:325][:, [0, 1, 5]].mean(axis=0)
    (wrench_b,) = wrenches_of(rows, {"hand": arm.contact[0]}, ["hand"], {})
    assert wrench_b == pytest.approx([fx, fy, tau + x * fy - y * fx])


@pytest.mark.parametrize(("at_once", "calls"), [(True, 1), (False, 7)])
def test_a_block_takes_few_calls(at_once, calls):
    """And nothing in between: who asks `due` first pays a comparison."""
    watch, found = SensorMonitor(GUESS, ["hand"], NOISY, CartFilter(GUESS).prior, {}), 0
    for row in list(run().measurements())[:500]:
        watch.samples.note(row, row.time)
        if row.time >= watch.samples.due:
            watch.go_on(row.time, at_once=at_once)
            found += 1
    assert 500 // 25 <= found <= calls * (500 // 25 + 1)


@pytest.mark.parametrize("turned_by", [np.pi, 2.0, -0.8])
def test_headings_that_jump_are_not_in_degrees(turned_by):
    """A source of poses that turns for half a second: one row is not to outweigh the others."""
    log = run()
    wrong = (log.time > 3.0) & (log.time < 3.5)
    found = replay(replace(log, pose=log.pose + np.outer(wrong, [0.0, 0.0, turned_by])), CartFilter(GUESS, noise=NOISY))
    assert not [one for told in found.estimates for one in told.suspicions if one.where == "heading"]


def moved(log, jumps):
    """With poses elsewhere at times."""
    return replace(log, pose=log.pose + np.outer(jumps(log.time), [2.0, 1.0, 0.0]))


@pytest.mark.some(4)
@pytest.mark.parametrize("has_velocity", [True, False])
@pytest.mark.parametrize(("until", "sign"), [(5.01, 1.0), (5.1, 1.0), (99.0, 1.0), (99.0, -1.0)])
def test_a_tracker_that_jumps_says_nothing_of_wrenches(until, sign, has_velocity):
    """Once, to and fro, or for good. For minutes after a jump of 2 m wrenches had been told to be in kgf, and no sign
    was seen to be reversed."""
    log = with_wrenches(simulate_two_hands(PLANT, 5, duration=11.0, noise=(0.0005, 0.005, 1.0)), sign)
    log = moved(log if has_velocity else replace(log, velocity=None), lambda time: (time >= 5.0) & (time < until))
    found = replay(log, CartFilter(GUESS, ["left", "right"], noise=FilterNoise(force=1.0, moment=0.05))).estimates
    told = {(one.kind, one.where) for estimate in found for one in estimate.suspicions if one.kind != "noise"}
    assert told == (set() if sign > 0.0 else {("sign", "wrench")})


def test_only_what_jumps_jumps():
    """Neither a start with a constant jerk, nor noise, nor a gap, nor a coarse tracker."""
    time, random = 0.02 * np.arange(26), np.random.default_rng(1)
    start = np.outer(0.2 * time**3, [1.0, 0.5, 2.0])
    sound = [start, 5e-4 * random.normal(size=(26, 3)), np.outer(np.round(0.3 * time, 2), [1.0, 0.0, 0.0])]
    jumped = [start + np.outer(time > 0.3, off) for off in ([1.0, 0.0, 0.0], [0.0, 0.0, 1.0])]
    spike = start + np.outer(np.arange(26) == 14, [1.0, 0.0, 0.0])
    gap = np.delete(np.arange(26), np.arange(14, 20))
    for poses, rows in [*((one, np.arange(26)) for one in (*sound, *jumped, spike)), (start, gap)]:
        told = [
            SensorBlock(*poses_of([Measurement(time[k], pose=poses[k]) for k in half]), None, None, None)
            for half in (rows[rows < 13], rows[rows >= 13])
        ]
        assert poses_jump(*told) == (any(poses is one for one in (*jumped, spike)))


def test_what_pushes_no_planar_cart_hides_no_sign():
    """Sensors of a plane leave fz, tx and ty as NaN: nothing was ever seen of their signs."""
    log = with_wrenches(run(), np.array([-1.0, -1.0, np.nan, np.nan, np.nan, -1.0]))
    told = replay(log, CartFilter(GUESS, ["hand"], noise=NOISY)).last
    assert ("sign", "wrench") in {(one.kind, one.where) for one in told.suspicions}


def test_a_contact_that_is_missing_once_blinds_nobody():
    """It had done so for good: no sign was told any more."""
    made = CartFilter(GUESS, ["hand"], noise=NOISY)
    for k, m in enumerate(with_wrenches(run(), -1.0).measurements()):
        told = made.update(replace(m, contacts={"hand": np.full(3, np.nan)}) if k == 50 else m)
    assert ("sign", "wrench") in {(one.kind, one.where) for one in told.suspicions}
