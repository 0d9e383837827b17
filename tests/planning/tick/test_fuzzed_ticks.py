"""Ticks in a row on one planner, whatever is sent: arms, estimates, contacts and wrenches change, and are at times
rubbish. What must be refused is, what is taken counts from then on, and every answer is judged by independent code.
"""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest

from cartgrasp.errors import UsageError
from planning import SearchLimit, WrenchPlanner

from ..mirror import Mirror
from ..tick_judge import check_contacts, check_infeasible, check_usable
from ..ticks import BAD, EITHER, GOOD, drawn_arm, drawn_cart, drawn_cart_limits, drawn_objective, drawn_tick

TICKS = 25
NAMES = ["left", "right", "third arm", "force fx", "五", "x" * 300, "7", "_"]
REFUSALS = {"invalid_input", "stale_estimate"}


class Run:
    """A planner, and what it should have in mind."""

    def __init__(self, rng):
        self.rng, cart = rng, drawn_cart(rng)
        names = NAMES[: int(rng.choice([1, 2, 3, 8], p=[0.25, 0.55, 0.18, 0.02]))]
        arms = [drawn_arm(rng, name, 1 if len(names) > 3 else None) for name in names]
        limits = drawn_cart_limits(rng, cart)
        confidence = float(rng.choice([0.5, 0.9, 0.99])) if rng.random() < 0.3 else None
        self.relax, self.distance = float(rng.choice([0.0, 0.0, 5.0, np.inf])), float(rng.choice([0.0, 0.0, 0.1]))
        objective, period = drawn_objective(rng, names), float(rng.choice([1e-3, 1e-2]))
        self.planner = WrenchPlanner(
            cart,
            arms,
            objective=objective,
            cart_limits=limits,
            confidence=confidence,
            min_hand_distance=self.distance,
            relax=self.relax,
            search_limit=SearchLimit(60),
            period=period,
        )
        self.mirror = Mirror(cart, {a.name: a for a in arms}, limits, objective, confidence, period)
        if rng.random() < 0.5:
            self.planner.warm_up()

    def tick(self):
        """One call, checked; its status."""
        self._between()
        tick = drawn_tick(self.rng, self.mirror)
        sent = {"contacts": tick.contacts.value, "estimate": tick.estimate.value, "arms": tick.arms.value}
        holds = self.rng.random() < 0.7
        plan = (self.planner.plan_or_hold if holds else self.planner.plan)(tick.wrench.value, **sent)
        refused_by = self._follow(tick, plan)
        if refused_by is not None:
            assert plan.status == ("stale_estimate" if refused_by == "stale" else "invalid_input"), plan
            assert plan.message.startswith(
                ("arm", "wrench", "estimate", "contacts", "least joint torque", "worst arm", "load share")
            )
        else:
            assert plan.status not in REFUSALS, plan.message
            self._judge(plan, tick.wrench.value, tick.contacts.value or {})
        self._check_given(plan, holds)
        return plan.status

    def _between(self):
        """At times a reset, or another start."""
        dice, mirror = self.rng.random(), self.mirror
        if dice < 0.03:
            self.planner.reset()
            mirror.reset()
        elif dice < 0.06:
            wrenches = self.rng.normal(size=(len(mirror.arms), 6)) * self.rng.choice([0.0, 1e-3, 5.0, 1e4])
            self.planner.start_from(dict(zip(mirror.arms, wrenches, strict=True)))
            mirror.start_from(wrenches.ravel())
        elif dice < 0.08:
            odd = [{"nobody": np.zeros(6)}, {"left": (1, 2)}, {"left": "abc"}, [1], None, {"left": np.full(6, np.nan)}]
            with pytest.raises(UsageError, match="start_from"):
                self.planner.start_from(odd[int(self.rng.integers(len(odd)))])

    def _follow(self, tick, plan):
        """Does to the mirror what the planner should have done; what it should have refused, or None."""
        mirror = self.mirror
        if tick.arms.verdict == BAD:
            return "arms"
        if tick.arms.value is not None:
            mirror.take_arms(tick.arms.value)
        if tick.wrench.verdict == BAD:
            return "wrench"
        verdict = tick.estimate.verdict
        if verdict == EITHER:
            verdict = BAD if plan.status in REFUSALS and plan.message.startswith("estimate") else GOOD
        if verdict != GOOD:
            return verdict
        if tick.estimate.value is not None:
            mirror.take_estimate(tick.estimate.value)
        is_bad = tick.contacts.verdict == BAD or set(tick.contacts.value or {}) - set(mirror.arms)
        return "contacts" if is_bad else None

    def _judge(self, plan, wrench, given):
        mirror = self.mirror
        wrench = np.asarray(wrench, float)
        if plan.is_usable:
            check_contacts(mirror, given, plan, self.distance)
            check_usable(mirror, plan, wrench, self.relax)
            assert plan.choice.bound <= plan.proof[1].cost * (1 + 1e-6) + 1e-6 or plan.status == "relaxed"
        elif plan.status == "infeasible":
            check_infeasible(mirror, plan, wrench, self.relax, given)
        else:
            assert plan.status in ("timeout", "numerical")
            assert plan.message

    def _check_given(self, plan, holds):
        """What the arms are to do is finite, and within their limits and rates."""
        mirror = self.mirror
        if not plan.is_usable and not holds:
            return
        given = plan.contact_wrenches
        x = np.concatenate([given.wrenches[name] for name in mirror.arms])
        assert np.isfinite(x).all()
        assert np.isfinite(np.concatenate(list(given.contacts.values()))).all()
        assert {name: arm.yaw for name, arm in mirror.arms.items()} == dict(given.yaws)
        if not plan.is_usable:
            rows, limits = mirror.of_arms()
            assert (rows @ x - limits).max(initial=0.0) <= 1e-7 * max(1.0, np.abs(x).max())
            assert np.abs(x).max() <= np.abs(mirror.last).max() * (1 + 1e-9) + 1e-7
        mirror.last = x


def fuzz(seed, calls):
    """How often each status came."""
    rng, counts = np.random.default_rng(seed), Counter()
    while sum(counts.values()) < calls:
        try:
            run = Run(rng)
        except UsageError:
            continue
        for _ in range(TICKS):
            counts[run.tick()] += 1
    return counts


@pytest.mark.long
def test_fuzzed_ticks():
    counts = fuzz(0, 1200)
    wanted = ("optimal", "relaxed", "infeasible", "invalid_input", "stale_estimate")
    assert min(counts[status] for status in wanted) > 10


@pytest.mark.prove
@pytest.mark.parametrize("seed", range(1, 11))
def test_a_hundred_thousand_fuzzed_ticks(seed, record_property):
    counts = fuzz(seed, 10_000)
    for status, count in counts.items():
        record_property(status, count)
    assert min(counts[status] for status in ("optimal", "infeasible", "invalid_input")) > 500
    assert counts["numerical"] + counts["timeout"] <= 0.005 * sum(counts.values())
