"""The controller against its parts called one by one; and what it does, tick by tick, while a hand regrasps."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

import cartgrasp as cg
from cartgrasp.effects import ViscousDrag
from cartgrasp.errors import FileError, UsageError
from cartgrasp.frames import body_to_world
from cartgrasp.roles import ContactChoice
from cartgrasp.simulation import ModelPlant, SensorNoise, Sensors
from estimation import CartFilter, DisturbedFilter, FilterNoise
from planning import (
    Caution,
    Controller,
    PathReference,
    RegraspTimes,
    Skid,
    WrenchPlanner,
    build_tracker,
    chain,
    pause,
    straight,
)
from planning.references import speed_change, turn

from .driving import ticks

DRAG = ViscousDrag(linear=3.0, angular=1.2)
CART = cg.CartModel(cg.Inertia(24.0, (0.3, 0.05), 2.2), effects=(DRAG,))
GUESS = cg.CartModel(cg.Inertia(18.0, (0.25, 0.0), 2.0), effects=(DRAG,))
PATH = PathReference(chain(speed_change(0.5), turn(0.8, 0.4), pause(1.0), speed_change(-0.5), pause(1.0)))
NOISE = FilterNoise(force=1.0, moment=0.05)
HERE = (-0.25, 0.2, 1.0)
TIMES = RegraspTimes(speed=0.6, unload=0.15, take_hold=0.1, load=0.2)


def arms(force=120.0, names=("left", "right")):
    sides = {"left": 0.2, "right": -0.2}
    return [
        cg.Arm(n, [(-0.25, sides[n], 1.0), (0.1, sides[n], 0.9)], force_limit=(force,) * 3, moment_limit=(15.0,) * 3)
        for n in names
    ]


def learner(names=("left", "right")):
    return CartFilter(GUESS, list(names), noise=NOISE)


class Later:
    """Every arm's second candidate from a time on."""

    def __init__(self, holders, time):
        self.points, self.time = {arm.name: [np.array(p) for p in arm.contacts.points] for arm in holders}, time

    def contacts(self, query):
        return ContactChoice(
            {name: at[int(query.time >= self.time - 1e-9)] for name, at in self.points.items()}, "told"
        )


def drive(controller, duration, truth=CART, noise=None):
    """Steps, and what was felt after each."""
    return [(tick.step, tick.felt) for tick in ticks(controller, truth, duration, noise)]


def test_it_does_what_its_parts_do_one_by_one():
    held = arms()
    told = drive(Controller(GUESS, held, PATH, estimator=learner()), 2.0)
    plant, sensors = ModelPlant(CART), Sensors(CART, SensorNoise(force=1.0, moment=0.05), seed=3)
    tracker, cart_filter = build_tracker(GUESS.constraints), learner()
    planner = WrenchPlanner(GUESS, held, period=0.01, relax=np.inf)
    planner.warm_up()
    first = {arm.name: arm.contacts.first for arm in held}
    for step, _ in told:
        estimate = cart_filter.update(sensors.motion(plant.time, plant.motion))
        wanted = tracker.wrench_b(PATH.at(plant.time), estimate.motion, estimate.cart_on_floor())
        given = planner.plan_or_hold(wanted, contacts=first).contact_wrenches
        cart_filter.update(sensors.wrenches(plant.time, given))
        plant.step(given, 0.01)
        for name in first:
            assert np.array_equal(step.wrenches[name], given.wrenches[name])
        assert step.health == estimate.health
        assert step.estimate.parameters["mass"].value == estimate.parameters["mass"].value


def test_no_hand_jumps_and_the_cart_gets_what_it_is_to_get():
    """Two strong arms regrasp while the cart drives a bend: one after the other, each unloaded, moved, loaded."""
    held = arms()
    controller = Controller(GUESS, held, PATH, contacts=Later(held, 1.5), regrasp=TIMES, estimator=learner())
    told = drive(controller, 6.0)
    names = [arm.name for arm in held]
    points = {n: np.array([step.contacts[n] for step, _ in told]) for n in names}
    wrenches = {n: np.array([step.wrenches[n] for step, _ in told]) for n in names}
    felt = {n: np.array([measured.wrenches[n] for _, measured in told]) for n in names}
    moving = {n: np.linalg.norm(np.diff(points[n], axis=0), axis=1) for n in names}
    wanted = np.array([step.reference.acceleration for step, _ in told])
    steady = (np.diff(wanted, axis=0) == 0).all(axis=1)
    distance = np.linalg.norm(np.subtract(*[np.array(p) for p in held[0].contacts.points]))
    for n in names:
        assert moving[n].max() <= TIMES.speed * 0.01 * (1 + 1e-6)
        assert np.array_equal(points[n][-1], held[names.index(n)].contacts.points[1])
        free = np.array([step.hands[n].is_away for step, _ in told])
        assert (wrenches[n][free] == 0).all()
        assert free.sum() * 0.01 >= TIMES.away(distance) - 0.01
        assert (free[:-1] | (moving[n] == 0)).all()
        assert np.array_equal(felt[n][free], np.zeros((free.sum(), 6)))
        assert (felt[n][~free] != 0).all()
        largest, changes = np.abs(wrenches[n]).max(axis=0), np.abs(np.diff(wrenches[n], axis=0))
        assert (changes[100:][steady[100:]] <= 0.01 / min(TIMES.unload, TIMES.load) * largest + 0.2).all()
    assert not ((moving["left"] > 0) & (moving["right"] > 0)).any()
    assert all(not ((w["left"] == 0).all() and (w["right"] == 0).all()) for w in (step.wrenches for step, _ in told))
    tracker = build_tracker(GUESS.constraints)
    for step, _ in told[::7]:
        wanted = tracker.wrench_b(step.reference, step.estimate.motion, step.estimate.cart_on_floor())
        assert np.allclose(GUESS.basis_b.T @ step.given.wrench_b, GUESS.basis_b.T @ wanted, atol=1e-6)
    words = [step.words for step, _ in told]
    assert words[0] == "holds left at (−0.25, 0.20): told; holds right at (−0.25, −0.20): told"
    assert any(text.startswith("moves left to (0.10, 0.20): told;") for text in words)
    assert words[-1] == "holds left at (0.10, 0.20): told; holds right at (0.10, −0.20): told"


def test_a_hand_stays_where_the_others_cannot_do_without_it():
    held = arms(force=9.0)
    told = drive(Controller(GUESS, held, PATH, contacts=Later(held, 0.5), estimator=learner()), 0.9)
    last = told[-1][0]
    assert last.words.startswith("keeps left at (−0.25, 0.20): the others can't bear ")
    assert all(np.array_equal(step.contacts["left"], held[0].contacts.first) for step, _ in told)


@pytest.mark.long
@pytest.mark.parametrize("drag", [1.0, 30.0])
def test_one_arm_lets_go_where_the_cart_coasts(drag):
    """At constant speed a cart with little drag coasts for the 0.9 s; one with much would stop, so the hand waits until
    the cart is to slow down as it would by itself."""
    cart = cg.CartModel(cg.Inertia(24.0, (0.3, 0.0), 2.2), effects=(ViscousDrag(drag, 5.0),))
    held = arms(names=["left"])
    path = PathReference(chain(straight(2.5, 0.5), pause(3.0)))
    controller = Controller(
        cart, held, path, contacts=Later(held, 2.0), regrasp=TIMES, estimator=CartFilter(cart, ["left"], noise=NOISE)
    )
    told = drive(controller, path.duration, cart)
    start = next(step for step, _ in told if (step.wrenches["left"] == 0).all() and step.time > 1.0)
    speed = float(start.estimate.motion.velocity[0])
    assert start.plan.status == "relaxed"
    if drag == 1.0:
        assert start.time < 2.5
        assert speed > 0.4
    else:
        assert start.reference.acceleration[0] < 0
        waiting = next(step for step, _ in told if step.time > 2.05)
        assert "keeps left at (−0.25, 0.20): the cart would coast 0." in waiting.words
    off = max(np.linalg.norm(s.estimate.motion.pose_sb[:2] - s.reference.pose_sb[:2]) for s, _ in told)
    assert off < 0.1
    assert told[-1][0].words == "holds left at (0.10, 0.20): told"


def test_it_goes_on_from_what_was_saved(tmp_path):
    """In the middle of a regrasp: hands where they were, wrenches without a jump, and the cart as it was known."""
    held = arms()
    controller = Controller(GUESS, held, PATH, contacts=Later(held, 1.0), regrasp=TIMES, estimator=learner())
    told = drive(controller, 1.1)
    last = told[-1][0]
    assert last.hands["left"].phase == "unloads"
    path = controller.save(tmp_path / "controller.yaml")
    again = Controller.restored(path, held, PATH, contacts=Later(held, 1.0), regrasp=TIMES)
    assert again.cart.inertia.mass == pytest.approx(last.estimate.cart().inertia.mass)
    std = dict(again.cart.first_guess.std)
    assert std["com_x"] == pytest.approx(last.estimate.parameters["com_x"].std)
    motion = last.estimate.motion
    velocity = body_to_world(motion.pose_sb[2]) @ GUESS.basis_b @ motion.velocity
    step = again.step(cg.Measurement(last.time + 0.01, motion.pose_sb, velocity))
    assert step.hands["left"].phase == "unloads"
    assert step.hands["left"].share == pytest.approx(last.hands["left"].after(0.01, TIMES).share)
    for name in ("left", "right"):
        assert np.abs(step.wrenches[name] - last.wrenches[name]).max() < 4.0
    text = path.read_text()
    path.write_text(text.replace("share:", "shar:"))
    with pytest.raises(FileError, match=r"controller.yaml:\d+:\d+: hands.left.shar: unknown key"):
        Controller.restored(path, held, PATH)
    path.write_text(re.sub(r"target:(\n *- .*)+", "target:", text))
    with pytest.raises(FileError, match=r"controller.yaml:\d+:\d+: hands.left: .*a hand that unloads has no target"):
        Controller.restored(path, held, PATH)
    path.write_text(text)
    with pytest.raises(UsageError, match="has the hands of left, right; give these arms"):
        Controller.restored(path, arms(names=["left"]), PATH)
    with pytest.raises(UsageError, match="what it makes of a cart, None, is no estimator"):
        Controller.restored(path, held, PATH, estimator=lambda cart: None)


def test_hands_that_hold_already_regrasp_first():
    held = arms()
    second = {arm.name: arm.contacts.points[1] for arm in held}
    controller = Controller(GUESS, held, PATH, held=second, regrasp=TIMES, estimator=learner())
    told = drive(controller, 2.5)
    assert told[0][0].words == "holds left at (0.10, 0.20): fixed; holds right at (0.10, −0.20): fixed"
    assert told[10][0].words.startswith("unloads left at (0.10, 0.20), to go to (−0.25, 0.20): fixed; holds right")
    assert told[-1][0].words == "holds left at (−0.25, 0.20): fixed; holds right at (−0.25, −0.20): fixed"


def test_no_hand_leaves_while_the_senses_are_lost():
    held = arms()
    controller = Controller(GUESS, held, PATH, contacts=Later(held, 1.0), regrasp=TIMES, estimator=learner())
    last = drive(controller, 0.5)[-1][0]
    for k in range(300):
        last = controller.step(cg.Measurement(0.5 + 0.01 * k))
    assert last.health in ("stale", "no_wrench")
    assert np.array_equal(last.contacts["left"], held[0].contacts.first)


def test_what_it_is_made_of_is_checked():
    held = arms()
    controller = Controller(GUESS, held, PATH)
    assert len(repr(controller)) < 100
    assert "arms left, right" in repr(controller)
    with pytest.raises(UsageError, match="nothing to save before the first step"):
        controller.save("x.yaml")
    with pytest.raises(UsageError, match="controller: held: left are not the arms left, right"):
        Controller(GUESS, held, PATH, held={"left": (0.0, 0.2, 1.0)})
    with pytest.raises(UsageError, match="contacts: there is no 'teaching'; did you mean teach"):
        Controller(GUESS, held, PATH, contacts="teaching")
    with pytest.raises(UsageError, match="controller: period"):
        Controller(GUESS, held, PATH, period=0.0)
    with pytest.raises(UsageError, match=r"controller: period: 0.01 s, and the planner's is 0.1 s"):
        Controller(GUESS, held, PATH, planner=WrenchPlanner(GUESS, held, period=0.1))
    with pytest.raises(UsageError, match=r"controller: period: 10 is not a number .*give s"):
        Controller(GUESS, held, PATH, period=10)
    with pytest.raises(UsageError, match=r"controller: reference: .* is no path; write PathReference\(chain\(…\)\)"):
        Controller(GUESS, held, chain(pause(1.0)))
    with pytest.raises(UsageError, match="left_arm, right_arm, and the arms are left, right; name them alike"):
        Controller(GUESS, held, PATH, estimator=learner(("left_arm", "right_arm")))
    with pytest.raises(UsageError, match="measurement: wrenches: there is no 'rigth'; did you mean right"):
        controller.observe(cg.Measurement(0.0, wrenches={"left": np.zeros(6), "rigth": np.zeros(6)}))
    with pytest.raises(UsageError, match=r"controller: regrasp: .* is no RegraspTimes"):
        Controller(GUESS, held, PATH, regrasp=0.5)
    with pytest.raises(UsageError, match=r"controller: planner: .* or give regrasp=None"):
        Controller(GUESS, held, PATH, planner=object())
    for name in ("caution", "rejection", "gains"):
        with pytest.raises(UsageError, match=rf"controller: {name}: .* write {name.capitalize()}\(\), or None"):
            Controller(GUESS, held, PATH, **{name: {}})
    with pytest.raises(UsageError, match=r"controller: estimator: CartFilter is a class; write CartFilter\(cart\)"):
        Controller(GUESS, held, PATH, estimator=CartFilter)
    with pytest.raises(UsageError, match=r"controller: arms: .* is no list; write \[Arm\(…\)\]"):
        Controller(GUESS, held[0], PATH)


@pytest.mark.parametrize("caution", [Caution(), None])
def test_the_path_begins_with_the_first_step_whatever_the_clock_says(caution):
    """Such as seconds since 1970."""
    told = {}
    for begin in (0.0, 1.7e9):
        made = Controller(GUESS, arms(), PATH, estimator=learner(), caution=caution)
        for k in range(30):
            still = cg.Measurement(begin + 0.01 * k, pose=[0, 0, 0], velocity=[0, 0, 0])
            told[begin] = made.step(still)
        assert not made.is_done
    one, other = told.values()
    np.testing.assert_allclose(one.reference.pose_sb, other.reference.pose_sb, atol=1e-6)
    np.testing.assert_allclose(one.given.wrench_b, other.given.wrench_b, atol=1e-2)


@pytest.mark.parametrize("regrasp", [TIMES, None])
@pytest.mark.parametrize(
    ("said", "why"),
    [
        (ContactChoice({"left": HERE}), "contacts: left are not the arms left, right; name all of them"),
        (ContactChoice(dict.fromkeys(("left", "right", "rigth"), HERE)), "there is no 'rigth'; did you mean right"),
        (ContactChoice({"left": HERE, "right": (0.0, 0.1)}), "contacts: right: .* 3 numbers are needed, 2 given"),
        (ContactChoice({"left": (np.nan, 0.0, 0.0), "right": HERE}), "contacts: left: .* nan is not a number"),
        ({"left": HERE, "right": HERE}, "contacts: .* is none; return ContactChoice"),
    ],
)
def test_a_source_of_contacts_says_where_every_arm_holds(regrasp, said, why):
    class Source:
        def contacts(self, query):
            return said

    controller = Controller(GUESS, arms(), PATH, contacts=Source(), regrasp=regrasp, estimator=learner())
    with pytest.raises(UsageError, match=why):
        controller.step(cg.Measurement(0.0, pose=[0, 0, 0], velocity=[0, 0, 0]))


def test_words_say_what_a_plan_lacks_and_when_the_path_is_over():
    controller = Controller(GUESS, arms(force=1.0), PathReference(chain(straight(0.3, 0.5))), period=0.05)
    assert not controller.is_done
    told = drive(controller, controller.reference.duration + 0.1)
    assert "the plan is relaxed" in told[5][0].words
    assert controller.is_done


@pytest.mark.parametrize("rate", [np.inf, 800.0])
def test_what_was_saved_is_gone_on_from_without_a_jump(tmp_path, rate):
    """After `warm_up`, with a pose alone, or with nothing seen yet: the hands give what they would have given."""
    held = [
        cg.Arm(arm.name, arm.contacts, force_limit=(120.0,) * 3, moment_limit=(15.0,) * 3, wrench_rate=(rate,) * 6)
        for arm in arms()
    ]
    robot, sensors, made = ModelPlant(CART), Sensors(CART, SensorNoise(), seed=1), Controller(CART, held, PATH)
    while robot.time < 1.0:
        step = made.step(sensors.motion(robot.time, robot.motion))
        made.observe(sensors.wrenches(robot.time, step.given))
        robot.step(step.given, 0.01)
    path, seen = made.save(tmp_path / "controller.yaml"), sensors.motion(robot.time, robot.motion)
    on = made.step(seen)
    for first in (seen, cg.Measurement(seen.time, pose=seen.pose), cg.Measurement(seen.time)):
        again = Controller.restored(path, held, PATH)
        again.warm_up()
        now = again.step(first)
        for name, wrench in now.wrenches.items():
            assert np.abs(wrench - on.wrenches[name]).max() < 4.0, name  # of a pose alone: 47 before


def test_what_was_saved_goes_to_a_filter_of_ones_own(tmp_path):
    held, seen = arms(), cg.Measurement(0.0, pose=np.zeros(3), velocity=np.zeros(3))
    made = Controller(CART, held, PATH)
    made.step(seen)
    path = made.save(tmp_path / "controller.yaml")
    again = Controller.restored(path, held, PATH, estimator=lambda cart: DisturbedFilter(cart, ["left", "right"]))
    step = again.step(cg.Measurement(0.01))
    assert step.disturbance is not None
    assert step.health != "stale"  # it knows how the cart moved
    assert dict(again.cart.first_guess.std)["mass"] == pytest.approx(step.estimate.parameters["mass"].std)


def test_wrenches_without_contacts_are_felt_where_hands_hold():
    one, other = (Controller(CART, arms(), PATH) for _ in range(2))
    for k in range(30):
        seen = cg.Measurement(0.01 * k, pose=np.array([1e-5 * k * k, 0.0, 0.0]))
        steps = [made.step(seen) for made in (one, other)]
        one.observe(cg.Measurement(0.01 * k, wrenches=steps[0].wrenches, contacts=steps[0].contacts))
        told = other.observe(cg.Measurement(0.01 * k, wrenches=steps[0].wrenches))
    assert told.health == "ok"
    np.testing.assert_array_equal(steps[0].estimate.model_parameters, steps[1].estimate.model_parameters)
    for wrong in ([30.0, 0.0, 5.0], [30.0]):
        with pytest.raises(UsageError, match=r"measurement: wrenches: left: .* is not 6 numbers"):
            other.observe(cg.Measurement(0.31, wrenches={"left": wrong, "right": [0.0] * 6}))


def test_rates_of_arms_keep_no_contact_from_being_chosen():
    """Contacts are judged over seconds."""
    quick, slow = (
        [
            cg.Arm(n, [(-0.25, y, 1.0), (0.3, y, 1.0)], wrench_rate=(rate,) * 6)
            for n, y in (("left", 0.2), ("right", -0.2))
        ]
        for rate in (np.inf, 800.0)
    )
    still = cg.Measurement(0.0, pose=np.zeros(3), velocity=np.zeros(3))
    for way in ("teach", "least-effort", "schedule"):
        whys = [Controller(CART, held, PATH, contacts=way, period=0.002).step(still).why for held in (quick, slow)]
        assert whys[0] == whys[1], way


def test_an_estimator_of_a_cart_that_rolls_otherwise_is_refused():
    bed = cg.CartModel(cg.Inertia(24.0, (0.3, 0.05), 2.2), cg.RollingConstraints(None), name="bed")
    with pytest.raises(UsageError, match="its cart, bed, rolls otherwise than cart"):
        Controller(CART, arms(), PATH, estimator=CartFilter(bed, ["left", "right"]))


@pytest.mark.parametrize("of_path", [cg.RollingConstraints(0.0, True), cg.RollingConstraints(None)])
def test_a_path_of_a_cart_that_rolls_otherwise_is_refused(of_path):
    with pytest.raises(UsageError, match=r"reference: .* rolls otherwise than cart: .*constraints=cart\.constraints"):
        Controller(CART, arms(), PathReference(chain(straight(1.0, 0.5)), of_path))


def test_a_wrench_that_is_none_is_refused_by_its_name():
    with pytest.raises(UsageError, match="wrenches: left: None is no numbers; leave out what is missing"):
        Controller(CART, arms(), PATH).observe(cg.Measurement(0.0, pose=np.zeros(3), wrenches={"left": None}))


def test_what_is_no_measurement_is_refused():
    for call in (Controller(CART, arms(), PATH).step, Controller(CART, arms(), PATH).observe):
        with pytest.raises(UsageError, match=r"controller: \[0, 0, 0\] is no Measurement; write Measurement"):
            call([0, 0, 0])


ROLLING = cg.CartModel(
    CART.inertia,
    effects=CART.effects,
    wheels=[cg.Wheel("fixed", 0.0, 0.25), cg.Wheel("fixed", 0.0, -0.25), cg.Wheel("caster", 0.7, 0.0, 0.05)],
    com_height=0.5,
)


@pytest.mark.some(4)
@pytest.mark.parametrize("kind", [CartFilter, DisturbedFilter])
@pytest.mark.parametrize("limits", [{}, {"cart_limits": [Skid(0.5)]}], ids=["free", "skid"])
@pytest.mark.parametrize(("shift", "lasts"), [(-3600.0, 1000.0), (1e6, 0.005)], ids=["set back", "one stamp ahead"])
def test_a_clock_that_jumps_leaves_the_cart_on_its_path(kind, limits, shift, lasts):
    """Estimates in the time of the stamps had been stale to the planner for an hour."""
    hands = arms()
    guess = ROLLING.with_inertia(cg.Inertia(20.0, (0.28, 0.02), 2.0))
    told = kind(guess, [arm.name for arm in hands], noise=FilterNoise(force=1.0, moment=0.05))
    controller = Controller(guess, hands, PATH, estimator=told, **limits)
    plant, off = ModelPlant(ROLLING), []
    sensors = Sensors(ROLLING, SensorNoise(force=1.0, moment=0.05), seed=3)
    while plant.time < 6.0:
        late = shift if 0.0 <= plant.time - 2.0 < lasts else 0.0
        sensed = sensors.motion(plant.time, plant.motion)
        step = controller.step(replace(sensed, time=sensed.time + late))
        felt = sensors.wrenches(plant.time, step.given)
        controller.observe(replace(felt, time=felt.time + late))
        plant.step(step.given, controller.period)
        off.append(np.hypot(*(step.reference.pose_sb - plant.motion.pose_sb)[:2]))
        if plant.time > 3.0:
            assert step.plan.status in ("optimal", "relaxed")
    assert max(off) < 0.25  # m: what the path goes in the 0.5 s until the clock is believed
    assert max(off[-100:]) < 0.03
