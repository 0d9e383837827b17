"""Laws as effects: sizes with their deviations, words, and what is there everywhere."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cartgrasp.cart_file import cart_from_text, cart_text
from cartgrasp.effects import LearnedForce
from cartgrasp.inertia import Inertia
from cartgrasp.model import CartModel
from estimation.discrepancy import diagnose
from estimation.discrepancy.diagnosis.figures import figures
from estimation.discrepancy.diagnosis.law_figure import required_forces
from estimation.discrepancy.diagnosis.page import page
from estimation.discrepancy.findings.learned_laws import LearnedLaw
from estimation.discrepancy.search.laws import smooth_laws
from estimation.weak_form.balances import Balances

from ...runs import simulate
from ..search.test_laws import CART, TRUTH, resisted, with_the_wheels_turn, without_a_law

BARE = CartModel(Inertia(24.0, (0.28, 0.06), 2.2))


def told(effect, seen, std=0.0, period_std=0.0):
    return LearnedLaw(effect, std**2 * np.eye(len(effect.parameters)), period_std, np.asarray(seen, dtype=float))


@given(numbers=st.lists(st.floats(-5, 5), min_size=2, max_size=2), phase=st.floats(0, 6))
def test_a_curve_and_its_band_are_those_of_the_amplitudes(numbers, phase):
    law = told(LearnedForce("forward_force", "time", period=2 * np.pi, amplitudes=tuple(numbers)), [0.0, 1.0], std=0.3)
    value, std = law.curve(np.array([phase]))
    assert value == pytest.approx([numbers[0] * np.cos(phase) + numbers[1] * np.sin(phase)], abs=1e-9)
    assert std == pytest.approx([0.3])


@pytest.mark.parametrize("phase", [0.1, 0.25, 0.6])
def test_a_band_knows_how_well_a_period_is_known(phase):
    """Sines of many periods that agree in the middle of a log, at one phase in each turn of it."""
    period, period_std, size, random = 0.8, 2e-3, 5.0, np.random.default_rng(0)
    turns = np.arange(60)
    law = told(
        LearnedForce("forward_force", "time", period=period, amplitudes=(0.0, size)),
        np.linspace(0, 60 * period, 6000),
        period_std=period_std,
    )
    at, middle = (turns + phase) * period, 30 * period
    drawn = period + period_std * random.standard_normal((400, 1))
    off = size * (np.sin(2 * np.pi * (at - middle) / drawn) - np.sin(2 * np.pi * (at - middle) / period))
    _, std = law.curve(np.array([phase * period]))
    curved = 0.0 if phase != 0.25 else np.sqrt((off**2).mean())  # at the top, it is of second order
    assert std == pytest.approx([np.sqrt((off**2).mean())], rel=0.15, abs=1.01 * curved)


def test_words_can_be_read_aloud():
    hum = told(LearnedForce("forward_force", "time", period=1.004, amplitudes=(3.0, 0.0)), np.linspace(0, 9, 500))
    assert hum.words == "a forward force that repeats every 1 s, between -3 and 3 N"
    assert "a second drive" in hum.likely
    assert "steps of a person (60 a minute)" in hum.likely
    spot = LearnedForce("forward_force", "travelled_distance", lever=0.27, period=0.525, amplitudes=(4.0, 0.0))
    assert told(spot, np.linspace(0, 3, 300)).likely.startswith(
        "a flat spot, a bent rim or dirt on the wheel 0.27 m to the left"
    )
    assert "radius 84 mm: 0.525 m a turn" in told(spot, np.linspace(0, 3, 300)).likely
    grain = told(LearnedForce("drag", "heading", harmonics=(2,), amplitudes=(1.0, 0.0)), np.linspace(0, 3, 300))
    assert grain.words == "a drag that changes with the heading, between -1 and 1 N"
    dry = told(LearnedForce("drag", "speed", amplitudes=(4.0,)), [0.1, 0.4])
    assert dry.words == "a drag that is the same at every speed, between 4 and 4 N"
    wind = LearnedForce("world_force", "time", knots=(0.0, 30.0), amplitudes=(-4e-17, 8.4))
    assert told(wind, np.linspace(-10, 40, 300)).words.endswith(", between 0 and 8.4 N")


@pytest.mark.long
def test_a_law_stands_in_the_cart_that_is_handed_over_and_comes_back_from_its_file():
    """A flat spot: the extended cart says of its own log that nothing is missing."""
    (log, found), sound = with_the_wheels_turn(), without_a_law()
    (effect,) = found.effects
    assert effect.name == "learned_force"
    assert found.gap.after <= 1.05 * sound.gap.after  # as far as a model that is right
    assert found.gap.noise_floor == pytest.approx(sound.gap.noise_floor, rel=0.15)
    assert effect.gap_share > 0.5
    at, force, told_by_law = required_forces(found, effect.law)
    made = -4.0 * np.sin(2 * np.pi * at / 0.4)  # it resists
    assert np.corrcoef(force, made)[0, 1] > 0.8
    assert np.polyfit(told_by_law, force, 1)[0] == pytest.approx(1.0, abs=0.1)
    drawn = figures(found)
    assert "<image" not in drawn["laws"]
    assert effect.law.words in page(SimpleNamespace(diagnosis=found), drawn)
    again = cart_from_text(cart_text(found.cart))
    assert again.effects[-1] == found.cart.effects[-1]
    assert not diagnose(log, again).effects


@pytest.mark.prove
def test_of_a_drag_that_never_fades_the_rest_has_a_name():
    """A drag that falls from 7 to 3 N: 3 N are the wheels' resistance, which needs no law."""

    def force(time, truth):
        return np.sign(truth[:, 3]) * (3.0 + 4.0 * np.exp(-time / 8.0))

    found = diagnose(resisted(force, 3, 60.0), BARE.with_effect(CART.effects[0]))
    assert {effect.name for effect in found.effects} == {"rolling_resistance", "learned_force"}
    (coefficient,) = (e.parameters["coefficient"][0] for e in found.effects if e.name == "rolling_resistance")
    assert coefficient * 24.0 * 9.81 == pytest.approx(3.0, abs=0.6)


def test_every_law_is_what_its_columns_say():
    """A unit of each number, in rows and in the wrench that the effects give along the motion."""
    log, _ = simulate(TRUTH, 3, 12.0, noise=(0.0004, 0.004, 1.0))
    balances = Balances.of(log, CART)
    rng = np.random.default_rng(0)
    for law in smooth_laws([balances.motion], CART, lever=0.2):
        numbers = rng.standard_normal(law.size)
        cart = replace(BARE, constraints=CART.constraints)
        for k, effect in enumerate(law.sized(numbers)):
            cart = cart.with_effect(replace(effect, label=str(k)))
        given_wrench = cart.effect_wrench(balances.state(cart), time=balances.motion.time) @ cart.basis_b
        rows = -balances.integrated(given_wrench)
        free = cart.constraints.n_free
        taken = (law.columns(balances, CART) @ numbers)[:, :free]
        assert taken == pytest.approx(rows, abs=0.03 * np.abs(rows).max()), law.key
