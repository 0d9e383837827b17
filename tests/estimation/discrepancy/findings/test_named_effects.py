"""How names are told."""

import pytest

from cartgrasp.effects import RollingResistance, TimeDelay
from estimation.discrepancy.findings.named_effects import NamedEffect, doubtful_names, name_probability, words_of
from estimation.discrepancy.search.model import Model
from estimation.discrepancy.search.scored_candidates import ScoredCandidate, SearchStep
from estimation.weak_form.balances import Balances

from ...weak_form.motions import TRUE, cart_of, noisy, weaving


def test_the_same_effect_of_another_arm_is_told_as_such():
    one = NamedEffect("force_bias", "left", 0.7, {"fx": (1.9, 0.1, "N")}, ("force_bias", "floor_slope"), 0.8)
    assert one.alike == ["that of another arm than left", "floor_slope"]
    assert words_of([one]) == (
        "force_bias left (fx 1.9 N, or that of another arm than left or floor_slope: these logs can't tell)"
    )


@pytest.mark.parametrize(
    ("gain", "share", "is_doubted"), [(27.0, 0.0, True), (27.0, 0.02, False), (200.0, 0.0, False), (15.0, 0.1, False)]
)
def test_what_gains_little_beside_another_and_closes_nothing_is_doubted(gain, share, is_doubted):
    cart = cart_of(TRUE).with_effect(RollingResistance(0.02)).with_effect(TimeDelay(0.02))
    model = Model.started([Balances.of(noisy(weaving(TRUE, 24.0), 2), cart_of(TRUE))], cart_of(TRUE)).refitted(cart)
    _, rolling, delay = cart.effects
    steps = [SearchStep((one,), one) for one in (ScoredCandidate(rolling, 430.0, 1), ScoredCandidate(delay, gain, 1))]
    assert doubtful_names([*steps, SearchStep((), None)], model, (0.9, share, 0.0)) == (
        ["time_delay"] if is_doubted else []
    )
    assert doubtful_names(steps, model.refitted(cart_of(TRUE)), (0.9, share)) == []


def test_a_name_is_the_surer_the_more_it_gains_and_closes():
    assert name_probability(30.0, 30.0, True) > name_probability(20.0, 20.0, True) > name_probability(20.0, 200.0, True)
    assert name_probability(30.0, 300.0, True) > 0.5 > name_probability(30.0, 300.0, False)
    assert name_probability(300.0, 300.0, False) > 0.9
