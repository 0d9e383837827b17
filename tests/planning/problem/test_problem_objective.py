"""What PROBLEM.yaml may say of the objective, the motion and how well the cart is known: against the same in Python."""

from __future__ import annotations

import re

import numpy as np
import pytest

from cartgrasp.errors import FileError
from cartgrasp.inertia import Inertia
from cartgrasp.motion import Estimate, Motion
from planning import Skid, WrenchPlanner
from planning.objectives import (
    LeastInternalForce,
    LeastSideForce,
    LoadShare,
    Nothing,
    Smoothness,
    WeightedWrench,
    WorstArm,
)
from planning.problem.problem_file import read_problem

from .test_problem_file import CART, WHEELS, problem_file

PROBLEM = """\
cart: cart.yaml
wrench: [40.0, 0.0, 3.0]
arms:
  - {name: left, contacts: [[-0.25, 0.20, 1.0]], limits: {force: [60, 60, 40], moment: [8, 8, 6]}}
  - {name: right, contacts: [[-0.25, -0.20, 1.0]], limits: {force: [60, 60, 40], moment: [8, 8, 6]}}
"""
SKID = "cart_limits: {skid: {friction: 0.1}}\n"
SHARES = {"left": 0.7, "right": 0.3}


def read(folder, text):
    path = problem_file(folder, PROBLEM + text)
    (folder / "cart.yaml").write_text(CART + WHEELS)
    return read_problem(path)


@pytest.mark.parametrize(
    ("text", "objective"),
    [
        ("", WeightedWrench()),
        ("objective: {}\n", WeightedWrench()),
        ("objective: {smoothness: {}}\n", Smoothness()),
        ("objective: {load_share: {shares: {left: 0.7, right: 0.3}, weight: 5}}\n", LoadShare(SHARES, 5.0)),
        ("objective: {effort: false, worst_arm: {weight: 100}}\n", WorstArm(100.0, Nothing())),
        ("objective: {least_side_force: {weight: 3}}\n", LeastSideForce(3.0)),
        (
            "objective:\n  least_internal_force: {weight: 2, axis: [1, 0, 0]}\n  smoothness: {rate: 0.5}\n",
            LeastInternalForce(2.0, (1.0, 0.0, 0.0), Smoothness(0.5)),
        ),
    ],
)
def test_terms_by_name_add_up(tmp_path, text, objective):
    problem = read(tmp_path, text)
    expected = WrenchPlanner(problem.cart, problem.arms, objective=objective).plan(problem.wrench)
    for name, wrench in problem.plan().wrenches.items():
        assert wrench == pytest.approx(expected.wrenches[name], abs=1e-7)


def test_shares_of_the_load_are_followed(tmp_path):
    plan = read(tmp_path, "objective: {load_share: {shares: {left: 0.7, right: 0.3}, weight: 1e6}}\n").plan()
    assert plan.wrenches["left"][0] == pytest.approx(28.0, rel=1e-4)


def test_a_motion_is_that_of_an_estimate(tmp_path):
    """A bend at 2 m/s and 1 rad/s takes more side force than the floor gives by friction; straight on takes none."""
    still, bend = (read(tmp_path, f"{SKID}motion: {{velocity: [2.0, {turn}]}}\n") for turn in (0.0, 1.0))
    given = Estimate(0.0, Motion(np.zeros(3), np.array([2.0, 1.0])), {}, "", bend.cart, bend.cart.parameters)
    planner = WrenchPlanner(bend.cart, bend.arms, cart_limits=[Skid(0.1)])
    expected = planner.plan(bend.wrench, estimate=given)
    assert bend.plan().effort == pytest.approx(expected.effort, rel=1e-9)
    assert any(name.startswith("skid") for name in bend.plan().active)
    assert bend.plan().effort > 1.01 * still.plan().effort


def test_a_confidence_is_paid_for_as_in_python(tmp_path):
    """The covariance of the model's numbers by sampling the physical ones, whose deviations the file states."""
    text = f"{SKID}motion: {{velocity: [2.0, 0.8]}}\n"
    sure, unsure = (read(tmp_path, text + more) for more in ("", CONFIDENCE))
    nominal = Inertia(24.0, (0.3, 0.0), 2.0)
    rng = np.random.default_rng(0)
    mass, com_x = 24.0 + 1e-3 * rng.normal(size=20_000), 0.3 + 2e-5 * rng.normal(size=20_000)
    drawn = np.array([Inertia(m, (x, 0.0), 2.0).phi - nominal.phi for m, x in zip(mass, com_x, strict=True)])
    np.testing.assert_allclose(1e-6 * unsure.estimate.covariance, drawn.T @ drawn / len(drawn), rtol=0.05, atol=1e-12)
    expected = WrenchPlanner(unsure.cart, unsure.arms, cart_limits=[Skid(0.1)], confidence=0.95)
    plan = unsure.plan()
    assert plan.effort == pytest.approx(expected.plan(unsure.wrench, estimate=unsure.estimate).effort, rel=1e-7)
    assert any("(95 %)" in name for name in plan.margins)
    assert plan.effort > 1.001 * sure.plan().effort


CONFIDENCE = "confidence: {probability: 0.95, std: {mass: 1.0, com_x: 0.02}}\n"


@pytest.mark.parametrize(
    ("text", "place", "why"),
    [
        ("objective: {worst_hand: {weight: 1}}\n", "6:13: objective.worst_hand", "mean worst_arm?"),
        ("objective: {worst_arm: {}}\n", "6:13: objective.worst_arm.weight", "is missing"),
        ("objective: {worst_arm: {weight: 0}}\n", "6:25: objective.worst_arm.weight", "0 is not > 0"),
        ("objective: {smoothness: {rate: -1}}\n", "6:26: objective.smoothness.rate", "-1 is negative"),
        ("objective: {load_share: {shares: {left: 1}}}\n", "6:13: objective.load_share", "shares of ['left']"),
        (
            "objective: {load_share: {shares: {left: 2, right: 1}}}\n",
            "6:13: objective.load_share",
            "2.0 is not a number",
        ),
        ("objective: {load_share: {shares: {left: 0.7, right: 1}}}\n", "6:13: objective.load_share", "add up to 1"),
        ("objective: {least_joint_torque: {}}\n", "6:13: objective.least_joint_torque", "states its joints"),
        ("objective: {effort: false}\n", "6:13: objective.effort", "nothing is left to minimise"),
        ("motion: {velocity: [1.0]}\n", "6:10: motion.velocity", "1 numbers, but this cart moves freely in u, r"),
        ("motion: {pose: [0, 0, 0]}\n", "6:1: motion.velocity", "is missing"),
        (CONFIDENCE.replace("com_x", "comx"), "6:50: confidence.std.comx", "has no parameter comx; it has mass, com_x"),
        (CONFIDENCE.replace("1.0", "-1"), "6:39: confidence.std.mass", "-1 is negative"),
        (CONFIDENCE.replace("0.95", "95"), "6:14: confidence.probability", "95 is not < 1"),
        ("confidence: {probability: 0.9}\n", "6:1: confidence.std", "is missing"),
    ],
)
def test_a_mistake_has_a_place(tmp_path, text, place, why):
    with pytest.raises(FileError, match=re.escape(why)) as caught:
        read(tmp_path, text)
    assert re.sub(r"^.*problem\.yaml:", "", str(caught.value)).startswith(f"{place}: ")
