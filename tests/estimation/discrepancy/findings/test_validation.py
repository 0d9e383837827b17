"""What a search found is upheld only where nothing else is as likely to look like it."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from cartgrasp.effects import FloorSlope, LearnedForce, LoadSlosh, RollingResistance
from estimation.discrepancy.findings import validation as module
from estimation.discrepancy.findings.held_out import held_out_rollouts
from estimation.discrepancy.findings.refusal import is_beyond
from estimation.discrepancy.findings.rollouts import Rollouts
from estimation.discrepancy.findings.validation import closes_most, rollout_error, validated, within_bracket
from estimation.discrepancy.search.laws import Law
from estimation.discrepancy.search.model import Model
from estimation.weak_form.balances import Balances
from estimation.weak_form.band import Band

from ...weak_form.motions import RAIL, RAIL_MASS, on_rail
from ..search.test_laws import CART, resisted, rolled

LOAD = 0.25 * RAIL_MASS
WEIGHT, FORWARD = 9.81 * RAIL_MASS, np.eye(6)[0]


@pytest.mark.parametrize(("bracket", "named"), [(0.02, True), (0.12, True), (0.13, False), (0.4, False)])
def test_a_load_has_to_be_more_than_the_mass_is_open_by(bracket, named):
    """Twice half of the bracket, as for whatever is essential to a name; a drag is of no account there."""
    model = Model.started([Balances.of(on_rail(), RAIL)], RAIL)
    cart = model.cart.with_effect(RollingResistance(coefficient=0.01))
    cart = cart.with_inertia(replace(cart.inertia, mass=RAIL_MASS))
    model = replace(model, cart=cart.with_effect(LoadSlosh(mass=LOAD, frequency=1.0, damping=0.1)))
    band = Band(0.1, RAIL_MASS, 0.1, bracket * RAIL_MASS)
    assert within_bracket(model, (None, band)) == ([] if named else ["load_slosh"])


@pytest.mark.parametrize("grade", [0.0, 0.02])
def test_a_slope_closes_a_gap_where_there_is_one(grade):
    log = on_rail(20.0)
    arms = {name: replace(arm, wrench=arm.wrench + grade * WEIGHT * FORWARD) for name, arm in log.arms.items()}
    model = Model.started([Balances.of(replace(log, arms=arms), RAIL)], RAIL)
    more = model.refitted(model.cart.with_effect(FloorSlope())).settled()
    assert closes_most(model, more) == (grade != 0.0)
    assert not closes_most(more, more)


def flat_spot(force):
    """A log in which one wheel's flat spot takes so much (N) at most."""

    def taken(time, truth):
        turn = (rolled(time, truth[:, 3] - 0.2 * truth[:, 4]) / 0.45) % 1.0
        return np.where(turn < 0.4, force * np.sin(2 * np.pi * turn / 0.4), 0.0)

    return resisted(taken, 3, 90.0, moment=lambda time, truth: -0.2 * taken(time, truth))


@cache
def without_a_law(force):
    """A model of that log."""
    return Model.started([Balances.of(flat_spot(force), CART)], CART)


@pytest.mark.long
@pytest.mark.parametrize("force", [0.0, 12.0])
def test_a_law_stays_unless_stretches_are_foretold_better_without_it(monkeypatch, force):
    """Whatever rollouts add up of what is fast."""
    nominal = without_a_law(force)
    wheel = LearnedForce(of="travelled_distance", lever=0.2, period=0.45, harmonics=(1, 2, 3, 4))
    found = replace(nominal, laws=(Law.free("of the wheel", wheel),)).refitted(nominal.cart).settled()
    noise = Rollouts(1.01 * held_out_rollouts(nominal).error)
    monkeypatch.setattr(module, "floor_rollouts", lambda model: noise)
    assert validated(found, nominal, (None,)) == (found, ())
    far = Rollouts(1.01 * held_out_rollouts(nominal).error)
    monkeypatch.setattr(module, "held_out_rollouts", lambda model: far if model.laws else held_out_rollouts(model))
    final, withdrawn = validated(found, nominal, (None,))
    assert (final.laws, withdrawn) == ((), found.laws)


def test_what_is_farther_off_than_noise_has_to_be_so_surely():
    """A mean of squares over some dozen stretches is known to a tenth or two."""
    model = without_a_law(0.0)
    error = rollout_error(held_out_rollouts(model))
    assert is_beyond(model, error / 2)
    assert not is_beyond(model, 0.95 * error)
    assert not is_beyond(model, 2 * error)
