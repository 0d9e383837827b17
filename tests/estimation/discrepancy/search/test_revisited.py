"""What was added, beside what was added since: a law in another form; and what differs surely, by how it acts."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cartgrasp.effects import RollingResistance
from cartgrasp.effects.effect import Gate
from estimation.discrepancy.findings.verdicts import verdict
from estimation.discrepancy.search.attempts import Attempt, Step
from estimation.discrepancy.search.gains import CONFUSABLE, SURE, WORTH, margin
from estimation.discrepancy.search.laws import smooth_laws
from estimation.discrepancy.search.model import Model
from estimation.discrepancy.search.revisited import searched_again
from estimation.weak_form.balances import Balances

from .test_laws import CART, resisted

FADES = {
    "drag that warms": lambda speed: 5.0 * np.sign(speed),
    "viscous drag that warms": lambda speed: 8.0 * speed,
}
"""By form. That of the first has a part like rolling resistance, which no log tells from that."""
RESISTANCE = RollingResistance(0.02)


@pytest.fixture(scope="module", params=FADES)
def fading(request):
    """The form of a drag that fades beside rolling resistance, and a model with that and a drag of the other form."""

    def force(time, truth):
        speed = truth[:, 3]
        dry = RESISTANCE.coefficient * 9.81 * CART.inertia.mass * np.sign(speed)
        return dry + (1.0 - time / time[-1]) ** 2 * FADES[request.param](speed)

    logs = [Balances.of(resisted(force, 5, 30.0), CART)]
    (other,) = set(FADES) - {request.param}
    (law,) = (one for one in smooth_laws([logs[0].motion], CART) if one.form == other)
    model = Model.started(logs, CART)
    model = replace(model, laws=(law,), compares=True).refitted(model.cart.with_effect(RESISTANCE)).rewhitened()
    return request.param, model


@pytest.mark.long
def test_a_law_takes_the_form_that_does_beside_all_else(fading):
    """Found before rolling resistance, a drag had that to explain, too. In its own form both are told rightly."""
    form, model = fading
    again = searched_again(model)
    assert [law.form for law in again.laws] == [form]
    if form.startswith("viscous"):
        (resistance,) = (e for e in again.cart.effects if e.name == RESISTANCE.name)
        assert resistance.coefficient == pytest.approx(RESISTANCE.coefficient, rel=0.1)
    assert [law.form for law in searched_again(again).laws] == [form]


@pytest.mark.long
def test_no_form_is_taken_that_leaves_effects_without_their_names(fading, monkeypatch):
    _, model = fading
    monkeypatch.setattr("estimation.discrepancy.search.revisited.is_plausible", lambda *_: False)
    assert [law.form for law in searched_again(model).laws] == [law.form for law in model.laws]


@pytest.mark.long
def test_a_step_says_in_which_form_its_law_is_kept(fading):
    _, model = fading
    added, again = Attempt(model.laws[0], 99.0, 1, model), searched_again(model)
    step = Step((added,), added)
    assert verdict(step, added, model) == "added"
    assert verdict(step, added, again) == f"added; in the end as {again.laws[0].key}"
    assert "withdrawn" in verdict(step, added, replace(again, laws=()))


gains = st.lists(st.floats(-50.0, 50.0), min_size=3, max_size=12)


@given(gains)
def test_what_happens_once_is_told_by_no_other_stretch(gains):
    """All else is, and what acts at a time or place has to be worth a name besides."""
    less, more = (SimpleNamespace(score=SimpleNamespace(stretches=np.array(g))) for g in ([0.0] * len(gains), gains))
    by_chance = SURE * len(gains) ** 0.5 * np.std(gains)
    assert margin(less, more, Gate.ALWAYS) == pytest.approx(max(CONFUSABLE, by_chance))
    assert margin(less, more, Gate.WHILE, Gate.ALWAYS) == WORTH
    for gate in (Gate.INSIDE, Gate.FROM):
        assert margin(less, more, Gate.ALWAYS, gate) == pytest.approx(max(WORTH, by_chance))
