"""Limits from outside are limits as any other: on every road, in words, and looked at when they are made."""

from dataclasses import dataclass, replace

import cvxpy
import numpy as np
import pytest

from cartgrasp.errors import UsageError
from planning import EmbeddedProblem, Limit, LimitRows, WrenchPlanner, WrenchPolytope
from planning.limits import limits_of
from planning.quadratic_program import Cone

from ..drawn import arm, cart

CONTACT = (-0.25, 0.1, 1.0)
PULL, BACKWARD = 18.0, np.array([-1.0, 0, 0, 0, 0, 0])


@dataclass(frozen=True)
class PullLimit(Limit):
    """At most so much force (N) backward."""

    force: float = PULL

    def rows(self, arm):
        row = np.array([[-1.0, 0, 0, 0, 0, 0]])
        return LimitRows(rows=row, limits=np.array([self.force]), names=("pull upper",))


@dataclass(frozen=True)
class Given(Limit):
    """Whatever rows."""

    said: object

    def rows(self, arm):
        return self.said


def hand(*limits):
    return arm("hand", contacts=[CONTACT], friction=None, limits=limits)


@pytest.mark.parametrize("solver", [None, "clarabel", "osqp", "daqp"])
def test_every_road_keeps_it(solver):
    planner = WrenchPlanner(cart(), [hand(PullLimit())], solver=solver)
    plan = planner.plan((-PULL + 0.5, 0.0, 0.0))
    assert plan.status == "optimal"
    assert plan.wrenches["hand"][0] >= -PULL - 1e-6
    beyond = planner.plan((-30.0, 0.0, 0.0))
    assert beyond.status == "infeasible"
    assert "hand: pull upper 18 N: it gives at most 18 N of backward force" in beyond.certificate.words
    assert planner.plan((30.0, 0.0, 0.0)).status == "optimal"


def test_problems_polytopes_and_c_have_it():
    bounded, free = hand(PullLimit()), hand()
    planner = WrenchPlanner(cart(), [bounded])
    planner.plan((-10.0, 0.0, 0.0))
    problem = planner.problem((-10.0, 0.0, 0.0))
    problem.solve(solver=cvxpy.CLARABEL)
    assert problem.status == "optimal"
    most = {one: WrenchPolytope.of(one).support(BACKWARD).distance for one in (bounded, free)}
    assert most[bounded] == pytest.approx(PULL)
    assert most[free] > 2 * PULL
    program = EmbeddedProblem.of(cart(), [bounded], {"hand": CONTACT}).program
    assert "hand: pull upper" in program.upper_names


def test_of_two_the_tighter_counts():
    assert limits_of(hand(PullLimit(), PullLimit(5.0))).limits.tolist() == [PULL, 5.0]
    plan = WrenchPlanner(cart(), [hand(PullLimit(), PullLimit(5.0))]).plan((-10.0, 0.0, 0.0))
    assert plan.certificate.limits == {"hand: pull upper": 5.0}


GOOD = PullLimit().rows(None)
ROUND = Cone("moments upper", np.vstack([np.zeros(6), np.eye(6)[3:]]), np.array([3.0, 0.0, 0.0, 0.0]))


def test_a_cone_with_a_fixed_axis_is_told_with_its_bound():
    """It was told as 0 N."""
    round_off = Given(LimitRows(cones=(ROUND,)))
    plan = WrenchPlanner(cart(), [hand(round_off)]).plan((0.0, 0.0, 40.0))
    assert plan.status == "infeasible"
    assert plan.certificate.limits["hand: moments upper"] == pytest.approx(3.0)
    assert "hand: moments upper 3 N·m" in plan.certificate.words


@pytest.mark.parametrize(
    ("said", "words"),
    [
        (None, r"rows: None is no LimitRows; return LimitRows\(...\)"),
        (replace(GOOD, names=("a", "b")), r"names: \['a', 'b'\] are not 1 names"),
        (replace(GOOD, names=("",)), "name each"),
        (replace(GOOD, rows=np.zeros((1, 3))), r"rows: .* is not \(1, 6\) numbers"),
        (replace(GOOD, rows=np.full((1, 6), np.inf)), "rows: .* has a number that is not finite"),
        (replace(GOOD, limits=np.array([np.nan])), r"limits: \[nan\] is not \(1,\) numbers"),
        (replace(GOOD, limits=np.array([-1.0])), "leaves out the wrench 0"),
        (replace(GOOD, lower=np.full(6, 1.0)), "leaves out the wrench 0"),
        (replace(GOOD, cones=("round",)), "cones: 'round' is no Cone"),
        (
            replace(GOOD, cones=(replace(ROUND, name=""),)),
            r"cones: '' has rows \(4, 6\) and an offset \(4,\); give it a",
        ),
        (replace(GOOD, cones=(replace(ROUND, offset=np.ones(3)),)), r"has rows \(4, 6\) and an offset \(3,\)"),
        (replace(GOOD, cones=(replace(ROUND, rows=np.ones((4, 3))),)), r"has rows \(4, 3\)"),
        (replace(GOOD, cones=(replace(ROUND, offset=np.full(4, np.nan)),)), "moments upper has what is no number"),
        (replace(GOOD, cones=(replace(ROUND, offset=np.array([1.0, 2.0, 0.0, 0.0])),)), "leaves out the wrench 0"),
    ],
)
def test_what_is_wrong_with_its_rows_is_said(said, words):
    with pytest.raises(UsageError, match=f"^arm hand: limits: Given: .*{words}"):
        WrenchPlanner(cart(), [hand(Given(said))])


def test_what_is_no_limit_is_refused():
    with pytest.raises(UsageError, match=r"arm hand: limits: 3 is no UserLimit; write limits=\[MyLimit\(\)\]"):
        hand(3)
