"""Sources of poses that move or turn, with the world's velocity as it is: a cart is driven neither there nor away."""

from __future__ import annotations

import numpy as np
import pytest

import cartgrasp as cg
from benchmarks.wrong_motion import (
    BEGIN,
    FILTERS,
    PATH,
    SHORT,
    TRUTH,
    VELOCITIES,
    WRENCHES,
    WRONG,
    driven,
    held_on_a_slope,
)
from estimation import CartFilter
from estimation.sensor_check.suspicion import Suspicion
from planning import Caution, Controller, PathReference, chain, straight
from planning.control.protective_stop import DRIVING, Stage

from .driving import ticks


@pytest.mark.long
@pytest.mark.some(2)
@pytest.mark.parametrize("name", FILTERS)
@pytest.mark.parametrize("kind", [kind for kind in WRONG if kind != "reversed"])
def test_for_a_moment_the_cart_stays_on_its_path(kind, name):
    """The other sensors tell the way meanwhile. Before, half a turn for a second sped the cart up to 31 m/s."""
    found = driven(kind, name, BEGIN + SHORT, 6.0)
    assert found.farthest < 0.3
    assert found.off < 0.05
    assert found.speed < 0.66


@pytest.mark.long
@pytest.mark.some(2)
@pytest.mark.parametrize("name", FILTERS)
@pytest.mark.parametrize("kind", [kind for kind in WRONG if kind != "reversed"])
def test_for_good_the_cart_is_not_driven_away(kind, name):
    found = driven(kind, name, 100.0, 12.0)
    assert found.speed < 1.2 if kind in VELOCITIES else found.speed < 0.9
    if kind in VELOCITIES or kind in WRENCHES:
        assert found.off < 0.05
    if kind == "moved":
        assert "stops: the cart is" in found.step.words
    if kind == "in degrees":
        assert "stops: headings are in degrees" in found.step.words
        assert found.farthest < 0.3


def test_without_caution_it_is_driven_there_no_faster_than_errors_reach():
    assert 0.7 < driven("moved", "CartFilter", 100.0, 7.0, None).speed < 0.6 + 1.5 * 0.5 + 0.1


@pytest.mark.some(2)
@pytest.mark.parametrize("slope", [0.0, 0.03, -0.05])
def test_a_stopped_cart_is_held_on_a_slope(slope):
    """That nobody knows of. Let go by mistake it rolled 34 m; with nothing but braking it crept on for ever."""
    found = held_on_a_slope(slope)
    assert found.step.slowed.startswith("stops: the cart is 1.")
    assert found.farthest < 0.35
    assert found.speed < 0.3


def estimate(x, heading, u):
    """Of a cart that is there, in {s}, and rolls so fast."""
    learner = CartFilter(TRUTH)
    told = learner.update(cg.Measurement(0.0, pose=[0, 0, 0]))
    return told._replace(motion=cg.Motion(np.array([x, 0.0, heading]), np.array([u, 0.0])))


def stopped(speeds, interval=0.01):
    """Stops (n,) of a cart that is 1.2 m off its path, by its speed every 10 ms."""
    stop, found = DRIVING, []
    for k, u in enumerate(speeds):
        stop = stop.after(interval * k, TRUTH, PATH.at(0.0), estimate(1.2, 0.0, u), 1.0)
        found.append(stop)
    return found


def test_it_begins_and_ends_with_the_error():
    for x, heading, why in ((0.9, 0.0, ""), (1.1, 0.0, "1.1 m off its path"), (0.0, 2.0, "heads 115° off its path")):
        stop = DRIVING.after(0.0, TRUTH, PATH.at(0.0), estimate(x, heading, 0.5), 1.0)
        assert stop.why == (f"stops: the cart {'is ' if x else ''}{why}" if why else "")
        assert stop.after(0.01, TRUTH, PATH.at(0.0), estimate(0.9, 0.0, 0.5), 1.0) is DRIVING


def test_a_stop_is_monitored():
    """A quick cart that gets quicker is let go, for 0.5 s, then 1 s, and so on; and braked gently between."""
    stops = stopped(0.6 + 0.05 * np.arange(400) / 100.0)
    changes = [k for k in range(1, 400) if stops[k].stage is not stops[k - 1].stage]
    np.testing.assert_allclose(np.diff([0, *changes[:4]]), [20, 50, 20, 100], atol=1)
    assert [stops[k].share for k in (0, changes[0] - 1, changes[1], changes[2] - 1)] == [1.0, 1.0, 0.25, 0.25]
    assert stops[changes[0]].why == "gives nothing: the cart is 1.2 m off its path"
    assert {stop.stage for stop in stopped(0.6 * np.exp(-np.arange(400) / 50.0))} == {Stage.BRAKES}
    assert {stop.stage for stop in stopped(0.49 * (1.0 - np.exp(-np.arange(400) / 50.0)))} == {Stage.BRAKES}, "a slope"


def test_what_was_pushed_is_stopped_after_all():
    """Somebody pushes on for half a second: it is let go, and braked, usually hard once that is seen to brake."""
    pushed = [0.6 + 2.0 * min(k, 50) / 100.0 for k in range(70)]
    stops = stopped([*pushed, *(pushed[-1] * np.exp(-np.arange(100) / 100.0))])
    assert stops[25].stage is Stage.LETS_GO
    assert [stops[75].stage, stops[75].share] == [Stage.BRAKES, 0.25]
    assert [stops[-1].stage, stops[-1].share] == [Stage.BRAKES, 1.0]


def test_what_surely_is_not_the_motion_stops_the_cart():
    caution, told = Caution().astray, estimate(0.0, 0.0, 0.5)
    kinds = ("unit", "heading", 0.95), ("unit", "heading", 0.6), ("sign", "wrench", 0.99), ("noise", "velocity", 1.0)
    stages = [
        DRIVING.after(0.0, TRUTH, PATH.at(0.0), told._replace(suspicions=(Suspicion(*one, 1.0, "so"),)), caution).stage
        for one in kinds
    ]
    assert stages == [Stage.BRAKES, Stage.DRIVES, Stage.DRIVES, Stage.DRIVES]


def test_another_path_goes_on_from_a_stop():
    """As docs/controller.md tells: with the same estimator, which keeps what it has learned."""
    cart = cg.CartModel(cg.Inertia(24.0, (0.3, 0.0), 2.0))
    arms = [cg.Arm("left", [(-0.25, 0.2, 1.0)]), cg.Arm("right", [(-0.25, -0.2, 1.0)])]
    learner, path = CartFilter(cart, ["left", "right"]), PathReference(chain(straight(2.0, 0.5)))
    first = Controller(cart, arms, path, estimator=learner)
    stop = [tick.step for tick in ticks(first, cart, 4.0, pose_sb=(1.3, 0.0, 0.0))][-1]
    assert "stops: the cart is 1.3 m off its path" in stop.words
    start = stop.estimate.motion.pose_sb
    path = PathReference(chain(straight(1.0, 0.5)), start_pose=start)
    on = Controller(stop.estimate.cart(), arms, path, estimator=learner, held=stop.contacts)
    last = [*ticks(on, cart, path.duration + 0.5, pose_sb=start)][-1]
    assert on.is_done
    assert np.abs(last.motion.pose_sb - start - [1.0, 0.0, 0.0]).max() < 0.02
