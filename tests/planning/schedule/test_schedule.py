"""Schedules against enumeration of every sequence, closed forms, and Bellman's principle."""

from functools import cache
from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cartgrasp.arms import Arm
from cartgrasp.constraints import RollingConstraints
from cartgrasp.effects import LoadSlosh, ViscousDrag
from cartgrasp.errors import UsageError
from cartgrasp.inertia import Inertia
from cartgrasp.model import CartModel
from cartgrasp.motion import Motion
from planning.allocation.allocation import allocate, build_allocation
from planning.references import PathReference, Stretch, chain, pause, turn
from planning.schedule.regrasp_graph import RegraspGraph
from planning.schedule.schedule import Grip, Horizon, RegraspCost, plan_schedule, wanted_wrench
from planning.tracking import build_tracker

from ..reference_allocation import solve_reference

MASS, OFF = 20.0, 0.1
CART = CartModel(Inertia(MASS, (0.3, OFF), 2.0), effects=(ViscousDrag(4.0, 1.0),))
FRICTIONLESS = CartModel(Inertia(MASS, (0.3, OFF), 2.0))
AWAY = None


def push(acceleration=0.5, ramp=1.0, rest=1.0):
    """Rest, faster, slower."""
    return PathReference((*pause(rest), Stretch(ramp, acceleration), Stretch(ramp, -acceleration)))


def enumerated(reference, cart, arms, cost, length):
    """The least over every sequence of every arm that holds its first point before, walked through in seconds; stage
    QPs by cvxpy and Clarabel."""
    n_stages = round(reference.duration / length)

    @cache
    def effort(k, held):
        wrench = wanted_wrench(reference, cart, (k + 0.5) * length)
        grips = {arm.name: arm.contacts.points[i] for arm, i in zip(arms, held, strict=True) if i is not AWAY}
        if not grips:
            return 0.0 if np.abs(cart.basis_b.T @ wrench).max() < 1e-9 else np.inf
        program = build_allocation(cart, [arm for arm in arms if arm.name in grips], grips, wrench)
        found = solve_reference(program)
        return found.cost if found.status.startswith("optimal") else np.inf

    def walks(count):
        """(what is held by stage, number of regrasps) of one arm."""
        for goals in product(range(count), repeat=n_stages):
            held, ready, n, fine = [], 0.0, 0, True
            for k, goal in enumerate(goals):
                time = k * length
                if goal != (goals[k - 1] if k else 0):
                    fine = fine and time > ready - 1e-9
                    ready, n = time + cost.duration, n + 1
                held.append(goal if time > ready - 1e-9 else AWAY)
            if fine:
                yield tuple(held), n

    best = np.inf
    for walk in product(*(list(walks(len(arm.contacts.points))) for arm in arms)):
        total = cost.effort * sum(n for _, n in walk)
        for k, held in enumerate(zip(*(held for held, _ in walk), strict=True)):
            total += length * effort(k, held)
            if total > best:
                break
        best = min(best, total)
    return best


@pytest.mark.long
@settings(max_examples=6)
@given(st.integers(0, 2**32 - 1))
def test_the_optimum_of_every_sequence(seed):
    rng = np.random.default_rng(seed)
    n_arms = int(rng.integers(1, 3))
    arms = [
        Arm(
            f"arm{i}",
            [(x, y, 1.0) for x, y in rng.uniform(-0.4, 0.4, (4 - n_arms, 2))],
            force_limit=(rng.uniform(8, 40), 20, 20),
            moment_limit=(4, 4, rng.uniform(2, 8)),
        )
        for i in range(n_arms)
    ]
    cost = RegraspCost(duration=float(rng.choice([0.0, 0.5, 1.0])), effort=float(rng.choice([0.0, 5.0, 40.0])))
    reference = PathReference(
        (*pause(0.5), Stretch(0.5, 0.8), Stretch(0.5, 0, 0.8), Stretch(0.5, 0, -0.8), Stretch(0.5, -0.8))
        if rng.random() < 0.5
        else (*pause(1.0), Stretch(1.0, 0.5), Stretch(1.0, -0.5))
    )
    held = {arm.name: Grip(arm.contacts.first) for arm in arms}
    schedule = plan_schedule(reference, CART, arms, cost, Horizon(stage=0.5, held=held))
    best = enumerated(reference, CART, arms, cost, 0.5)
    if np.isinf(best):
        assert schedule.status == "infeasible"
        assert schedule.blocked
        assert np.isinf(schedule.bound)
        return
    assert schedule.total == pytest.approx(best, rel=1e-6)
    assert schedule.bound <= schedule.total + 1e-12
    assert schedule.total - schedule.bound < 1e-8 * max(1.0, schedule.total)
    paid = 0.5 * schedule.efforts.sum() + cost.effort * len(schedule.regrasps)
    assert paid == pytest.approx(schedule.total)


@pytest.mark.parametrize(("share", "worth"), [(0.95, True), (1.05, False)])
@pytest.mark.parametrize("duration", [0.25, 1.0])
def test_closed_form_of_what_a_regrasp_is_worth(share, worth, duration):
    """A push `m a` at y needs the moment `m a (y - dy)`: y = dy saves 10 (m a dy)² for as long as it is pushed."""
    ramp, acceleration = 1.0, 0.5
    saved = 10 * (MASS * acceleration * OFF) ** 2 * 2 * ramp
    hand = Arm("hand", [(0.0, 0.0, 1.0), (0.0, OFF, 1.0)], force_limit=(100, 0, 0))
    horizon = Horizon(held={"hand": Grip(np.array([0.0, 0.0, 1.0]))})
    cost = RegraspCost(duration, share * saved)
    schedule = plan_schedule(push(acceleration, ramp), FRICTIONLESS, [hand], cost, horizon)
    assert len(schedule.regrasps) == int(worth)
    least = (MASS * acceleration) ** 2 * 2 * ramp
    assert schedule.total == pytest.approx(least + min(1.0, share) * saved)
    if worth:
        regrasp = schedule.regrasps[0]
        assert regrasp.stop <= 1.0 + 1e-9, "the only hand can let go only while the cart rests"
        assert regrasp.stop - regrasp.start == pytest.approx(duration)
        assert regrasp.target[1] == OFF


def test_no_time_to_regrasp():
    """Free of effort, but the one hand never may let go: at rest too short a time, then drag has to be overcome."""
    hand = Arm("hand", [(0.0, 0.0, 1.0), (0.0, OFF, 1.0)])
    horizon = Horizon(held={"hand": Grip(np.array([0.0, 0.0, 1.0]))})
    assert plan_schedule(push(rest=0.5), CART, [hand], RegraspCost(0.75), horizon).regrasps == ()
    assert len(plan_schedule(push(rest=0.5), CART, [hand], RegraspCost(0.5), horizon).regrasps) == 1


def test_replanned_on_the_way_costs_what_was_left():
    """Bellman: from the grips of any stage, also with a hand on its way, the rest is as good as it was."""
    arms = [Arm("left", [(-0.2, 0.3, 1.0), (-0.2, 0.0, 1.0)]), Arm("right", [(-0.2, 0.4, 1.0), (0.1, -0.2, 1.0)])]
    path = chain(pause(0.5), [Stretch(1.0, 0.6)], turn(1.2, 0.6, 1.2), turn(-0.6, 0.6, 1.2), [Stretch(1.0, -0.6)])
    reference, cost = PathReference(path), RegraspCost(0.75, 1.0)
    held = {arm.name: Grip(arm.contacts.first) for arm in arms}
    whole = plan_schedule(reference, CART, arms, cost, Horizon(stage=0.25, held=held))
    assert any(regrasp.start < time < regrasp.stop for regrasp in whole.regrasps for time in whole.times)
    length = float(np.diff(whole.times)[0])
    for k in range(1, len(whole.times) - 1):
        now = float(whole.times[k])
        rest = plan_schedule(reference, CART, arms, cost, Horizon(now, length, whole.grips(now)))
        started = sum(r.start < now - 1e-9 for r in whole.regrasps)
        paid = length * whole.efforts[:k].sum() + cost.effort * started
        assert paid + rest.total == pytest.approx(whole.total, rel=1e-9)


def test_a_horizon_that_ends_early_is_that_of_its_stages():
    """With a length beyond the reference's end nothing changes; with half of it the first stages alone count."""
    arm = Arm("hand", [(0.0, 0.0, 1.0), (-0.1, 0.2, 1.0), (-0.1, -0.2, 1.0)])
    whole, beyond, half = (
        plan_schedule(push(), CART, [arm], RegraspCost(0.0), Horizon(stage=0.25, length=length))
        for length in (np.inf, 60.0, 1.5)
    )
    assert np.array_equal(beyond.times, whole.times)
    assert beyond.total == whole.total
    assert half.times[-1] == pytest.approx(1.5)
    stages = len(half.efforts)
    assert half.total == pytest.approx(whole.efforts[:stages].sum() * 0.25)  # regrasps are free, so stages are apart


@pytest.mark.parametrize("left", [0.2, 1e-3, 1e-5])
def test_less_time_is_left_than_a_regrasp_takes(left):
    """Nobody lets go, and a hand on its way does not arrive: the other bears the rest."""
    sides = {"left": 1, "right": -1}
    arms = [Arm(name, [(x, side * 0.3, 1.0) for x in (-0.2, -0.1, 0.0)]) for name, side in sides.items()]
    reference = push()
    now = reference.duration - left
    first = {arm.name: arm.contacts.first for arm in arms}
    for ready, holding in ((-np.inf, arms), (now + 1.0, arms[1:])):
        held = {"left": Grip(first["left"], ready), "right": Grip(first["right"])}
        rest = plan_schedule(reference, CART, arms, RegraspCost(1.5, 0.0), Horizon(now, held=held))
        wrench = wanted_wrench(reference, CART, now + left / 2)
        effort = allocate(CART, holding, {arm.name: first[arm.name] for arm in holding}, wrench).effort
        assert rest.total == pytest.approx(left * effort)
        assert rest.regrasps == ()


def test_a_heavier_cart_is_scheduled_anew():
    """What is not worth a regrasp for 5 kg is for 40 kg."""
    hand = Arm("hand", [(0.0, 0.0, 1.0), (0.0, OFF, 1.0)])
    horizon = Horizon(held={"hand": Grip(np.array([0.0, 0.0, 1.0]))})
    regrasps = [
        len(
            plan_schedule(
                push(), CartModel(Inertia(m, (0.3, OFF), 2.0)), [hand], RegraspCost(0.5, 10), horizon
            ).regrasps
        )
        for m in (5.0, 40.0)
    ]
    assert regrasps == [0, 1]


def test_a_stage_that_no_grip_can_do_is_named():
    weak = Arm("hand", [(0.0, 0.0, 1.0), (0.0, 0.1, 1.0)], force_limit=(8, 8, 8))
    schedule = plan_schedule(push(), FRICTIONLESS, [weak], horizon=Horizon(stage=0.5))
    assert schedule.status == "infeasible"
    assert [(b.start, b.stop) for b in schedule.blocked] == [(1.0, 1.5), (1.5, 2.0), (2.0, 2.5), (2.5, 3.0)]
    assert "hand: fx" in schedule.blocked[0].words
    assert schedule.contacts == {}


def test_a_stage_that_no_sequence_reaches_is_named():
    """Each stage can be done, but the push needs another point than the hand starts from, and time to get there."""
    hand = Arm("hand", [(0.0, 0.0, 1.0), (0.0, OFF, 1.0)], moment_limit=(1, 1, 0.1))
    held = {"hand": Grip(np.array([0.0, 0.0, 1.0]))}
    late = plan_schedule(push(rest=0.5), FRICTIONLESS, [hand], RegraspCost(0.75), Horizon(held=held))
    assert late.status == "infeasible"
    assert late.blocked[0].start == pytest.approx(0.5)
    assert "no sequence of regrasps" in late.blocked[0].words
    assert (
        plan_schedule(push(rest=1.0), FRICTIONLESS, [hand], RegraspCost(0.75), Horizon(held=held)).status == "optimal"
    )


def test_hands_keep_their_distance():
    arms = [Arm("left", [(-0.2, 0.0, 1.0), (-0.2, 0.3, 1.0)]), Arm("right", [(-0.2, 0.0, 1.0), (-0.2, -0.3, 1.0)])]
    schedule = plan_schedule(push(), CART, arms, horizon=Horizon(min_hand_distance=0.5))
    distance = np.linalg.norm(schedule.contacts["left"] - schedule.contacts["right"], axis=1)
    assert distance.min() > 0.5
    assert schedule.regrasps == ()


@given(st.lists(st.integers(1, 3), min_size=1, max_size=3), st.integers(0, 3))
def test_states_are_counted_right(counts, stages):
    """Every state has a way on, all ways end in states, and names of states are read back."""
    graph = RegraspGraph.of(counts, stages)
    n_states = int(np.prod([count * max(1, stages) for count in counts]))
    assert set(graph.options.before) == set(range(n_states))
    assert set(graph.options.after) <= set(range(n_states))
    for state in graph.at_rest:
        assert graph.state(graph.grips(int(state)), [0] * len(counts)) == state


@pytest.mark.parametrize(
    ("horizon", "said"),
    [
        (Horizon(now=9.0), "before the reference's end"),
        (Horizon(stage=0.0), "stage of 0.0 s"),
        (Horizon(length=0.0), "length of 0.0 s"),
        (Horizon(held={"foot": Grip(np.zeros(3))}), "foot"),
        (Horizon(held={"hand": Grip(np.ones(3))}), "none of its points"),
        (Horizon(held={"hand": Grip(np.zeros(3), ready=2.0)}), "ready at 2 s"),
    ],
)
def test_what_can_not_be_scheduled(horizon, said):
    with pytest.raises(UsageError, match=said):
        plan_schedule(push(), CART, [Arm("hand", [(0.0, 0.0, 0.0)])], horizon=horizon)


def test_segments_and_wrong_costs_are_refused():
    with pytest.raises(UsageError, match="segment"):
        plan_schedule(push(), CART, [Arm("hand", segment=[(0, 0, 1), (0, 1, 1)])])
    with pytest.raises(UsageError, match="regrasp"):
        RegraspCost(duration=-1.0)
    with pytest.raises(UsageError, match="too many"):
        RegraspGraph.of([12, 12, 12, 12], 4)


@pytest.mark.parametrize("constraints", [RollingConstraints(0.3), RollingConstraints(None)])
def test_a_schedule_is_made_for_what_the_tracker_asks_for(constraints):
    """Which takes what swings to go along: it swings about what a cart without would need."""
    cart = CartModel(CART.inertia, constraints, CART.effects)
    path = PathReference(chain([Stretch(1.0, 0.5)], turn(0.8, 0.4), [Stretch(1.0, -0.5)]), constraints)
    swinging = cart.with_effect(LoadSlosh(8.0, 1.0, 0.1))
    for time in (0.5, 1.4, 2.0, path.duration - 0.5):
        wanted = path.at(time)
        asked = build_tracker(constraints).wrench_b(wanted, Motion(wanted.pose_sb, wanted.velocity), swinging)
        for one in (wanted_wrench(path, swinging, time), wanted_wrench(path, cart, time)):
            np.testing.assert_allclose(one, asked, atol=1e-9)
