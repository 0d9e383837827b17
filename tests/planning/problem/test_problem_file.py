"""PROBLEM.yaml: what is accepted, and where exactly a mistake is."""

from __future__ import annotations

import re

import numpy as np
import pytest

from cartgrasp.arms import Friction
from cartgrasp.contacts import Segment
from cartgrasp.errors import FileError
from cartgrasp.friction import SoftFinger
from planning import InternalForce, SideForce, Skid, TipOver, WrenchPlanner
from planning.problem.problem_file import read_problem

CART = """\
name: shopping cart
mass: 24.0
com: [0.30, 0.00]
inertia: 2.0
constraints:
  - no_lateral_slip: {x: 0.0}
"""
PROBLEM = """\
cart: cart.yaml
wrench: [40.0, 0.0, 3.0]
arms:
  - name: left
    contacts: [[-0.25, 0.20, 1.0]]
    yaw: 0.1
    limits: {force: [60, 60, 40], moment: [8, 8, 6]}
    friction: {mu: 0.6, sides: 6}
    weights: [1, 1, 1, 20, 20, 20]
  - name: right
    contacts: [[-0.25, -0.20, 1.0], [-0.25, -0.1, 1.0]]
    segment: [[-0.25, -0.25, 1.0], [-0.25, 0.25, 1.0]]
min_hand_distance: 0.1
"""


def problem_file(folder, text):
    (folder / "cart.yaml").write_text(CART)
    path = folder / "problem.yaml"
    path.write_text(text)
    return path


def test_everything_that_is_said(tmp_path):
    problem = read_problem(problem_file(tmp_path, PROBLEM))
    left, right = problem.arms
    assert problem.wrench == (40.0, 0.0, 3.0)
    assert problem.min_hand_distance == 0.1
    assert problem.cart.name == "shopping cart"
    assert left.contacts.points == ((-0.25, 0.2, 1.0),)
    assert left.yaw == 0.1
    assert left.wrench_limit == pytest.approx([60, 60, 40, 8, 8, 6])
    assert left.friction == Friction(0.6, 6)
    assert left.weights == (1, 1, 1, 20, 20, 20)
    assert len(right.contacts.points) == 2
    assert right.contacts.segments == (Segment((-0.25, -0.25, 1.0), (-0.25, 0.25, 1.0)),)


def test_what_is_left_out(tmp_path):
    text = "cart: cart.yaml\nwrench: [40, 0, 3]\narms:\n  - {name: left, contacts: [[0, 0, 1]]}\n"
    problem = read_problem(problem_file(tmp_path, text))
    (left,) = problem.arms
    assert left.yaw == 0
    assert np.isinf(left.wrench_limit).all()
    assert left.friction is None
    assert left.weights == (1, 1, 1, 10, 10, 10)
    assert problem.min_hand_distance == 0


def test_parts_of_limits_and_friction(tmp_path):
    text = PROBLEM.replace(", moment: [8, 8, 6]", "").replace("{mu: 0.6, sides: 6}", "{mu: 0.6}")
    left = read_problem(problem_file(tmp_path, text)).arms[0]
    assert left.wrench_limit == pytest.approx([60, 60, 40, np.inf, np.inf, np.inf])
    assert left.friction == Friction(0.6, 4)
    text = PROBLEM.replace("sides: 6", "sides: exact")
    assert read_problem(problem_file(tmp_path, text)).arms[0].friction == Friction(0.6, "exact")


def test_a_cart_within_the_file(tmp_path):
    inner = "cart:\n" + "".join(f"  {line}\n" for line in CART.splitlines())
    problem = read_problem(problem_file(tmp_path, PROBLEM.replace("cart: cart.yaml\n", inner)))
    assert problem.cart.inertia.mass == 24.0
    assert WrenchPlanner(problem.cart, problem.arms).plan(problem.wrench).status == "optimal"


@pytest.mark.parametrize(
    ("old", "new", "place", "why"),
    [
        (
            "wrench: [40.0, 0.0, 3.0]",
            "wrench: [40.0, .nan, 3.0]",
            "2:16: wrench.1",
            "nan is not a finite number",
        ),
        ("wrench: [40.0, 0.0, 3.0]", "wrench: [40.0, 0.0]", "2:1: wrench", "at least 3"),
        ("wrench: [40.0, 0.0, 3.0]", "wrench: [40.0, 0.0, 3.0, 1]", "2:1: wrench", "at most 3"),
        ("wrench: [40.0", "wrench: [forty", "2:10: wrench.0", "'forty' is not a number"),
        ("wrench: [40.0, 0.0, 3.0]\n", "", "1:1: wrench", "is missing"),
        ("force: [60, 60", "force: [60, -1", "7:26: arms.0.limits.force.1", "-1 is negative"),
        ("force: [60, 60", "force: [60, .inf", "7:26: arms.0.limits.force.1", "leave the key out"),
        ("moment: [8", "moment: [.nan", "7:44: arms.0.limits.moment.0", "nan is not a finite number"),
        ("moment: [8, 8, 6]", "moment: [8, 8]", "7:35: arms.0.limits.moment", "at least 3"),
        ("name: right", "name: left", "10:5: arms.1.name", "left stands twice"),
        ("name: right", "name: 'ri:ght'", "10:5: arms.1.name", "without a dot or a colon"),
        ("    contacts: [[-0.25, 0.20, 1.0]]\n", "", "4:5: arms.0.contacts", "needs `contacts`, a `segment`"),
        ("[[-0.25, 0.20, 1.0]]", "[[-0.25, 0.20]]", "5:16: arms.0.contacts.0", "at least 3"),
        ("[-0.25, 0.25, 1.0]]", "[-0.25, .inf, 1.0]]", "12:44: arms.1.segment.1.1", "inf is not a finite"),
        ("segment: [[-0.25, -0.25, 1.0], ", "segment: [", "12:5: arms.1.segment", "at least 2"),
        ("sides: 6", "sides: 2", "8:25: arms.0.friction.sides", "2 is neither a whole number"),
        ("sides: 6", "sides: true", "8:25: arms.0.friction.sides", "True is neither a whole number"),
        ("mu: 0.6", "mu: -0.6", "8:16: arms.0.friction.mu", "-0.6 is negative"),
        ("mu: 0.6", "mu: 600", "8:16: arms.0.friction.mu", "600.0 is not a number from 0 to 100"),
        ("weights: [1, 1", "weights: [1, -1", "9:18: arms.0.weights.1", "-1 is negative"),
        ("weights: [1, 1, 1, ", "weights: [1, 1, ", "9:5: arms.0.weights", "at least 6"),
        ("yaw: 0.1", "yaw: .nan", "6:5: arms.0.yaw", "nan is not a finite number"),
        ("yaw: 0.1", "yaw: 90", "6:5: arms.0.yaw", "90 degrees are 1.571 rad"),
        ("weights: [1, 1", "weights: [1, 1e13", "9:18: arms.0.weights.1", "is not <= 1000000000000"),
        ("yaw: 0.1", "yaw: north", "6:5: arms.0.yaw", "'north' is not a number"),
        ("yaw: 0.1", "jaw: 0.1", "6:5: arms.0.jaw", "unknown key; did you mean yaw?"),
        ("min_hand_distance: 0.1", "min_hand_distance: -1", "13:1: min_hand_distance", "-1 is negative"),
        (
            "min_hand_distance: 0.1",
            "min_hand_distance: .inf",
            "13:1: min_hand_distance",
            "inf is not a finite",
        ),
        ("cart: cart.yaml", "cart: 3", "1:1: cart", "3 is neither the path"),
    ],
)
def test_a_mistake_has_a_place(tmp_path, old, new, place, why):
    assert old in PROBLEM
    path = problem_file(tmp_path, PROBLEM.replace(old, new, 1))
    with pytest.raises(FileError, match=re.escape(why)) as caught:
        read_problem(path)
    assert str(caught.value).startswith(f"{path}:{place}: ")


def test_a_rate_beyond_all_bounds_limits_nothing(tmp_path):
    """As a box beyond them does; it had been refused, at the arm's name."""
    text = PROBLEM.replace("yaw: 0.1", "yaw: 0.1\n    rate: {force: [100, 1e300, 1e300]}", 1)
    assert read_problem(problem_file(tmp_path, text)).arms[0].wrench_rate == (100, *[np.inf] * 5)


def test_what_is_held_and_what_it_costs_to_leave_it(tmp_path):
    right = "    contacts: [[-0.25, -0.20, 1.0], [-0.25, -0.1, 1.0]]\n"
    assert right in PROBLEM
    free = read_problem(problem_file(tmp_path, PROBLEM))
    best = free.planner().plan(free.wrench)
    assert (free.switching_cost, free.held, best.switched) == (0.0, {}, ())
    text = PROBLEM.replace(right, f"{right}    held: [-0.25, 0.05, 1.0]\n")
    for switching, moves in ((1e4, False), (0.1, True)):
        problem = read_problem(problem_file(tmp_path, f"{text}switching_cost: {switching}\n"))
        assert problem.held == {"right": (-0.25, 0.05, 1.0)}
        plan = problem.planner().plan(problem.wrench)
        assert plan.switched == (("right",) if moves else ())
        assert plan.contacts["right"] == pytest.approx(best.contacts["right"] if moves else [-0.25, 0.05, 1.0])
        assert plan.choice.bound == pytest.approx(plan.effort + switching * moves)
    for wrong, why in (
        (f"{text}switching_cost: -1\n", "switching_cost: -1 is negative"),
        (f"{text}switching_cost: 2e9\n", r"switching_cost: 2e\+09 is beyond 1e\+09"),
        (text.replace("0.05", ".nan"), "arms.1.held.1: nan is not a finite number"),
        (text.replace("0.05", "1e7"), "arms.1.held: contacts: .* from -50 to 50"),
    ):
        with pytest.raises(FileError, match=why):
            read_problem(problem_file(tmp_path, wrong))


WHEELS = """\
com_height: 0.45
wheels:
  - {kind: fixed, x: 0.0, y: 0.27}
  - {kind: fixed, x: 0.0, y: -0.27}
  - {kind: caster, x: 0.72, y: 0.0, trail: 0.04}
"""
MORE = """\
cart: cart.yaml
wrench: [40.0, 0.0, 3.0]
arms:
  - name: left
    contacts: [[-0.25, 0.20, 1.0], [-0.25, 0.5, 1.0]]
    push_only: true
    payload: 5
    rate: {force: [2000, 2000, 9000], last: [10, 0, 0, 0, 0, 0]}
    joints:
      jacobian: [[0.1, 0.2], [0.6, 0.3], [0, 0], [0, 0], [0, 0], [1, 1]]
      gravity_torque: [2, 1]
      torque_limit: [30, 20]
    reach: {low: [-0.5, -0.3, 0], high: [0, 0.3, 2]}
  - name: right
    contacts: [[-0.25, -0.20, 1.0]]
    soft_finger: {mu: 0.6, twist_radius: 0.016, grip: 100, normal: z, sides: 6}
cart_limits:
  skid: {friction: 0.4}
  tip_over: {least_load: 10}
  internal_force: {bound: 20}
  side_force: {bound: 30}
relax: 50
period: 0.01
"""


def more_file(folder, text):
    path = problem_file(folder, text)
    (folder / "cart.yaml").write_text(CART + WHEELS)
    return path


def test_every_other_limit(tmp_path):
    problem = read_problem(more_file(tmp_path, MORE))
    left, right = problem.arms
    assert left.push_only
    assert left.payload == 5
    assert left.wrench_rate == (2000, 2000, 9000, np.inf, np.inf, np.inf)
    assert left.joints.jacobian.shape == (6, 2)
    assert left.joints.torque_limit.tolist() == [30, 20]
    assert left.reach.excess([-0.25, 0.2, 1.0]) < 0 < left.reach.excess([-0.25, 0.5, 1.0])
    assert set(problem.cart_limits) == {Skid(0.4), TipOver(10.0), SideForce(30.0), InternalForce(20.0)}
    assert (problem.relax, problem.period) == (50.0, 0.01)
    assert (left.soft_finger, right.soft_finger) == (None, SoftFinger(0.6, 0.016, 100.0, "z", 6))
    assert (right.push_only, right.payload, right.joints, right.reach) == (False, np.inf, None, None)
    plan = problem.planner().plan(problem.wrench)
    assert plan.status == "optimal"
    assert plan.contacts["left"].tolist() == [-0.25, 0.2, 1.0]
    assert {"wheel 2 load", "skid to the left", "left: joint 1 torque upper", "left: payload upper"} <= set(
        plan.margins
    )
    assert plan.margins["left: fx rate upper"] == pytest.approx(30.0 - plan.wrenches["left"][0])
    assert plan.margins["left: joint 0 torque upper"] == pytest.approx(
        28.0 - left.joints.jacobian[:, 0] @ plan.wrenches["left"]
    )


def test_a_plan_from_a_file_is_relaxed_as_it_allows(tmp_path):
    asked = MORE.replace("cart_limits:", "    limits: {force: [9, 9, 9]}\ncart_limits:")
    plan = read_problem(more_file(tmp_path, asked)).planner().plan((60.0, 0.0, 0.0))
    assert plan.status == "relaxed"
    assert set(plan.active) & {"left: fx rate upper", "right: fx upper"}
    assert plan.contact_wrenches.wrench_b[0] <= 39.0 + 1e-9


@pytest.mark.parametrize(
    ("old", "new", "place", "why"),
    [
        ("push_only: true", "push_only: 1", "6:5: arms.0.push_only", "push_only"),
        ("payload: 5", "payload: -5", "7:5: arms.0.payload", "-5 is negative"),
        ("payload: 5", "payload: .inf", "7:5: arms.0.payload", "leave the key out"),
        ("force: [2000, 2000", "force: [2000, 0", "8:26: arms.0.rate.force.1", "0 is not > 0"),
        ("last: [10, 0", "last: [.nan, 0", "8:46: arms.0.rate.last.0", "nan is not a finite"),
        ("[0.6, 0.3]", "[0.6]", "10:30: arms.0.joints.jacobian.1", "1 numbers, but there are 2 torque limits"),
        (", [1, 1]]", "]", "10:7: arms.0.joints.jacobian", "at least 6"),
        ("gravity_torque: [2, 1]", "gravity_torque: [2]", "9:5: arms.0.joints", "gravity_torque: shape (1,)"),
        ("gravity_torque: [2, 1]", "gravity_torque: [2, 25]", "9:5: arms.0.joints", "joint 1 needs 25 N·m"),
        ("torque_limit: [30, 20]", "torque_limit: [30, -20]", "12:26: arms.0.joints.torque_limit.1", "-20 is negative"),
        ("low: [-0.5", "low: [0.5", "13:5: arms.0.reach", "corner of a box"),
        ("low: [-0.5", "low: [-0.1", "13:5: arms.0.reach", "no candidate contact is within it"),
        ("friction: 0.4", "friction: -0.4", "18:10: cart_limits.skid.friction", "-0.4 is negative"),
        ("{friction: 0.4}", "{mu: 0.4}", "18:10: cart_limits.skid", "mu"),
        ("{bound: 20}", "{bound: 20, axis: [0, 0, 0]}", "20:3: cart_limits.internal_force", "not a direction"),
        ("relax: 50", "relax: .inf", "22:1: relax", "inf is not a finite"),
        ("period: 0.01", "period: 0", "23:1: period", "0 is not > 0"),
        ("period: 0.01", "period: 0.6", "23:1: period", "0.6 is not <= 0.5"),
        ("last: [10, 0", "last: [2.0e+6, 0", "8:46: arms.0.rate.last.0", "is not <= 1000000"),
        ("{bound: 30}", "{bound: -30}", "21:16: cart_limits.side_force.bound", "-30 is negative"),
        ("z, sides: 6}", "z, sides: 2}", "16:5: arms.1.soft_finger", "soft finger: sides: 2"),
        ("normal: z", "normal: w", "16:5: arms.1.soft_finger", "soft finger: normal: 'w'"),
        ("twist_radius: 0.016, ", "", "16:5: arms.1.soft_finger.twist_radius", "is missing"),
        ("tip_over:", "tipover:", "19:3: cart_limits.tipover", "unknown key; did you mean tip_over?"),
    ],
)
def test_a_mistake_in_another_limit_has_a_place(tmp_path, old, new, place, why):
    assert old in MORE
    path = more_file(tmp_path, MORE.replace(old, new, 1))
    with pytest.raises(FileError, match=re.escape(why)) as caught:
        read_problem(path)
    assert str(caught.value).startswith(f"{path}:{place}")


def test_a_cart_that_can_not_have_a_limit(tmp_path):
    with pytest.raises(FileError, match="stand in one line") as caught:
        read_problem(problem_file(tmp_path, MORE.replace("  skid: {friction: 0.4}\n", "")))
    assert ":18:3: cart_limits.tip_over: " in str(caught.value)


def test_no_arms(tmp_path):
    path = problem_file(tmp_path, "cart: cart.yaml\nwrench: [1, 0, 0]\narms: []\n")
    with pytest.raises(FileError, match=r"problem\.yaml:3:1: arms: "):
        read_problem(path)


def test_mistakes_of_the_cart_keep_their_own_place(tmp_path):
    path = problem_file(
        tmp_path, PROBLEM.replace("cart: cart.yaml", "cart: {name: x, mass: -1, com: [0, 0], inertia: 1}")
    )
    with pytest.raises(FileError, match=r"problem\.yaml:1:17: cart\.mass: "):
        read_problem(path)
    path = problem_file(tmp_path, PROBLEM.replace("cart: cart.yaml", "cart: nowhere.yaml"))
    with pytest.raises(FileError, match=r"nowhere\.yaml"):
        read_problem(path)
    path = problem_file(tmp_path, PROBLEM)
    (tmp_path / "cart.yaml").write_text(CART.replace("mass: 24.0", "mass: 0"))
    with pytest.raises(FileError, match=r"cart\.yaml:2:1: mass: "):
        read_problem(path)
