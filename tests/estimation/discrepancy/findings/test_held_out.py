"""What is held against stretches that no fit saw is the cart that is told, its mass in the middle of its bracket."""

from dataclasses import replace

import numpy as np
import pytest

from cartgrasp.effects import ViscousDrag
from cartgrasp.inertia import Inertia
from cartgrasp.model import CartModel
from estimation import diagnose
from estimation.discrepancy.findings import held_out
from estimation.discrepancy.findings.held_out import _row_folds, fold_carts, held_out_rollouts, left_open_rollouts
from estimation.discrepancy.search.model import Model
from estimation.weak_form.balances import Balances
from estimation.weak_form.band import Band, band_in, bands, consistent

from ...runs import simulate_two_hands
from ...weak_form.motions import RAIL, RAIL_MASS, on_rail

LEANS = 0.012
"""m/s: of a rider, whom no force at the handle moves."""


@pytest.mark.parametrize("seed", range(2))
def test_the_mass_of_each_fold_is_in_the_middle_of_its_bracket(seed):
    whole = Balances.of(on_rail(share=LEANS, seed=seed), RAIL)
    step = consistent(bands(whole, RAIL)).row_step
    model = Model.started([whole.every(step)], RAIL)
    told = replace(model, band_steps=(step,))
    raw, masses = ([cart.inertia.mass for cart in fold_carts(each)] for each in (model, told))
    off, less = (np.abs(np.array(each) - RAIL_MASS) for each in (raw, masses))
    assert (less <= np.maximum(0.85 * off, 0.005 * RAIL_MASS)).all()
    assert held_out_rollouts(told).gaps()[1] < 1.001 * held_out_rollouts(model).gaps()[1]


def test_a_mass_that_a_bracket_leaves_open_leaves_rollouts_open(monkeypatch):
    """Half of it is 3 kg of 20, where rows alone tell the mass of a fold to 0.6 kg."""
    model = Model.started([Balances.of(on_rail(share=LEANS), RAIL)], RAIL)
    monkeypatch.setattr(held_out, "band_in", lambda *_: Band(0.1, RAIL_MASS, 0.1, 3.0))
    raw, told = (left_open_rollouts(each).gaps()[1] for each in (model, replace(model, band_steps=(0.1,))))
    assert told > 2 * raw > 0.0


def test_a_band_from_some_rows_knows_nothing_of_the_others():
    """Wrenches that are seven times as large within a stretch."""
    log = on_rail(share=LEANS)
    balances = Balances.of(log, RAIL)
    ((_, folds),) = _row_folds(Model.started([balances], RAIL))
    edges = balances.time[np.flatnonzero(np.diff(folds)) + 1]
    of_sample = folds[np.searchsorted(balances.time, log.time).clip(max=len(folds) - 1)]
    inside = (of_sample == 1) & (np.abs(log.time[:, None] - edges).min(axis=1) > 0.5)
    other = {n: replace(a, wrench=np.where(inside[:, None], 7.0, 1.0) * a.wrench) for n, a in log.arms.items()}
    both = (balances, Balances.of(replace(log, arms=other), RAIL))
    first, second = (band_in(each, RAIL, RAIL, folds != 1) for each in both)
    assert second.mass == pytest.approx(first.mass, rel=1e-9)
    first, second = (band_in(each, RAIL, RAIL) for each in both)
    assert second is None or second.mass > 1.2 * first.mass


TRUE = (24.0, 0.28, 0.03, 2.2, 3.0, 1.2)
GUESS = CartModel(Inertia(18.0, (0.2, 0.0), 1.6), effects=(ViscousDrag(3.0, 1.2),))


def diagnosed(coulomb, seed, duration):
    """Of a cart with so much dry friction, of which the model has none."""
    return diagnose(simulate_two_hands((*TRUE, coulomb), seed, duration, (5e-4, 5e-3, 1.0)), GUESS)


@pytest.mark.some(2)
@pytest.mark.parametrize(("duration", "seed"), [(4.2, 4), (5.0, 0), (5.0, 2), (8.0, 1)])
def test_a_short_log_of_a_right_model_does_not_disagree(duration, seed):
    """What the other stretches leave open of the cart takes rollouts farther than noise does: not to be told as what a
    model lacks."""
    found = diagnosed(0.0, seed, duration)
    assert found.gap.is_beyond_noise
    assert found.gap.left_open > found.gap.noise_floor
    assert found.verdict == "no_discrepancy"
    assert "disagree" not in found.sentence
    assert "leaves open" in found.sentence


def test_a_short_log_of_a_wrong_model_disagrees():
    assert diagnosed(0.03, 1, 8.0).verdict != "no_discrepancy"


def test_what_is_left_open_is_asked_for_where_noise_does_not_explain_the_gap():
    found = diagnosed(0.0, 0, 20.0)
    assert not found.gap.is_beyond_noise
    assert found.gap.as_dict()["left_open"] is None
