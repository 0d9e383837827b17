"""The hand's state machine, by what must hold of any hand at any rhythm of ticks."""

from __future__ import annotations

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cartgrasp.errors import UsageError
from planning.control.hand import Hand, Phase, RegraspTimes

coordinates = st.floats(-2.0, 2.0)
points = st.tuples(coordinates, coordinates, coordinates)
spans = st.one_of(st.just(0.0), st.floats(0.01, 1.0))
times = st.builds(RegraspTimes, st.floats(0.1, 2.0), spans, spans, spans)
ticks = st.lists(st.floats(0.001, 0.05), min_size=1, max_size=400)


@settings(max_examples=150, deadline=None)
@given(points, st.lists(points, min_size=1, max_size=3), times, ticks)
def test_a_hand_never_jumps(start, targets, taking, rhythm):
    """Speed bounded; share 0 whenever it moves; ramps no steeper than told; phases in order; nothing is lost."""
    hand, order = Hand(start), list(Phase)
    for i, tick in enumerate(rhythm):
        before = hand
        hand = before.sent(targets[i % len(targets)]).after(tick, taking)
        moved = math.dist(before.point, hand.point)
        assert moved <= taking.speed * tick * (1 + 1e-6) + 1e-12
        if moved > 0 or hand.is_away:
            assert hand.share == 0.0
        if moved > 0:
            assert before.share == 0.0
        assert 0.0 <= hand.share <= 1.0
        steepest = max(math.inf if t == 0 else tick / t for t in (taking.unload, taking.load))
        assert abs(hand.share - before.share) <= steepest * (1 + 1e-6) + 1e-8
        steps = (order.index(hand.phase) - order.index(before.phase)) % len(order)
        assert steps <= 2 if before.phase is Phase.HOLDS else steps <= 1
        assert (hand.phase is Phase.HOLDS) <= (hand.share == 1.0 and hand.target is None)


@settings(max_examples=100, deadline=None)
@given(points, points, times, st.floats(0.001, 0.05))
def test_a_regrasp_ends_when_it_should(start, target, taking, tick):
    """At the contact it was sent to, holding wholly, after the time told and at most a tick more for each phase."""
    hand, spent = Hand(start).sent(target), 0.0
    away = 0.0
    whole = taking.lasting(math.dist(start, target)) + 4 * tick + 1e-6
    while hand.phase is not Phase.HOLDS:
        hand = hand.after(tick, taking)
        spent += tick
        away += tick * hand.is_away
        assert spent <= whole
    assert hand == Hand(target)
    if start != target:
        assert spent >= taking.lasting(math.dist(start, target)) - 1e-6
        assert away >= taking.away(math.dist(start, target)) - tick - 1e-6


def test_a_hand_on_its_way_takes_no_other_way():
    hand = Hand((0.0, 0.0, 1.0)).sent((0.5, 0.0, 1.0)).after(0.1, RegraspTimes())
    assert hand.sent((0.0, 0.5, 1.0)) == hand
    assert hand.share == pytest.approx(0.5)
    there = Hand((0.0, 0.0, 1.0))
    assert there.sent((0.0, 0.0, 1.0)) is there


@pytest.mark.parametrize("wrong", [{"speed": 0.0}, {"unload": -1.0}, {"load": math.nan}, {"take_hold": 1e3}])
def test_impossible_times_are_refused(wrong):
    with pytest.raises(UsageError, match="regrasp: "):
        RegraspTimes(**wrong)
