"""The page and its figures, of a diagnosis whose numbers are made here: all are told, escaped and labelled."""

import re
import xml.etree.ElementTree as ElementTree
from dataclasses import replace
from html.parser import HTMLParser
from types import SimpleNamespace

import numpy as np
import pytest

from cartgrasp.effects import DirectionalDrag, LearnedForce, QuadraticDrag, RollingResistance, TimeDelay, ViscousDrag
from cartgrasp.inertia import Inertia
from cartgrasp.model import CartModel
from cartgrasp.motion import ParameterEstimate
from estimation.discrepancy.clock_offset import clock_offsets
from estimation.discrepancy.diagnosis.diagnosis import Diagnosis
from estimation.discrepancy.diagnosis.figures import figures
from estimation.discrepancy.diagnosis.page import page
from estimation.discrepancy.findings.gap import Gap
from estimation.discrepancy.findings.isolability import isolability
from estimation.discrepancy.findings.named_effects import NamedEffect
from estimation.discrepancy.findings.verdicts import ADDED, NOT_FITTED, WITHDRAWN, verdict
from estimation.discrepancy.log_check import checked, with_clock_offsets
from estimation.discrepancy.search.laws import Law, smooth_laws
from estimation.discrepancy.search.model import Model
from estimation.discrepancy.search.scored_candidates import ScoredCandidate, SearchStep
from estimation.discrepancy.where.residual import residuals
from estimation.discrepancy.where.residual_map import residual_maps
from estimation.discrepancy.where.where import where
from estimation.impacts.impacts import Impact
from estimation.weak_form.balances import Balances

from ...runs import simulate

SCRIPT = "<script>alert(1)</script> & $x_1$"
CART = CartModel(Inertia(24.0, (0.28, 0.06), 2.2), effects=(ViscousDrag(linear=3.0, angular=1.2),), name=SCRIPT)
ADDED_EFFECT = RollingResistance(coefficient=0.02)


@pytest.fixture(scope="module")
def diagnosis():
    """Of a cart that rolls with a resistance of 2 %."""
    log, _ = simulate((24.0, 0.28, 0.06, 2.2, 3.0, 1.2, 0.02), 5, 18.0, noise=(0.0004, 0.004, 1.0))
    log = replace(log, name=SCRIPT)
    balances = Balances.of(log, CART)
    nominal = Model.started([balances], CART)
    final = nominal.refitted(nominal.cart.with_effect(ADDED_EFFECT)).rewhitened()
    before, after = residuals(nominal, final), residuals(final, final)
    best = ScoredCandidate(ADDED_EFFECT, 310.25, 1, final)
    attempts = (
        best,
        ScoredCandidate(QuadraticDrag(3.0), 20.5, 1),
        ScoredCandidate(smooth_laws([balances.motion], CART)[0], 2.0, 7),
    )
    numbers = {"before": 0.031, "refitted": 0.021, "after": 0.0021, "noise_floor": 0.002}
    size = {"coefficient": (0.0201, 0.0007, "-")}
    effect = NamedEffect("rolling_resistance", "", 0.95, size, ("directional_drag",), 0.97)
    return SimpleNamespace(
        nominal_cart=CART,
        cart=final.cart,
        nominal=nominal,
        final=final,
        withdrawn=(),
        is_moved=True,
        effects=(effect,),
        where=tuple(where(before)),
        residual_maps=residual_maps(before, after),
        before=before,
        after=after,
        checks=with_clock_offsets([checked(log, CART, balances)], clock_offsets(final)),
        unexplained={"size": {}, "depends_on": ["forward force: <b>"]},
        file_parameters={"mass": (24.0, ParameterEstimate(23.9, 0.12, "kg", True))},
        disagrees=True,
        is_refused=False,
        sentence=f"The model lacks rolling_resistance. {SCRIPT}",
        verdict="explained",
        gap=SimpleNamespace(**numbers, per_horizon={"1 s": numbers}, per_coordinate={"x": numbers, "heading": numbers}),
        next_experiment=SimpleNamespace(words=("push it",)),
        impacts=(Impact(3.25, np.array([1.5, 0.25, 0.0]), 0.75, -0.5),),
        warnings=(f"hand: fx is what is recorded as -fx {SCRIPT}",),
        isolability=isolability(nominal),
        steps=(SearchStep(attempts, best, 10.0), SearchStep(attempts[1:], None, 37.2)),
    )


@pytest.fixture(scope="module")
def drawn(diagnosis):
    return figures(diagnosis)


@pytest.fixture(scope="module")
def text(diagnosis, drawn):
    return page(SimpleNamespace(diagnosis=diagnosis), drawn)


class Tables(HTMLParser):
    """Rows of all tables, as lists of their cells' texts."""

    def __init__(self, text):
        super().__init__()
        self.tables, self.cell = [], False
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        if tag == "table":
            self.tables.append([])
        elif tag == "tr":
            self.tables[-1].append([])
        elif tag in ("td", "th"):
            self.tables[-1][-1].append("")
            self.cell = True

    def handle_endtag(self, tag):
        self.cell = self.cell and tag not in ("td", "th")

    def handle_data(self, data):
        if self.cell:
            self.tables[-1][-1][-1] += data


def table(text, first):
    return next(one for one in Tables(text).tables if one[0][0] == first)


@pytest.mark.long
def test_figures_are_drawn_of_all_and_hold_no_images(drawn, diagnosis):
    assert set(drawn) == {"residuals", "follows", "places", "rollouts", "gap"}
    for svg in drawn.values():
        tags = {element.tag.partition("}")[2] for element in ElementTree.fromstring(svg).iter()}
        assert "image" not in tags
        assert "path" in tags
    assert "refitted" in drawn["residuals"]
    assert "extended" in drawn["residuals"]
    assert "measured" in drawn["rollouts"]
    assert figures(diagnosis) == drawn  # no times, no chance


def test_names_are_texts(text):
    assert "<script" not in text
    assert "&lt;script&gt;alert(1)" in text
    assert "&lt;b&gt;" in text
    links = re.findall(r'https?:[^"]*', text)
    assert all(link.startswith("http://www.w3.org/") for link in links)  # names of what SVG is, not addresses


def test_every_interval_is_one_standard_deviation_and_says_so(text):
    head, row = table(text, "effect")
    assert row == ["rolling_resistance", "coefficient 0.0201 ± 0.0007", "95 %", "directional_drag", "97 %"]
    assert head[1] == "size (± one standard deviation)"
    head, row = table(text, "parameter")
    assert row == ["mass", "24", "23.9 ± 0.12 kg", "yes"]
    assert head[2] == "extended (± one standard deviation)"
    for rows in Tables(text).tables:
        for row in rows[1:]:
            for column, cell in enumerate(row):
                if "±" in cell:
                    assert "one standard deviation" in rows[0][column] or "one standard deviation" in row[0]
    assert "two standard" not in text


def test_a_step_tells_gain_and_verdict_of_each(text):
    rows = table(text, "candidate")
    assert rows[0] == ["candidate", "gain, nats (± one standard deviation)", "verdict"]
    assert rows[1] == ["rolling_resistance", "310.2", ADDED]
    assert rows[2] == ["quadratic_drag", "20.5", "gains 289.7 nats less than rolling_resistance"]
    assert rows[3][0].startswith("law: speed")
    assert rows[3][1:] == ["2.0", "gains 2.0 nats, and 10.0 are needed"]


def test_impacts_are_told(text, diagnosis):
    _, row = table(text, "t, s")
    assert row == ["3.25", "1.500", "0.250", "0.750", "-0.500"]
    unhurt = SimpleNamespace(**{**vars(diagnosis), "impacts": ()})
    assert "Where it was hit" not in page(SimpleNamespace(diagnosis=unhurt), {})


def test_the_log_is_told(text, diagnosis):
    rows = dict(Tables(text).tables[-1])
    assert set(rows) >= {"rows, with every wrench", "wrenches late by (± one standard deviation)"}
    late = diagnosis.checks[0].clock_offset
    assert rows["wrenches late by (± one standard deviation)"].startswith(f"{1e3 * late.value:.1f} ± ")


def test_what_to_do_next_stands_before_all_that_explains(text, diagnosis):
    headings = re.findall("<h2>(.*?)</h2>", text)
    assert headings[:3] == ["What to do next", "What was added", "Where they disagree"]
    told = text[text.index("What to do next") : text.index("What was added")]
    places = [
        told.index(words) for words in ("Look at this first", "cart.yaml beside", "<pre>", "Then drive", "push it")
    ]
    assert places == sorted(places)
    commands = re.search("<pre>(.*?)</pre>", told, re.DOTALL)[1].splitlines()
    assert [line.split()[:2] for line in commands] == [["cartgrasp", "discrepancy"], ["cartgrasp", "simulate"]]
    assert all("--cart cart.yaml" in line for line in commands)
    nothing = {"effects": (), "next_experiment": SimpleNamespace(words=()), "warnings": (), "is_refused": True}
    bare = page(SimpleNamespace(diagnosis=SimpleNamespace(**{**vars(diagnosis), **nothing})), {})
    assert "Look at this first" not in bare
    assert "cart as it was given" in bare
    assert "Nothing is left open." in bare


def test_words_are_explained_where_they_stand_first_and_an_effect_stands_once(text):
    body = re.sub(r"<svg.*?</svg>", "", text[text.index("<h2>Where they disagree") :], flags=re.DOTALL)
    for word in ("efitted", "xtended", "ominal"):
        explained = body[body.index(word) :][:60]
        assert "is the cart" in explained or "is that with" in explained, word
    added = table(text, "effect")
    assert [row[0] for row in added[1:]] == ["rolling_resistance"]


@pytest.mark.parametrize(
    ("of", "words"), [("time", "by this log's clock"), ("travelled_distance", "of the way counts from")]
)
def test_a_law_that_another_log_begins_elsewhere_is_said_to_be_of_this_one(diagnosis, of, words):
    law = Law.free("force", LearnedForce("forward_force", of, period=1.5))
    final = replace(diagnosis.final, laws=(law,)).refitted(diagnosis.final.cart)
    found = SimpleNamespace(**vars(diagnosis) | {"final": final})
    assert words in page(SimpleNamespace(diagnosis=found), {})
    assert words not in page(SimpleNamespace(diagnosis=diagnosis), {})


def test_no_name_is_certain(diagnosis):
    sure = replace(diagnosis.effects[0], probability=0.9986)
    found = SimpleNamespace(**vars(diagnosis) | {"effects": (sure,)})
    assert table(page(SimpleNamespace(diagnosis=found), {}), "effect")[1][2] == "> 99 %"


def test_what_is_left_may_follow_the_law_that_was_refused_at_last(diagnosis):
    """Though another form of what was added may make as much."""
    balances = diagnosis.final.logs[0]
    law = next(one for one in smooth_laws([balances.motion], CART) if one.name == "yaw rate")
    less = ScoredCandidate(law, 9.0, 1, diagnosis.final)
    gap = Gap(0.05, 0.05, 0.04, 0.01, {}, {})
    with_law = replace(diagnosis.final, laws=(law,)).refitted(diagnosis.final.cart)
    sure, unsteady = (ScoredCandidate(law, 86.4, 1, with_law, error, 4.8) for error in (13.0, 80.0))
    for refused, told in ((sure, (law,)), (less, ()), (unsteady, ())):
        steps = (diagnosis.steps[0], SearchStep((refused,), None, 20.0))
        checks, final = tuple(diagnosis.checks), diagnosis.final
        found = Diagnosis(CART, checks, (None,), diagnosis.nominal, final, steps, (0.9, 0.0), gap, False)
        assert found.verdict == "partly_explained"
        assert found.may_follow == told
        assert found.unexplained["depends_on"] == [one.words for one in told]
    assert replace(found, steps=diagnosis.steps[:1], shares=(0.9,)).may_follow == ()


def test_a_verdict_is_what_the_numbers_say(diagnosis):
    """Each loses by its own rule, and the sentence tells the numbers of that rule."""
    final = diagnosis.final
    added = ScoredCandidate(ADDED_EFFECT, 100.0, 1, final)
    more, less = (
        ScoredCandidate(DirectionalDrag(3.0, 1.0), 104.0, 1, final),
        ScoredCandidate(QuadraticDrag(3.0), 60.04, 1, final),
    )
    odd, near = ScoredCandidate(TimeDelay(0.002), 200.0, 1, final), ScoredCandidate(QuadraticDrag(3.0), 97.0, 1, final)
    step = SearchStep((odd, more, added, near, less), added, 10.0)
    assert [verdict(step, one) for one in step.attempts] == [
        "a delay of 0.002 s is none of this name: 0.008 at least",
        "gains 4.0 nats more than rolling_resistance by 1 number more: not surely more",
        ADDED,
        "gains 3.0 nats less than rolling_resistance, which is likelier beforehand by 4",
        "gains 40.0 nats less than rolling_resistance",
    ]
    assert verdict(step, added, final.refitted(final.guess)) == WITHDRAWN
    assert (
        verdict(SearchStep((less,), None, 70.0), less) == "gains 60.0 nats, and 70.0 are needed beside what gained most"
    )
    assert verdict(SearchStep((odd,), None, 10.0), odd).startswith("a delay of 0.002 s")
    assert verdict(SearchStep((less,), None, 10.0), replace(less, model=None)) == NOT_FITTED
    assert verdict(step, replace(more, model=None)) == NOT_FITTED
    unsteady = "gains less than 1.5 standard deviations of its gain: from stretch to stretch it is not sure"
    assert verdict(step, replace(less, error=50.0)) == unsteady
