"""An objective of your own is looked at: what is no convex cost is refused, wherever it stands in the whole."""

from __future__ import annotations

import numpy as np
import pytest

from cartgrasp.errors import UsageError
from planning import Objective, Smoothness, WrenchPlanner
from planning.objectives import Cost, Lexicographic, Nothing

from ..drawn import arm, cart

HAND = arm("left", friction=None)
ONES, ZEROS = np.ones(6), np.zeros(6)
LOPSIDED, INDEFINITE = np.triu(np.ones((6, 6))), np.diag([1.0, -1.0, 1.0, 1.0, 1.0, 1.0])
ONE_DIRECTION = np.outer(np.arange(6.0), np.arange(6.0)) / 7.0


class Mine(Objective):
    """Costs what it is told."""

    looks_back = False

    def __init__(self, cost):
        self.told = cost

    def cost(self, arms, previous):
        return self.told


@pytest.mark.parametrize(
    ("cost", "why"),
    [
        (None, "cost: None"),
        (Cost(-ONES, ZEROS), "weights: -1 is negative"),
        (Cost(ONES * np.nan, ZEROS), "weights has a number that is not finite"),
        (Cost(ONES, ZEROS + np.inf), "gradient has a number that is not finite"),
        (Cost(np.ones(5), ZEROS), r"weights is not an array \(6,\) of floats"),
        (Cost(np.ones(6, int), ZEROS), r"weights is not an array \(6,\) of floats"),
        (Cost(ONES, ZEROS, coupling=np.eye(5)), r"coupling is not an array \(6, 6\) of floats"),
        (Cost(ONES, ZEROS, coupling=LOPSIDED), "coupling is not symmetric"),
        (Cost(ONES, ZEROS, coupling=INDEFINITE), "positive semidefinite"),
    ],
)
def test_what_is_no_convex_cost_is_refused(cost, why):
    with pytest.raises(UsageError, match=f"objective: Mine: .*{why}"):
        WrenchPlanner(cart(), [HAND], objective=Mine(cost))


def test_it_is_looked_at_as_a_second_and_as_a_base():
    wrong = Mine(Cost(-ONES, ZEROS))
    for objective in (Lexicographic(Nothing(), wrong), Lexicographic(wrong, Nothing()), Smoothness(0.5, base=wrong)):
        with pytest.raises(UsageError, match="is negative"):
            WrenchPlanner(cart(), [HAND], objective=objective)


@pytest.mark.parametrize("coupling", [None, np.zeros((6, 6)), ONE_DIRECTION])
def test_a_convex_one_is_taken(coupling):
    objective = Mine(Cost(ONES, ONES, coupling=coupling))
    assert WrenchPlanner(cart(), [HAND], objective=objective).plan((20.0, 0.0, 1.0)).status == "optimal"
