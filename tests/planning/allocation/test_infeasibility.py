"""Feasible or not, against HiGHS; certificates and nearest wrenches, by roads that share nothing with the
planner."""

from __future__ import annotations

import numpy as np
import pytest

from cartgrasp.arms import Arm, Friction
from planning import WrenchPlanner, allocate

from ..drawn import (
    arm,
    cart,
    effective_matrix,
    first_contacts,
    is_feasible,
    largest_scale,
    random_arms,
    random_cart,
    replace_friction,
    support,
    violation,
)


def pair(**changes):
    return [arm("left", [(-0.25, 0.2, 1.0)], **changes), arm("right", [(-0.25, -0.2, 1.0)], **changes)]


def check_certificate(model, arms, contacts, wrench, found):
    """The separating inequality and the nearest wrench, checked by HiGHS and by geometry."""
    certificate, nearest = found.certificate, found.certificate.nearest
    assert certificate.verified
    assert certificate.asked == pytest.approx(np.dot(certificate.direction, wrench), abs=1e-7)
    best = support(model, arms, contacts, certificate.direction)
    assert best <= certificate.most + 1e-6 * max(1.0, abs(certificate.most))
    assert certificate.asked > best
    names = {a.name for a in arms}
    assert all(limit.split(":")[0] in names for limit in certificate.limits)
    # The nearest is feasible, gives what it says, and is nearest: t·(y - nearest) <= 0 for all feasible y.
    assert violation(arms, nearest.wrenches) <= 1e-8
    basis = model.constraints.basis_b
    matrix = effective_matrix(model, arms, contacts)
    reached = matrix @ np.concatenate([nearest.wrenches[a.name] for a in arms])
    assert reached == pytest.approx(basis.T @ nearest.wrench, abs=1e-9)
    missing = basis.T @ np.asarray(wrench) - reached
    assert nearest.distance == pytest.approx(np.linalg.norm(missing), rel=1e-6, abs=1e-9)
    farthest = support(model, arms, contacts, basis @ missing)
    assert farthest <= missing @ reached + 1e-6 * max(1.0, abs(missing @ reached))


@pytest.mark.parametrize("seed", range(120))
def test_feasible_or_not_agrees_with_highs(seed):
    rng = np.random.default_rng(seed)
    model, arms = random_cart(rng), random_arms(rng, int(rng.integers(1, 4)))
    contacts, wrench = first_contacts(arms), rng.uniform((-40, -40, -30), (150, 40, 30))
    found = allocate(model, arms, contacts, wrench)
    feasible = is_feasible(model, arms, contacts, wrench)
    assert found.status == ("optimal" if feasible else "infeasible")
    if not feasible:
        check_certificate(model, arms, contacts, wrench, found)


@pytest.mark.some(100)
@pytest.mark.parametrize("seed", range(80))
@pytest.mark.parametrize("beyond", [-1e-6, -1e-9, 1e-7, 1e-6])
def test_right_at_the_limit_of_what_the_arms_can_do(seed, beyond):
    rng = np.random.default_rng(seed)
    scale = 0.0
    while not 1e-3 < scale < 10:  # drawn anew where next to nothing limits it: HiGHS is not that exact then
        model, arms = random_cart(rng), random_arms(rng, int(rng.integers(1, 4)))
        contacts, wrench = first_contacts(arms), rng.uniform((5, -20, -10), (60, 20, 10))
        scale = largest_scale(model, arms, contacts, wrench)
    asked = wrench * scale * (1 + beyond)
    found = allocate(model, arms, contacts, asked)
    assert found.status == ("optimal" if beyond < 0 else "infeasible")
    if beyond > 0:
        assert found.certificate.verified
        # HiGHS is exact to some 1e-10: a hundredth of the least distance here
        assert found.certificate.nearest.distance <= np.linalg.norm(asked) * beyond * 1.01
    else:
        assert violation(arms, found.wrenches) <= 1e-8


@pytest.mark.parametrize("seed", range(40))
def test_cones_are_certified_too(seed):
    """A fine circumscribed pyramid bounds what a cone can give."""
    rng = np.random.default_rng(seed)
    model, arms = random_cart(rng), random_arms(rng, 2, sides="exact")
    wider = [replace_friction(a, Friction(a.friction.mu / np.cos(np.pi / 64), 64)) for a in arms]
    contacts, wrench = first_contacts(arms), rng.uniform((-40, -40, -30), (150, 40, 30))
    found = allocate(model, arms, contacts, wrench)
    if found.status == "optimal":
        assert is_feasible(model, wider, contacts, wrench)
        return
    assert found.status == "infeasible"
    certificate = found.certificate
    assert certificate.verified
    # The cone lies within the wider pyramid and holds the narrower one.
    narrower = [replace_friction(a, Friction(a.friction.mu, 64)) for a in arms]
    assert support(model, narrower, contacts, certificate.direction) <= certificate.most + 1e-6
    assert certificate.most <= support(model, wider, contacts, certificate.direction) + 1e-3
    for a in arms:
        f = certificate.nearest.wrenches[a.name]
        assert np.linalg.norm(f[1:3]) <= a.friction.mu * f[0] + 1e-7


def test_the_certificate_in_words():
    arms = pair()
    found = allocate(cart(), arms, first_contacts(arms), (150, 0, 0))
    assert found.certificate.words == (
        "left: fx upper 60 N; right: fx upper 60 N: together they give at most 120 N of forward force, 150 N is asked"
    )
    assert found.certificate.limits == {"left: fx upper": 60.0, "right: fx upper": 60.0}
    assert found.certificate.direction == (1.0, 0.0, 0.0)
    assert found.certificate.nearest.distance == pytest.approx(30)
    assert found.certificate.nearest.effort == pytest.approx(7200)
    assert found.certificate.nearest.wrench == pytest.approx([120, 0, 0], abs=1e-9)


def test_pushing_arms_can_not_pull():
    arms = pair()
    found = allocate(cart(), arms, first_contacts(arms), (-10, 0, 0))
    assert "backward force" in found.certificate.words
    assert found.certificate.limits == {"left: push only": 0.0, "right: push only": 0.0}
    assert found.certificate.most == pytest.approx(0.0, abs=1e-9)


def test_two_arms_at_the_same_point():
    """Singular: the second arm adds no lever. Both share; what one can't turn, two can't either beyond their
    limits."""
    arms = [arm("left", [(0, 0, 1)]), arm("right", [(0, 0, 1)])]
    found = allocate(cart(), arms, first_contacts(arms), (40, 0, 3))
    assert found.wrenches["left"] == pytest.approx([20, 0, 0, 0, 0, 1.5], abs=1e-9)
    assert found.wrenches["right"] == pytest.approx(found.wrenches["left"], abs=1e-9)
    beyond = allocate(cart(), arms, first_contacts(arms), (40, 0, 12.5))
    assert beyond.certificate.limits == {"left: tz upper": 6.0, "right: tz upper": 6.0}
    assert beyond.certificate.nearest.distance == pytest.approx(0.5)


def test_an_arm_that_has_no_lever_and_no_moment():
    """At the origin with moment limits of zero, yaw can't be produced: the row is all but absent."""
    a = arm("left", [(0, 0, 1)], moment_limit=(0, 0, 0))
    assert allocate(cart(), [a], first_contacts([a]), (40, 0, 0)).status == "optimal"
    found = allocate(cart(), [a], first_contacts([a]), (40, 0, 3))
    assert found.status == "infeasible"
    assert found.certificate.direction == pytest.approx((0, 0, 1))
    assert found.certificate.most == pytest.approx(0, abs=1e-9)
    assert "tz upper 0 N·m" in found.certificate.words
    assert found.certificate.nearest.wrench == pytest.approx([40, 0, 0], abs=1e-9)


def test_without_limits_nothing_is_infeasible():
    a = Arm("left", [(0.1, 0.2, 1.0)])
    assert allocate(cart(0), [a], first_contacts([a]), (1e6, -1e6, 1e5)).status == "optimal"


def test_unlimited_arms_that_may_only_push():
    a = Arm("left", [(-0.5, 0.0, 1.0)], friction=Friction(0.5))
    found = allocate(cart(), [a], first_contacts([a]), (-5, 0, 0))
    assert found.status == "infeasible"
    assert found.certificate.verified
    assert found.certificate.nearest.distance == pytest.approx(5)


def test_the_nearest_plan_is_the_cheapest_of_the_nearest():
    """Left's limit binds forward force at 60 + 60 N; its effort is that of an allocation of (120, 0, 2)."""
    arms = pair()
    found = allocate(cart(), arms, first_contacts(arms), (150, 0, 2))
    cheapest = allocate(cart(), arms, first_contacts(arms), (120, 0, 2))
    assert found.certificate.nearest.effort == pytest.approx(cheapest.effort, rel=1e-8)


def test_a_rate_is_told_with_its_sign():
    """A rate's bounds are about the last wrench: both may have one sign."""
    hand = arm("left", friction=None, wrench_rate=(100,) * 6)
    planner = WrenchPlanner(cart(2), [hand], period=0.01)
    for last, asked, words in (
        (-10, -5, "rate upper -9 N: it gives at most -9 N of forward force, -5 N is asked"),
        (10, 5, "rate lower 9 N: it gives at most -9 N of backward force, -5 N is asked"),
    ):
        planner.start_from({"left": (last, 0, 0, 0, 0, 0)})
        assert planner.plan((asked, 0, 0)).message == f"left: fx {words}"
