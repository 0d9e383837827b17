"""What to run next, in words: what the motion tells, what it leaves open, and what no motion would tell."""

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from cartgrasp.effects import ViscousDrag
from estimation.discrepancy.diagnosis.next_experiments import (
    NOTHING_OPEN,
    NextExperiment,
    next_experiment,
    undetected_size,
)
from estimation.discrepancy.search.gains import CONFUSABLE_NATS
from estimation.discrepancy.search.plausibility import MIN_NAMED_SIZE_RATIO
from estimation.experiments.manoeuvres import Limits, pieces
from estimation.experiments.proposal import Experiment, Proposal, Question

POSE = (1.0, 2.0, 0.5)
ROLL = pieces(Limits(), SimpleNamespace(no_rotation=True))[0]


@pytest.fixture(autouse=True)
def nothing_open(monkeypatch):
    monkeypatch.setattr("estimation.discrepancy.diagnosis.next_experiments.undecided", lambda _: None)


def diagnosis(names=(), verdict="explained", laws=(), may_follow=(), is_moved=True, arms=("hand",)):
    effect = SimpleNamespace(name="force_bias", label="", confusable_with=tuple(names))
    hand = SimpleNamespace(contact=np.tile([-0.3, 0.1, 1.0], (2, 1)))
    log = SimpleNamespace(
        arms=dict.fromkeys(arms, hand), pose=np.array([[np.nan] * 3, [1.0, 2.0, 0.5]]), time=np.array([0.0, 1.0])
    )
    return SimpleNamespace(
        effects=(effect,),
        checks=(SimpleNamespace(noise=SimpleNamespace(force=3.0, moment=0.1, position=5e-4), rate=100.0),),
        final=SimpleNamespace(logs=(SimpleNamespace(log=log),), laws=laws),
        may_follow=may_follow,
        is_moved=is_moved,
        verdict=verdict,
        limits=Limits(),
    )


@pytest.fixture
def asked(monkeypatch):
    """Of questions, each with the deviations that the best motion gives."""

    def told(answers, size=1.0):
        """The last question is of an effect of that size."""
        questions = tuple(Question(*names, 0, 0) for names, _ in answers)
        questions = (*questions[:-1], replace(questions[-1], size=size))
        found = Proposal((ROLL,), POSE, questions, tuple(z for _, z in answers))
        monkeypatch.setattr(
            "estimation.discrepancy.diagnosis.next_experiments.undecided", lambda _: Experiment((), (), None)
        )
        monkeypatch.setattr(Experiment, "proposed", lambda self, limits, start, time: found)
        return next_experiment(diagnosis())

    return told


@pytest.mark.parametrize("z", [5.0, 1.0])
def test_where_nothing_usual_is_shown_a_motion_tells_of_less(asked, z):
    """As far as it does."""
    found = asked([(("d", ""), 1.0), (("e", ""), z)], size=0.3)
    told = [f"to see whether there is less than usual of e: {ROLL.says}"] if z > 3.0 else []
    assert (found.proposal is not None) == bool(told)
    assert found.words == (*told, "no motion of this speed and length shows d")


def test_an_effect_is_asked_about_in_the_size_that_may_be_there_unseen():
    """Which shows by about three deviations; no less than what has a name."""
    drag = ViscousDrag(0.0, 0.0)
    assert undetected_size(drag, 1.0) == 1.0
    assert undetected_size(drag, 10.0) * 10.0 == pytest.approx(math.sqrt(2.0 * CONFUSABLE_NATS))
    assert undetected_size(drag, 1e4) == MIN_NAMED_SIZE_RATIO


def test_rivals_are_told_by_the_worse_of_both_ways(asked):
    found = asked([(("a", "b"), 9.0), (("b", "a"), 5.0), (("a", "c"), 1.0), (("c", "a"), 8.0), (("d", ""), 4.0)])
    assert found.words == (
        f"to tell a and b apart, and to see whether there is d: {ROLL.says} (at least 4 standard deviations apart)",
        "no motion of this speed and length tells a from c: they differ by 1.0 deviations",
    )
    assert found.proposal.reference.stretches == ROLL.stretches
    assert found.why_none == ""


def test_where_no_motion_tells_that_is_said_and_none_is_proposed(asked):
    found = asked([(("a", "b"), 0.0), (("b", "a"), 9.0), (("d", ""), 2.0), (("e", ""), 1.0)])
    assert found.proposal is None
    assert found.why_none == "no motion of this speed and length tells a from b: they act alike"
    assert found.words[1] == "no motion of this speed and length shows d or e"


def test_long_lists_are_counted(asked):
    found = asked([((name, ""), 9.0) for name in "abcdefg"])
    assert "whether there is a, b, c, d or 3 more: " in found.words[0]


def test_where_nothing_is_open_nothing_is_proposed():
    assert next_experiment(diagnosis()).words == ()
    assert next_experiment(diagnosis()).why_none == NOTHING_OPEN
    assert NextExperiment(None, ("x",)).why_none == "x"
    assert next_experiment(diagnosis(arms=())).words == ("push the cart: nobody does in these logs",)
    assert next_experiment(diagnosis(is_moved=False)).words == ("push the cart: nothing moves in these logs",)


def test_what_else_would_help():
    assert next_experiment(diagnosis(["force_bias"])).words[0].startswith("push with one arm alone")
    assert "twice" in next_experiment(diagnosis(verdict="unexplained")).words[0]
    laws = (SimpleNamespace(name="travelled distance"),)
    assert "another travelled distance" in next_experiment(diagnosis(laws=laws)).words[0]
    assert next_experiment(diagnosis(may_follow=laws)).words == next_experiment(diagnosis(laws=laws)).words
