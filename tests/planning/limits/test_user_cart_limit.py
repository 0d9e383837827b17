"""A cart limit from outside: what is wrong with its rows is said, when a planner is made and at a tick."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest

import cartgrasp as cg
from planning import CartLimit, CartRows, PushedCart, SideForce, WrenchPlanner, allocate

from ..drawn import cart

HANDS = [cg.Arm("left", [(-0.25, 0.2, 1.0)]), cg.Arm("right", [(-0.25, -0.2, 1.0)])]
ROWS = np.zeros((2, 1, 6))
ROWS[0, 0, 0], ROWS[1, 0, 0] = 1.0, -1.0
GOOD = CartRows(np.zeros((1, 6)), ROWS, np.array([-2.0]), np.array([2.0]), ("apart lower",), ("apart upper",))
CONES = replace(
    GOOD, low=-np.full(1, np.inf), high=np.full(1, np.inf), cone_names=("cone",), cone_offsets=np.ones((1, 1))
)
BAD = [
    (None, r"None is no CartRows; return CartRows\(...\)"),
    (replace(GOOD, high=np.array([np.nan])), "low and high have a number that is none; for no limit, give low -inf"),
    (replace(GOOD, low=np.array([np.inf])), "low and high have a number that is none"),
    (
        replace(GOOD, high=np.array([-3.0])),
        "row 0: low -2 is above high -3, which no wrench obeys; give low up to high",
    ),
    (replace(GOOD, high=[2.0]), r"high is \[2.0\]; for 1 rows and 2 arms give an array \(1,\)"),
    (replace(GOOD, high=np.array(["2"])), r"high is of shape \(1,\)"),
    (replace(GOOD, high=np.zeros(2)), r"high is of shape \(2,\)"),
    (replace(GOOD, low=-2.0), "low is -2.0"),
    (
        replace(GOOD, of_arm=ROWS[:1]),
        r"of_arm is of shape \(1, 1, 6\); for 1 rows and 2 arms give an array \(2, 1, 6\)",
    ),
    (replace(GOOD, of_arm=ROWS[:, 0]), r"of_arm is of shape \(2, 6\)"),
    (replace(GOOD, of_sum=np.zeros((1, 3))), r"of_sum is of shape \(1, 3\)"),
    (replace(GOOD, of_sum=np.full((1, 6), np.inf)), "of_sum or of_arm has a number that is not finite"),
    (replace(GOOD, low_names=("a", "b")), r"low_names: \('a', 'b'\) is not a name for each of 1 rows; name each"),
    (replace(GOOD, high_names=("",)), r"high_names: \('',\) is not a name"),
    (replace(GOOD, high_names="a"), "high_names: 'a' is not a name for each"),
    (replace(GOOD, units="N"), "units: 'N' is not a unit for each of 1 rows; leave them out for N"),
    (replace(CONES, cone_offsets=np.full((1, 1), np.nan)), "not finite"),
]


@dataclass(frozen=True)
class Given(CartLimit):
    """Says `at_rest` before the first estimate, and `moving` after."""

    at_rest: Any
    moving: Any = GOOD

    def rows(self, pushed):
        return self.at_rest if pushed.motion is None else self.moving


def estimate():
    model = cart()
    return cg.Estimate(0.0, cg.Motion(np.zeros(3), np.zeros(2)), {}, "ok", model, model.parameters)


@pytest.mark.parametrize(("said", "words"), BAD)
@pytest.mark.parametrize("others", [[], [SideForce(90.0)]])
def test_what_is_wrong_with_its_rows_is_said(said, words, others):
    with pytest.raises(cg.UsageError, match=f"^cart_limits: Given: rows: .*{words}"):
        WrenchPlanner(cart(), HANDS, cart_limits=[Given(said), *others])
    with pytest.raises(cg.UsageError, match=words):
        allocate(cart(), HANDS, {"left": (0, 0, 1), "right": (0, 0, 1)}, (4.0, 0.0, 0.0), cart_limits=[Given(said)])


@pytest.mark.parametrize(("said", "words"), BAD)
def test_at_a_tick_it_refuses_the_estimate(said, words):
    planner = WrenchPlanner(cart(), HANDS, cart_limits=[Given(GOOD, said)])
    assert planner.plan((40.0, 0.0, 1.0)).status == "optimal"
    plan = planner.plan_or_hold((40.0, 0.0, 1.0), estimate=estimate())
    assert plan.status == "invalid_input"
    with pytest.raises(cg.UsageError, match=f"estimate: cart_limits: Given: rows: .*{words}"):
        raise cg.UsageError(plan.message)


def test_right_rows_hold():
    planner = WrenchPlanner(cart(), HANDS, cart_limits=[Given(GOOD), SideForce(90.0)])
    for plan in (planner.plan((40.0, 0.0, 9.0)), planner.plan((40.0, 0.0, 9.0), estimate=estimate())):
        assert plan.active == ("apart lower",)
        assert plan.wrenches["left"][0] - plan.wrenches["right"][0] == pytest.approx(-2.0)


def test_cones_are_not_lost_before_other_rows():
    with pytest.raises(cg.UsageError, match="rows with cones stand before others; list that limit last"):
        WrenchPlanner(cart(), HANDS, cart_limits=[Given(CONES), SideForce(90.0)])


def test_velocity_in_the_body_frame():
    """An axle 0.3 m ahead of {b}'s origin doesn't slip to the side: v + 0.3 r = 0 there."""
    model = cart(1, 0.3)
    motion = cg.Motion(np.zeros(3), np.array([0.5, 0.2]))
    assert PushedCart(model, motion, HANDS).velocity_b == pytest.approx([0.5, -0.06, 0.2])
    assert PushedCart(model, None, HANDS).velocity_b.tolist() == [0.0, 0.0, 0.0]


@pytest.mark.parametrize("others", [[], [SideForce(90.0)]])
def test_units_are_told(others):
    """One hand alone: its force is limited as a power at 1 m/s would be, and 3 J of nothing can't be had."""
    one = replace(GOOD, of_arm=ROWS[:1], units=("W",))
    planner = WrenchPlanner(cart(), HANDS[:1], cart_limits=[Given(one), *others])
    words = planner.plan((40.0, 0.0, 0.0)).message
    assert words == "apart upper 2 W: it gives at most 2 N of forward force, 40 N is asked"
    never = replace(GOOD, of_arm=0.0 * ROWS, low=np.full(1, 3.0), high=np.full(1, 4.0), units=("J",))
    planner = WrenchPlanner(cart(), HANDS, cart_limits=[Given(never), *others])
    assert planner.plan((4.0, 0.0, 0.0)).message.startswith("apart lower by 3 J: missed")
