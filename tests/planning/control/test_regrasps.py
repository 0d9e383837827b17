"""While a hand is on its way, limits of the cart hold for all that is given; no wrench changes faster than it may."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import cartgrasp as cg
from cartgrasp.effects import ViscousDrag
from cartgrasp.errors import UsageError
from cartgrasp.floor_reaction import FloorReaction
from cartgrasp.roles import ContactChoice
from cartgrasp.studies.shopping_cart import WHEELS
from estimation import CartFilter, FilterNoise
from planning import Caution, Controller, LeastSideForce, PathReference, TipOver, WrenchPlanner, chain, pause, straight
from planning.contact_sources.choosing import Choosing
from planning.control.hand import Phase, RegraspTimes
from planning.control.regrasps import LOOKS_PER_TICK, Ahead, Regrasps
from planning.references import speed_change, turn

from .driving import ticks

DRAG = ViscousDrag(linear=3.0, angular=1.2)
CART = cg.CartModel(cg.Inertia(26.0, (0.3, 0.03), 2.4), effects=(DRAG,), wheels=WHEELS, com_height=0.45)
BRAKES = PathReference(chain(speed_change(0.8, 0.8), pause(0.6), speed_change(-0.8, 1.0), pause(1.0)))
CURVES = PathReference(chain(speed_change(0.8, 0.6), turn(1.2, 0.6), turn(-1.2, 0.6), speed_change(-0.8, 0.6)))

SIDES = (("left", 0.2), ("right", -0.2))


def arms(rate=np.inf, far=0.1):
    return [
        cg.Arm(
            name,
            [(-0.25, y, 1.0), (far, y, 0.9)],
            force_limit=(120.0,) * 3,
            moment_limit=(15.0,) * 3,
            wrench_rate=(rate,) * 6,
        )
        for name, y in SIDES
    ]


class Leaves:
    """The left hand's second place from a time on."""

    def __init__(self, held, time):
        self.points, self.time = {arm.name: [np.array(p) for p in arm.contacts.points] for arm in held}, time

    def contacts(self, query):
        left = int(query.time > self.time)
        return ContactChoice({"left": self.points["left"][left], "right": self.points["right"][0]}, "told")


def drive(reference, leaves, rate=np.inf, far=0.1, duration=None, **parts):
    """The steps of a run."""
    held, names = arms(rate, far), ["left", "right"]
    learner = CartFilter(CART, names, noise=FilterNoise(force=1.0, moment=0.05))
    controller = Controller(CART, held, reference, contacts=Leaves(held, leaves), estimator=learner, **parts)
    return [tick.step for tick in ticks(controller, CART, duration or reference.duration)]


@pytest.mark.some(2)
@pytest.mark.parametrize("leaves", [1.5, 1.65])
@pytest.mark.parametrize(("least", "confidence"), [(43.0, None), (20.0, 0.9)])
def test_limits_hold_for_what_all_hands_give(leaves, least, confidence):
    """`least` N of each wheel, which braking would have; with margins it keeps farther off."""
    limits = {"cart_limits": [TipOver(least)], "confidence": confidence, "learn": False, "caution": None}
    steps = drive(BRAKES, leaves, far=-0.1, **limits)
    assert {step.hands["left"].phase for step in steps} == set(Phase)
    bites = 0
    for step in steps:
        given, floor = (
            step.given.spatial_wrench_b,
            FloorReaction.of(step.estimate.cart_on_floor(), step.estimate.motion),
        )
        np.testing.assert_allclose(step.plan.cart_wrench, step.given.wrench_b, atol=1e-9)
        np.testing.assert_allclose(step.plan.wheel_loads, floor.loads(given), atol=1e-6)
        if step.plan.is_usable:
            assert floor.loads(given).min() >= least - 1e-6, (step.time, step.hands["left"].phase)
            bites += step.hands["left"].phase is not Phase.HOLDS and floor.loads(given).min() < least + 1e-3
    assert bites or confidence


def test_wheels_are_told_for_the_estimate_without_limits_too():
    for step in drive(CURVES, 1.0, duration=2.0):
        floor = FloorReaction.of(step.estimate.cart_on_floor(), step.estimate.motion)
        assert step.plan.wheel_side_force == pytest.approx(floor.lateral(step.given.spatial_wrench_b), abs=1e-9)


@pytest.mark.parametrize("rate", [40.0, 400.0])
def test_no_wrench_changes_faster_than_its_arm_may(rate):
    steps = drive(CURVES, 1.0, rate)
    given = {name: np.array([step.wrenches[name] for step in steps]) for name in ("left", "right")}
    for values in given.values():
        assert np.abs(np.diff(values, axis=0, prepend=0.0)).max() <= rate * 0.01 * (1 + 1e-9)
    away = np.array([step.hands["left"].is_away for step in steps])
    assert away.any()
    assert not given["left"][away].any()
    assert steps[-1].hands["left"].point == (0.1, 0.2, 0.9)


def test_it_gives_what_is_least_by_its_objective():
    usual, spares = (drive(CURVES, np.inf, objective=objective) for objective in (None, LeastSideForce(100.0)))
    side = [np.sqrt(np.mean([step.plan.wheel_side_force**2 for step in steps])) for steps in (usual, spares)]
    assert side[1] < 0.2 * side[0]
    with pytest.raises(UsageError, match="objective, cart_limits and confidence are the planner's"):
        Controller(CART, arms(), CURVES, planner=WrenchPlanner(CART, arms()), objective=LeastSideForce())


@pytest.mark.parametrize("caution", [Caution(), None])
def test_a_tick_that_is_refused_is_none(caution):
    """Asked again, path and clocks go on once."""

    class Fails(Leaves):
        refuses = False

        def contacts(self, query):
            return "nowhere" if self.refuses else super().contacts(query)

    found = []
    for refuses in (False, True):
        source = Fails(arms(), 9.0)
        controller = Controller(CART, arms(), BRAKES, contacts=source, caution=caution, learn=False)
        for k in range(60):
            for source.refuses in (refuses and k % 3 == 2, False):
                if source.refuses:
                    with pytest.raises(UsageError, match="nowhere"):
                        controller.step(at(0.01 * k))
            step = controller.step(at(0.01 * k))
        found.append(step.reference)
    np.testing.assert_allclose(found[1].pose_sb, found[0].pose_sb, rtol=1e-9)
    np.testing.assert_allclose(found[1].velocity, found[0].velocity, rtol=1e-9)


def test_a_sample_that_is_refused_says_nothing_of_arms():
    controller = scripted()
    for k in range(60):
        controller.step(at(0.01 * k))
        with pytest.raises(UsageError, match="pose"):
            controller.observe(cg.Measurement(0.01 * k + 0.005, pose=[0.0, 0.0], wrenches=SLACK))
    assert not controller.step(at(0.6)).idle


def test_a_hand_that_is_away_is_not_counted_on_where_another_arm_comes_back(hands):
    """The first by name is the one that comes back."""
    there = {"left": np.array([-0.25, 0.2, 1.0]), "right": np.array([0.1, -0.2, 0.9])}
    looked_ahead(hands, there, still([1.0, 0.0, 0.0]), 0.0)
    for _ in range(30):
        hands.go_on(0.01, {"left"})
    assert hands.hands["right"].is_away
    hands.go_on(0.01)
    given = hands.plan(np.array([10.0, 0.0, 0.0])).wrenches
    assert given.away == {"right"}


def test_a_lone_hand_may_leave_a_cart_that_coasts_as_slowly_as_its_path_goes_on():
    """A cart at half of its path's speed was compared with a path at its whole speed."""
    hand = arms()[:1]
    path = PathReference(chain(straight(20.0, 0.4)))
    rolling = cg.Motion(np.array([2.0, 0.0, 0.0]), np.array([0.2, 0.0]))
    cart = replace(CART, effects=())
    for pace, leaves in ((0.5, True), (1.0, False)):
        made = Regrasps(WrenchPlanner(cart, hand, relax=np.inf), hand, RegraspTimes(), 0.05)
        made.begin({"left": np.array([-0.25, 0.2, 1.0])})
        ahead = Ahead(path, cart, rolling, path_time(path, 2.0), np.zeros(3), pace=pace)
        made.send({"left": AWAY["left"]}, ahead, 0.0)
        assert (made.hands["left"].phase is not Phase.HOLDS) is leaves


def path_time(path, x):
    """s, by when a path along x is at x (m)."""
    times = np.linspace(0.0, path.duration, 2001)
    return float(np.interp(x, [path.at(time).pose_sb[0] for time in times], times))


def still(wrench, time=0.0):
    """A cart at rest that is to stay, and a wrench (3,) for now."""
    rest = cg.Motion(np.zeros(3), np.zeros(2))
    return Ahead(PathReference(chain(pause(9.0))), CART, rest, time, np.asarray(wrench, dtype=float))


def looked_ahead(hands, contacts, ahead, time):
    """Asked in as many ticks as it takes to look ahead for a regrasp of 4 s."""
    for _ in range(25):
        hands.send(contacts, ahead, time)


@pytest.fixture
def hands():
    """Of two arms, which hold at their first places."""
    made = Regrasps(WrenchPlanner(CART, arms(), relax=np.inf), arms(), RegraspTimes(), 0.05)
    made.begin({"left": np.array([-0.25, 0.2, 1.0]), "right": np.array([-0.25, -0.2, 1.0])})
    return made


AWAY = {"left": np.array([0.1, 0.2, 0.9]), "right": np.array([-0.25, -0.2, 1.0])}


def test_a_hand_that_may_not_go_is_asked_again_while_the_path_waits(hands):
    """The time along the path stands still then, and with it stood the answer."""
    looked_ahead(hands, AWAY, still([500.0, 0.0, 0.0]), 0.0)
    assert "can't bear" in hands.kept["left"]
    looked_ahead(hands, AWAY, still([5.0, 0.0, 0.0]), 1.0)
    assert hands.hands["left"].phase is not Phase.HOLDS


def test_no_hand_leaves_the_cart_to_an_arm_that_gives_little(hands):
    hands.go_on(0.01, {"right"})
    hands.send(AWAY, still([5.0, 0.0, 0.0]), 0.0)
    assert hands.kept["left"] == "right gives little of what it is told"
    hands.go_on(0.01)
    for _ in range(200):
        hands.go_on(0.01)
    looked_ahead(hands, AWAY, still([5.0, 0.0, 0.0]), 5.0)
    assert hands.hands["left"].phase is not Phase.HOLDS


def test_no_hand_goes_where_another_holds_nor_past_it():
    """Hands go one by one: one that is to hold where another does waits until that is gone, or for good."""
    here, there, beyond = (-0.25, 0.2, 1.0), (-0.25, -0.2, 1.0), (-0.25, -0.5, 1.0)
    held = [cg.Arm(name, [here, there, beyond]) for name in ("left", "right")]
    made = Regrasps(WrenchPlanner(CART, held, relax=np.inf), held, RegraspTimes(), 0.05, 0.3)
    for left, right, leaves in ((there, here, None), (beyond, there, None), (there, beyond, "right")):
        made.begin({"left": np.array(here), "right": np.array(there)})
        looked_ahead(made, {"left": np.array(left), "right": np.array(right)}, still([1.0, 0.0, 0.0]), 0.0)
        assert made.busy == leaves
        assert made.kept["left"] == "it would come nearer than 0.3 m to right"


def test_hands_of_a_controller_stay_apart_while_they_change_places():
    points = [(-0.25, y, 1.0) for y in (0.3, 0.1, -0.1, -0.3)]
    held = [cg.Arm("left", points[:3]), cg.Arm("right", points[1:][::-1])]
    choosing = Choosing(every=0.5, min_hand_distance=0.15)
    controller = Controller(CART, held, CURVES, contacts="periodic", choosing=choosing, caution=None)
    steps = [tick.step for tick in ticks(controller, CART, CURVES.duration)]
    apart = [np.linalg.norm(step.contacts["left"] - step.contacts["right"]) for step in steps]
    assert min(apart) >= 0.15 - 1e-9
    assert max(apart) > 0.5


def scripted(reference=BRAKES):
    return Controller(CART, arms(), reference, contacts=Leaves(arms(), 0.1), caution=None, learn=False)


SLACK = {"left": np.zeros(6), "right": np.zeros(6)}


def at(time, **parts):
    return cg.Measurement(time, np.zeros(3), np.zeros(3), **parts)


@pytest.mark.parametrize("phase", [Phase.UNLOADS, Phase.MOVES, Phase.LOADS])
def test_hands_go_no_farther_in_a_pause(phase):
    """Neither along a ramp nor along their way, as the path does not."""
    controller = scripted(PathReference(chain(pause(9.0))))
    for time in 0.01 * np.arange(400):
        step = controller.step(at(time, wrenches=SLACK))
        if step.hands["left"].phase is phase:
            break
    assert step.hands["left"].phase is phase
    later = controller.step(at(time + 5.0, wrenches=SLACK))
    assert later.hands["left"] == step.hands["left"]
    assert np.abs(later.wrenches["left"] - step.wrenches["left"]).max() < 20.0


def test_stamps_out_of_order_make_no_time():
    """Each second one 10 ms back: the path went twice as fast."""
    controller = scripted()
    for k in range(60):
        controller.step(at(0.01 * k))
        controller.step(at(0.01 * k - 0.01))
    steady = scripted()
    for k in range(60):
        steady.step(at(0.01 * k))
    found, expected = (one.step(at(0.6)).reference for one in (controller, steady))
    np.testing.assert_allclose(found.pose_sb, expected.pose_sb, atol=1e-9)
    np.testing.assert_allclose(found.velocity, expected.velocity, atol=1e-9)


def test_arms_that_tell_in_turn_are_watched_each():
    controller, idle = scripted(), []
    for k in range(60):
        step = controller.step(at(0.01 * k))
        idle.append(step.idle)
        for arm, share in (("left", 1.0), ("right", 0.0)):
            controller.observe(cg.Measurement(0.01 * k + 0.001, wrenches={arm: share * step.wrenches[arm]}))
    assert {name for one in idle for name in one} == {"right"}
    assert "right" in idle[35]


@pytest.mark.some(2)
@pytest.mark.parametrize("begins", [3.0, 3.13, 3.26])
def test_a_hand_stays_for_a_turn_that_begins_and_ends_on_its_way(begins):
    """The turn's onset takes 0.6 s, the regrasp 3.2 s; asked again each 0.2 s, the hand would leave between."""
    bed = cg.CartModel(cg.Inertia(120.0, (0.9, 0.0), 45.0), effects=(DRAG,))
    limits = {"force_limit": (120, 100, 60), "moment_limit": (15, 15, 15)}
    held = [cg.Arm(name, [(-0.25, y, 1.0), (1.05, y, 1.0)], **limits) for name, y in SIDES]
    path = PathReference(chain(speed_change(0.6), pause(begins - 1.2), turn(0.9, 0.3), pause(3.0), speed_change(-0.6)))
    learner = CartFilter(bed, ["left", "right"], noise=FilterNoise(force=1.0, moment=0.05))
    controller = Controller(bed, held, path, contacts=Leaves(held, 0.8), estimator=learner)
    steps = [tick.step for tick in ticks(controller, bed, path.duration)]
    assert {step.hands["left"].phase for step in steps} == set(Phase)
    assert {step.plan.status for step in steps} == {"optimal"}


@pytest.mark.parametrize("speed", [0.5, 0.05])
def test_no_tick_makes_many_plans(speed, monkeypatch):
    """A hand that was to be away for 8 s had one make 80."""
    made, plan_or_hold = [0], WrenchPlanner.plan_or_hold

    def counted(*args, **parts):
        made[-1] += 1
        return plan_or_hold(*args, **parts)

    monkeypatch.setattr(WrenchPlanner, "plan_or_hold", counted)
    path, held = PathReference(chain(speed_change(0.4), pause(12.0), speed_change(-0.4))), arms()
    controller, phases = Controller(CART, held, path, contacts=Leaves(held, 2.0), regrasp=RegraspTimes(speed)), set()
    for tick in ticks(controller, CART, 4.0):
        phases.add(tick.step.hands["left"].phase)
        made.append(0)
    assert Phase.UNLOADS in phases
    assert max(made) <= 3 + LOOKS_PER_TICK  # for now, of all hands, and of the others


def test_a_look_ahead_ends_where_another_place_is_asked_for(hands):
    """What was seen for the one is not taken for the other's."""
    near, sent = {"left": np.array([-0.2, 0.2, 1.0]), "right": AWAY["right"]}, [0, 0]
    for k, before in enumerate((0, 5)):
        hands.begin({"left": np.array([-0.25, 0.2, 1.0]), "right": AWAY["right"]})
        for _ in range(before):
            hands.send(AWAY, still([5.0, 0.0, 0.0]), 0.0)
        while hands.busy is None:
            hands.send(near, still([5.0, 0.0, 0.0]), 0.0)
            sent[k] += 1
    assert sent[0] == sent[1] > 1
