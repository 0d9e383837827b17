"""Whatever is asked of it, a planner raises what it documents, plans finite wrenches, and is right where it says
`optimal`."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest

from cartgrasp.errors import CartgraspError
from planning import WrenchPlanner

from .hostile import hostile_arms, hostile_cart, hostile_contacts, hostile_estimate, hostile_wrench
from .independent import judge

CALLS_OF_A_PLANNER = 20
STATUSES = {"optimal", "infeasible", "invalid_input", "stale_estimate", "timeout", "numerical"}


def hostile_planner(rng):
    """None where construction refuses; tame limits half of the time, so that many plans succeed, and compiled half of
    the time."""
    try:
        model, arms = hostile_cart(rng), hostile_arms(rng, share=float(rng.choice([0.0, 0.05])))
        planner = WrenchPlanner(model, arms)
        if rng.random() < 0.5:
            planner.warm_up()
        return model, arms, planner
    except CartgraspError:
        return None


def check_finite(plan):
    shown = [*plan.wrenches.values(), *plan.contacts.values()]
    if plan.nearest is not None:
        shown += [plan.nearest.wrench, *plan.nearest.wrenches.values()]
    if plan.held is not None:
        shown += [*plan.held.wrenches.values(), *plan.held.contacts.values()]
    assert all(np.isfinite(values).all() for values in shown)


def check_call(model, arms, planner, rng):
    wrench, contacts = hostile_wrench(rng), hostile_contacts(rng, arms)
    if rng.random() < 0.3:
        plan = planner.plan_or_hold(wrench, contacts)
        assert set(plan.contact_wrenches.wrenches) == {a.name for a in arms}
    else:
        plan = planner.plan(wrench, contacts, hostile_estimate(rng))
    assert plan.status in STATUSES
    check_finite(plan)
    if plan.status != "optimal":
        assert plan.message
        return plan.status
    judged = judge(model, arms, plan.contacts, wrench, plan.wrenches)
    assert max(judged) <= 1e-6, (judged, wrench, plan.contacts)
    return plan.status


def fuzz(seed, calls):
    """How often each status came."""
    rng, counts = np.random.default_rng(seed), Counter()
    while sum(counts.values()) < calls:
        built = hostile_planner(rng)
        if built is None:
            counts["refused construction"] += 1
            continue
        for _ in range(CALLS_OF_A_PLANNER):
            counts[check_call(*built, rng)] += 1
    return counts


@pytest.mark.long
def test_fuzzed_calls():
    counts = fuzz(0, 500)
    assert min(counts[status] for status in ("optimal", "infeasible", "invalid_input", "refused construction")) > 10


@pytest.mark.prove
@pytest.mark.parametrize("seed", range(1, 11))
def test_a_hundred_thousand_fuzzed_calls(seed, record_property):
    counts = fuzz(seed, 10_000)
    for status, count in counts.items():
        record_property(status, count)
    assert counts["optimal"] > 2000
    assert counts["infeasible"] > 1000
