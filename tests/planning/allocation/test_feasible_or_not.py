"""Feasible or not, against an LP oracle: HiGHS finds how far a wrench can be scaled before the arms can't give it.

Zero is within all limits, so t times a wrench is feasible up to some largest t, and what is asked is set to either
side of it, down to a relative 1e-6. An infeasible answer must come with a direction along which numpy, by weak duality
with multipliers of its own, finds less than what is asked.
"""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest

from planning import WrenchPlanner

from ..drawn import first_contacts, largest_scale, random_arms, random_cart
from ..independent import farkas_margin, judge

MARGIN = 1e-6
INSTANCES_OF_A_PLANNER = 10


def scaled_to_either_side(rng, wrench, largest):
    """A wrench at a relative distance of 1e-6 to 1 from the largest one, and whether it is feasible."""
    if np.isinf(largest):
        return wrench, True
    if largest < 1e-9:  # nothing along this direction: any length is too much, and none is feasible
        return wrench, False
    is_feasible = rng.random() < 0.5
    distance = 10 ** rng.uniform(np.log10(MARGIN), 0)
    return wrench * largest * (1 / (1 + distance) if is_feasible else 1 + distance), is_feasible


def check_instance(model, arms, planner, rng):
    """What the planner said; it agrees with the oracle and proves it."""
    contacts = first_contacts(arms) if rng.random() < 0.5 else {a.name: rng.uniform(-0.5, 0.5, 3) for a in arms}
    wrench = rng.uniform((-5, -20, -12), (80, 20, 12))
    largest = largest_scale(model, arms, contacts, wrench)
    wrench, is_feasible = scaled_to_either_side(rng, wrench, largest)
    plan = planner.plan(wrench, contacts)
    assert plan.status == ("optimal" if is_feasible else "infeasible"), (wrench, contacts, largest, plan.message)
    if is_feasible:
        assert max(judge(model, arms, contacts, wrench, plan.wrenches)) <= 1e-6
    else:
        assert plan.certificate.verified
        assert farkas_margin(model, arms, contacts, wrench, plan.certificate.direction) > 0
    return plan.status


def compare(seed, instances):
    rng, counts = np.random.default_rng(seed), Counter()
    while sum(counts.values()) < instances:
        model, arms = random_cart(rng), random_arms(rng, int(rng.integers(1, 5)))
        planner = WrenchPlanner(model, arms)
        for _ in range(INSTANCES_OF_A_PLANNER):
            counts[check_instance(model, arms, planner, rng)] += 1
    return counts


@pytest.mark.long
def test_a_planner_agrees_with_an_lp():
    counts = compare(0, 200)
    assert min(counts["optimal"], counts["infeasible"]) > 60


@pytest.mark.prove
@pytest.mark.parametrize("seed", range(1, 11))
def test_a_planner_agrees_with_an_lp_on_ten_thousand(seed, record_property):
    counts = compare(seed, 1000)
    for status, count in counts.items():
        record_property(status, count)
    assert min(counts["optimal"], counts["infeasible"]) > 300
