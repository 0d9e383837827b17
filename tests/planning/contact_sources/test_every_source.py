"""One exam for every way to choose contacts; then what each promises beside."""

from __future__ import annotations

from dataclasses import replace
from itertools import product

import numpy as np
import pytest

import cartgrasp as cg
from cartgrasp.constraints import RollingConstraints
from cartgrasp.effects import CasterRealignment, ViscousDrag
from cartgrasp.errors import UsageError
from cartgrasp.inertia import physical_jacobian
from cartgrasp.information import (
    KNOWN_INFORMATION,
    covariance_after,
    information_of,
    parameter_regressor,
    reduced_noise,
)
from cartgrasp.roles import ContactQuery
from cartgrasp.wheels import Wheel
from estimation import CartFilter, Prior
from planning import Choosing, Controller, PathReference, RegraspTimes, WrenchPlanner, chain, pause, plan_schedule
from planning.contact_sources.by_name import contact_source
from planning.contact_sources.lookahead import ContactFamily
from planning.contact_sources.strategies import STRATEGIES
from planning.references import speed_change, turn
from planning.schedule.schedule import Grip, Horizon, RegraspCost, wanted_wrench

CART = cg.CartModel(cg.Inertia(24.0, (-0.35, 0.06), 2.6), effects=(ViscousDrag(3.0, 1.2),))
ALL_CASTERS = cg.CartModel(CART.inertia, RollingConstraints(None), CART.effects)
PATH = PathReference(chain(speed_change(0.5), turn(0.8, 0.4), pause(1.0), turn(-0.8, 0.4), speed_change(-0.5)))
TIMES = RegraspTimes()
CHOOSING = Choosing(every=1.0, ahead=1.0, min_hand_distance=0.3, noise=cg.WrenchNoise(1.0, 0.05))


def arms(force=80.0, names=("left", "right")):
    sides = {"left": 1, "right": -1}
    places = ((-0.9, 0.2, 1.0), (-0.45, 0.3, 0.8), (0.0, 0.3, 0.8))
    return [
        cg.Arm(n, [(x, sides[n] * y, z) for x, y, z in places], force_limit=(force,) * 3, moment_limit=(15.0,) * 3)
        for n in names
    ]


def estimate(cart=CART, known=(), time=0.0, reference=PATH):
    """What a filter that has learned nothing says."""
    wanted = reference.at(time)
    velocity = cg.frames.body_to_world(wanted.pose_sb[2]) @ cart.basis_b @ wanted.velocity
    return CartFilter(cart, ["left", "right"], prior=Prior(known=known)).update(
        cg.Measurement(time, wanted.pose_sb, velocity)
    )


def query(time=0.0, held=None, given=None, cart=CART):
    return ContactQuery(time, wanted_wrench(PATH, cart, time), given, held or {})


@pytest.fixture(params=STRATEGIES)
def way(request):
    return request.param


def source(way, cart=CART, holders=None, reference=PATH, choosing=CHOOSING):
    return contact_source(way, cart, holders or arms(), reference, choosing, TIMES)


# --- the exam ----------------------------------------------------------------------------------------------


def test_every_arm_holds_one_of_its_points_and_it_is_said_why(way):
    one, held = source(way), {}
    points = {arm.name: [tuple(p) for p in arm.contacts.points] for arm in arms()}
    for time in np.arange(0.0, PATH.duration + 1.0, 0.25).tolist():
        choice = one.contacts(query(time, held, estimate(time=time)))
        held = dict(choice.contacts)
        assert list(held) == ["left", "right"]
        assert all(tuple(held[name]) in points[name] for name in held)
        assert choice.why
        if way in ("least-effort", "teach", "schedule"):
            assert np.linalg.norm(held["left"] - held["right"]) >= CHOOSING.min_hand_distance - 1e-9


@pytest.mark.parametrize("given", ["none", "known for sure", "no covariance", "no constraint"])
def test_it_takes_any_estimate(way, given):
    """Also one whose covariance has no inverse."""
    cart = ALL_CASTERS if given == "no constraint" else CART
    path = PathReference(PATH.stretches, cart.constraints)
    one = source(way, cart, reference=path)
    if given == "known for sure":
        told = estimate(known={"mass", "com_x", "com_y", "inertia", "viscous_drag"})
        assert np.linalg.matrix_rank(told.covariance) == 0
    else:
        told = None if given == "none" else estimate(cart, reference=path)
        told = told._replace(covariance=None) if given == "no covariance" else told
    for time in (0.0, 1.5, 3.0):
        choice = one.contacts(ContactQuery(time, np.array([20.0, 0.0, 1.0]), told, {}))
        assert set(choice.contacts) == {"left", "right"}


def test_the_same_questions_have_the_same_answers(way):
    told = [estimate(time=t) for t in (0.0, 1.0, 2.0, 3.0)]
    runs = [[source(way).contacts(query(0.0, {}, told[0])).contacts["left"].tolist()] for _ in range(2)]
    for run in runs:
        one, held = source(way), {}
        for time, known in enumerate(told):
            held = dict(one.contacts(query(float(time), held, known)).contacts)
            run += held["left"].tolist() + held["right"].tolist()
    assert runs[0] == runs[1]


def test_it_waits_for_a_hand_that_is_on_its_way(way):
    """A hand between two contacts is no place to choose from: nothing is asked anew of the others."""
    one = source(way)
    first = dict(one.contacts(query(0.0, {}, estimate())).contacts)
    between = {"left": np.array([-0.7, 0.25, 0.9]), "right": first["right"]}
    found = one.contacts(query(1.2, between, estimate(time=1.2))).contacts
    assert all(np.isfinite(point).all() for point in found.values())
    if way in ("teach", "schedule"):
        assert np.array_equal(found["right"], first["right"])


def test_hands_stay_where_a_source_begins_at_the_end_of_the_path(way):
    """As after a restart: there is nothing left to go elsewhere for."""
    held = {arm.name: np.array(arm.contacts.points[1]) for arm in arms()}
    for over in (0.0, 1.0):
        found = source(way).contacts(ContactQuery(PATH.duration + over, np.zeros(3), None, held)).contacts
        if way in ("least-effort", "teach", "schedule"):
            assert all(np.array_equal(found[name], held[name]) for name in held)


@pytest.mark.some(5)
@pytest.mark.parametrize("force", [80.0, 1.0])
def test_hands_keep_their_distance_from_the_first_choice_on(way, force):
    """Also where the first candidates do not, and where nothing can drive the path."""
    near = [
        cg.Arm(name, [(-0.45, 0.1 * side, 0.8), (-0.9, 0.2 * side, 1.0)], force_limit=(force,) * 3)
        for name, side in (("left", 1), ("right", -1))
    ]
    if way in ("fixed", "periodic"):
        with pytest.raises(UsageError, match=r"left and right come as near as 0\.2 m, and min_hand_distance is 0\.3 m"):
            source(way, holders=near)
        return
    for begin in (0.0, 1.5, PATH.duration):
        one, held = source(way, holders=near), {}
        for time in (begin, begin + 0.5, begin + 1.5):
            held = dict(one.contacts(query(time, held, estimate(time=time))).contacts)
            assert np.linalg.norm(held["left"] - held["right"]) >= 0.3 - 1e-9


class NoPostureInFront:
    bears = cg.JointTorques(np.eye(6), np.zeros(6), np.full(6, 90.0))

    def joints_at(self, contact, yaw):
        if contact[0] > -0.1:
            raise UsageError("no posture there")
        return self.bears


def test_no_hand_is_sent_where_it_can_not_hold(way):
    """What is beyond reach, at first and later, or has no posture."""
    short = {"reach": cg.Reach.box((-0.6, -1.0, 0.0), (1.0, 1.0, 2.0)), "joints": NoPostureInFront()}
    hands = [cg.Arm(arm.name, arm.contacts.points, **short) for arm in arms()]
    one, held = source(way, holders=hands), {}
    for time in np.arange(0.0, PATH.duration, 0.5).tolist():
        held = dict(one.contacts(query(time, held, estimate(time=time))).contacts)
        assert [held["left"].tolist(), held["right"].tolist()] == [[-0.45, 0.3, 0.8], [-0.45, -0.3, 0.8]]


def test_a_controller_drives_with_it(way):
    controller = Controller(CART, arms(), PATH, contacts=way, choosing=CHOOSING)
    for time in (0.0, 0.01, 0.02):
        step = controller.step(cg.Measurement(time, np.zeros(3), np.zeros(3)))
        assert step.plan.status == "optimal"
        assert step.words.count("holds") == 2


# --- what they promise -------------------------------------------------------------------------------------


def test_what_teaches_most_is_taken_while_it_is_not_known():
    """Against every choice worked out one by one, with inverses in place of the update."""
    asked = {"com_x": 0.001, "com_y": 0.001}
    choosing = replace(CHOOSING, asked=asked, extra_effort=1e6, regrasp_effort=0.0, min_hand_distance=0.0)
    told = estimate(time=0.0)
    found = source("teach", choosing=choosing).contacts(query(0.0, {}, told))
    assert found.why == "teaches com_y"
    times = (np.arange(10) + 0.5) * 0.1
    wanted = [PATH.at(t) for t in times]
    states = np.array([CART.state(w.pose_sb, w.velocity) for w in wanted])
    rows = parameter_regressor(told.cart(), states, np.array([w.acceleration for w in wanted]))
    to_physical = physical_jacobian(told.model_parameters[:4])[1:3]
    best = {}
    for left, right in product(*(arm.contacts.points for arm in arms())):
        noise = np.linalg.inv(reduced_noise(CART, [left, right], choosing.noise))
        taught = 10 * sum(row.T @ noise @ row for row in rows)
        after = np.linalg.inv(np.linalg.inv(told.covariance) + taught)[:4, :4]
        best[left, right] = float(np.prod(np.sqrt(np.diag(to_physical @ after @ to_physical.T))))
    least, most = min(best.values()), max(best.values())
    assert best[tuple(found.contacts["left"]), tuple(found.contacts["right"])] <= 1.001 * least
    assert most > 1.1 * least


def test_once_known_the_least_effort_is_taken_with_the_cost_of_switching():
    """By the planner's own plans at every choice."""
    known = estimate(time=2.0, known={"com_x", "com_y"})
    planner = WrenchPlanner(CART, arms())
    times = 2.0 + (np.arange(10) + 0.5) * 0.1
    wrenches = [wanted_wrench(PATH, known.cart(), t) for t in times]
    efforts = {
        (left, right): np.mean([planner.plan(w, contacts={"left": left, "right": right}).effort for w in wrenches])
        for left, right in product(*(arm.contacts.points for arm in arms()))
        if np.linalg.norm(np.subtract(left, right)) >= 0.3
    }
    (left, right), least = min(efforts.items(), key=lambda item: item[1])
    (p, q), most = max(efforts.items(), key=lambda item: item[1])
    worst = {"left": np.array(p), "right": np.array(q)}
    moves = (left != p) + (right != q)
    left, quick = PATH.duration - 2.0, RegraspTimes(10.0, 0.0, 0.0, 0.0)
    for cost, moved in (((most - least) / moves * 0.8 * left, True), ((most - least) * 1.1 * left, False)):
        dear = replace(CHOOSING, regrasp_effort=cost)
        found = contact_source("teach", CART, arms(), PATH, dear, quick).contacts(query(2.0, worst, known))
        assert found.why == "least effort"
        assert (tuple(found.contacts["left"]), tuple(found.contacts["right"])) != (p, q) if moved else True
        if not moved:
            assert (tuple(found.contacts["left"]), tuple(found.contacts["right"])) == (p, q)
    free = source("teach").contacts(query(2.0, {}, known))
    assert efforts[tuple(free.contacts["left"]), tuple(free.contacts["right"])] == pytest.approx(least)


def test_nothing_is_spent_where_the_floor_is_louder_than_the_sensors():
    """Casters with a stiff swivel leave the moment open by more than any lever arm does."""
    wheels = [Wheel("fixed", 0.0, y) for y in (0.27, -0.27)] + [
        Wheel("caster", -0.8, y, trail=0.045) for y in (0.25, -0.25)
    ]
    dear = replace(CHOOSING, every=3.0, ahead=3.0, extra_effort=10.0, regrasp_effort=0.0)
    handle = {"left": np.array([-0.9, 0.2, 1.0]), "right": np.array([-0.9, -0.2, 1.0])}
    for torque, moves in ((0.0, True), (2.0, False)):
        effects = (*CART.effects, CasterRealignment(torque)) if torque else CART.effects
        cart = cg.CartModel(CART.inertia, effects=effects, wheels=wheels)
        told = estimate(cart, time=0.0, known={"viscous_drag"})
        found = source("teach", cart, choosing=dear).contacts(query(0.0, handle, told, cart)).contacts
        assert any(not np.array_equal(found[name], handle[name]) for name in handle) == moves


def test_a_wrench_that_is_no_number_is_left_out_of_the_mean():
    asked, found = (24.0, 0.0, 8.0), []
    for second in (asked, (np.nan, 0.0, 8.0)):
        one, held = source("least-effort"), {arm.name: np.array(arm.contacts.points[1]) for arm in arms()}
        for time, wrench in ((0.0, asked), (0.5, second), (1.0, asked), (2.0, asked)):
            held = dict(one.contacts(ContactQuery(time, np.array(wrench), None, held)).contacts)
        found.append(held)
    assert not np.array_equal(found[0]["left"], arms()[0].contacts.points[1])
    assert all(np.array_equal(found[0][name], found[1][name]) for name in found[0])


def test_what_a_regrasp_costs():
    """By plans of the other arm alone, which bears everything for as long as the hand is away."""
    family = ContactFamily.of(CART, arms(force=1e3), CHOOSING.noise, 0.0)
    outlook = family.ahead(CART, PATH, (2.0, 3.0))
    held = {"left": np.array([-0.9, 0.2, 1.0]), "right": np.array([-0.45, -0.3, 0.8])}
    left_moves = {**held, "left": np.array([0.0, 0.3, 0.8])}
    both, alone = WrenchPlanner(CART, arms(force=1e3)), WrenchPlanner(CART, arms(force=1e3)[1:])
    more = [
        alone.plan(w, contacts={"right": held["right"]}).effort - both.plan(w, contacts=held).effort
        for w in outlook.wrenches
    ]
    start, end = family.index_of(held), family.index_of(left_moves)
    found = outlook.regrasps(start, TIMES, 7.0)
    lasting = TIMES.lasting(np.linalg.norm(left_moves["left"] - held["left"]))
    assert found[end] == pytest.approx(7.0 + lasting * np.mean(more), rel=1e-6)
    assert found[start] == 0.0
    single = ContactFamily.of(CART, arms(names=["left"]), CHOOSING.noise, 0.0).ahead(CART, PATH, (2.0, 3.0))
    away = TIMES.lasting(np.linalg.norm(single.family.choices[:, 0] - single.family.choices[0, 0], axis=1))
    made_up_for = single.lowest[0] * away * (away > TIMES.lasting(0.0))
    assert np.allclose(single.regrasps(0, TIMES, 7.0), np.array([0.0, 7.0, 7.0]) + made_up_for)


def test_what_is_spent_on_learning_is_within_what_is_allowed():
    told = estimate(time=0.0)
    planner = WrenchPlanner(CART, arms())
    wrenches = [wanted_wrench(PATH, told.cart(), t) for t in 0.05 + 0.1 * np.arange(10)]

    def effort(contacts):
        return np.mean([planner.plan(w, contacts=contacts).effort for w in wrenches])

    for extra in (0.0, 0.1, 1.0):
        choosing = replace(CHOOSING, extra_effort=extra, min_hand_distance=0.0)
        found = source("teach", choosing=choosing).contacts(query(0.0, {}, told)).contacts
        every = product(*(arm.contacts.points for arm in arms()))
        least = min(effort({"left": left, "right": right}) for left, right in every)
        assert effort(found) <= (1 + extra) * least + 1.0 + 1e-9


def test_a_schedule_is_followed_and_made_anew_for_another_estimate():
    one, choosing = source("schedule"), CHOOSING
    heavy = CART.with_inertia(cg.Inertia(60.0, (0.6, -0.2), 6.0))
    first = one.contacts(query(0.0, {}, estimate())).contacts
    cost = RegraspCost(TIMES.lasting(np.linalg.norm([0.9, 0.1, 0.2])), choosing.regrasp_effort)
    expected = plan_schedule(PATH, CART, arms(), cost, Horizon(0.0, 0.05, None, 0.3, 1.0))
    for name, grip in expected.grips(0.0).items():
        assert np.array_equal(first[name], grip.contact)
    now = estimate(heavy, time=1.0)
    then = one.contacts(query(1.0, first, now)).contacts
    held = {name: Grip(point) for name, point in first.items()}
    anew = plan_schedule(PATH, now.cart(), arms(), cost, Horizon(1.0, 0.05, held, 0.3, 1.0))
    for name, grip in anew.grips(1.0).items():
        assert np.array_equal(then[name], grip.contact)


@pytest.mark.long
def test_what_cannot_be_driven_is_said():
    weak = arms(force=1.0)
    for way, words in (("teach", "no contacts can drive the time ahead"), ("schedule", "no schedule: ")):
        assert source(way, holders=weak).contacts(query(0.0, {}, estimate())).why.startswith(words)


def test_what_is_asked_is_checked():
    for wrong in (
        {"every": 0.0},
        {"ahead": 0.0},
        {"asked": {"com_z": 0.02}},
        {"asked": {"mass": 0.0}},
        {"extra_effort": -1.0},
    ):
        with pytest.raises(UsageError, match="choosing: "):
            Choosing(**wrong)
    segment = [cg.Arm("left", segment=[(-0.25, -0.2, 1.0), (-0.25, 0.2, 1.0)])]
    for way in ("teach", "schedule"):
        with pytest.raises(UsageError, match="may hold anywhere on a segment; list points"):
            source(way, holders=segment)


# --- what is known for sure --------------------------------------------------------------------------------


def test_learning_where_something_is_known_for_sure():
    """The update against the inverse of what is free alone."""
    random = np.random.default_rng(1)
    half, rows = random.normal(size=(6, 4)), random.normal(size=(9, 6))
    free, information = [0, 2, 3, 5], rows.T @ rows
    covariance = np.zeros((6, 6))
    covariance[np.ix_(free, free)] = half[:4] @ half[:4].T
    after = covariance_after(covariance, information)
    expected = np.linalg.inv(np.linalg.inv(half[:4] @ half[:4].T) + information[np.ix_(free, free)])
    assert np.allclose(after[np.ix_(free, free)], expected)
    assert np.abs(after[[1, 4]]).max() < 1e-15
    told = information_of(covariance)
    assert told[1, 1] == told[4, 4] == KNOWN_INFORMATION
    assert np.allclose(told[np.ix_(free, free)], np.linalg.inv(half[:4] @ half[:4].T))
    learned = np.linalg.inv(told + information)
    assert np.allclose(learned[np.ix_(free, free)], expected, rtol=1e-4)
