"""Every objective sits the same exam: it is what its formula says, convex, and does what it is for."""

from __future__ import annotations

import numpy as np
import pytest

from cartgrasp.errors import UsageError
from cartgrasp.frames import rotation_planar
from planning import LoadShare, Smoothness, WeightedWrench, WrenchPlanner, allocate
from planning.allocation_template import AllocationTemplate

from .drawn import arm, cart, first_contacts

ARMS = [
    arm("left", weights=(1, 2, 3, 4, 5, 6), yaw=0.4),
    arm("right", [(-0.25, -0.2, 1.0)], weights=(2, 2, 1, 9, 9, 9)),
]
WEIGHTS = np.array([1, 2, 3, 4, 5, 6, 2, 2, 1, 9, 9, 9.0])


def effort(f, _):
    return WEIGHTS @ f**2


def change(f, previous):
    return effort(f, previous) + 0.5 * WEIGHTS @ (f - previous) ** 2


def shared(f, previous):
    left, right = rotation_planar(0.4) @ f[:2], f[6:8]
    total = left + right
    return effort(f, previous) + 3 * (np.sum((left - 0.7 * total) ** 2) + np.sum((right - 0.3 * total) ** 2))


OBJECTIVES = [
    (WeightedWrench(), effort),
    (Smoothness(0.5), change),
    (LoadShare({"left": 0.7, "right": 0.3}, 3.0), shared),
    (
        Smoothness(0.5, LoadShare({"left": 0.7, "right": 0.3}, 3.0)),
        lambda f, p: shared(f, p) + change(f, p) - effort(f, p),
    ),
    (
        LoadShare({"left": 0.7, "right": 0.3}, 3.0, Smoothness(0.5)),
        lambda f, p: shared(f, p) + change(f, p) - effort(f, p),
    ),
]


@pytest.mark.parametrize(("objective", "formula"), OBJECTIVES)
def test_exam(objective, formula):
    rng = np.random.default_rng(3)
    previous, wrenches = rng.normal(size=12), rng.normal(size=(5, 12))
    cost = objective.cost(ARMS, previous)
    coupling = np.zeros((12, 12)) if cost.coupling is None else cost.coupling
    for f in wrenches:
        value = cost.weights @ f**2 + cost.gradient @ f + f @ coupling @ f + cost.constant
        assert value == pytest.approx(formula(f, previous), rel=1e-12)
    assert np.linalg.eigvalsh(coupling).min() >= -1e-12
    template = AllocationTemplate.of(cart(), ARMS, objective)
    assert template.hessian == pytest.approx(2 * np.diag(cost.weights) + 2 * coupling)
    other = objective.cost(ARMS, previous + 1)
    assert objective.looks_back == (other.constant != cost.constant)
    assert other.weights == pytest.approx(cost.weights)


@pytest.mark.parametrize(("objective", "formula"), OBJECTIVES)
def test_a_plan_is_no_worse_than_its_neighbours(objective, formula):
    """Steps along the null space of the equality, by the formula and not by the program."""
    planner = WrenchPlanner(cart(), ARMS, objective=objective)
    first = planner.plan((30, 0, 2))
    previous = np.concatenate(list(first.wrenches.values()))
    plan = planner.plan((36, 0, 1))
    x = np.concatenate(list(plan.wrenches.values()))
    template = AllocationTemplate.of(cart(), ARMS)
    matrix = np.hstack(list(template.contact_rows(np.array([plan.contacts[a.name] for a in ARMS]))))
    null = np.linalg.svd(matrix)[2][len(matrix) :]
    for direction in null:
        for step in (1e-3, -1e-3):
            assert formula(x + step * direction, previous) > formula(x, previous)


def test_smoothness_slows_a_change():
    """A contact that moves from y = 0.1 to 0.3 moves the load; the more a change costs, the less of it."""
    moved = []
    for objective in (None, Smoothness(1.0), Smoothness(10.0)):
        planner = WrenchPlanner(cart(), ARMS, objective=objective)
        held = [{"left": (-0.25, y, 1), "right": (-0.25, -0.2, 1)} for y in (0.1, 0.3)]
        before, after = (planner.plan((30, 0, 3), contacts=contacts) for contacts in held)
        moved.append(np.linalg.norm(after.wrenches["left"] - before.wrenches["left"]))
    assert moved[0] > moved[1] > moved[2]


def test_a_heavy_share_is_kept():
    arms = [arm("left", friction=None), arm("right", [(-0.25, -0.2, 1.0)], friction=None)]
    objective = LoadShare({"left": 0.8, "right": 0.2}, 1e6)
    found = allocate(cart(), arms, first_contacts(arms), (30, 0, 0), objective)
    assert found.wrenches["left"][0] == pytest.approx(24, abs=1e-2)
    assert found.wrenches["right"][0] == pytest.approx(6, abs=1e-2)


def test_what_is_refused():
    for shares in ({"left": 0.5, "right": 0.4}, {"left": -0.1, "right": 1.1}, {"left": np.nan}, {}):
        with pytest.raises(UsageError, match="load share"):
            LoadShare(shares)
    with pytest.raises(UsageError, match="rate"):
        Smoothness(-1.0)
    with pytest.raises(UsageError, match="left"):
        WrenchPlanner(cart(), ARMS, objective=LoadShare({"left": 1.0}))
