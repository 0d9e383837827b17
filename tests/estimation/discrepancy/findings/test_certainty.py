"""Standard deviations against what repeated draws of the sensors' noise scatter."""

from dataclasses import replace

import numpy as np
import pytest

from cartgrasp.effects import RollingResistance, ViscousDrag
from cartgrasp.first_guess import FirstGuess
from cartgrasp.inertia import Inertia
from cartgrasp.logs import RunLog
from cartgrasp.model import CartModel
from cartgrasp.wheels import Wheel
from estimation import diagnose
from estimation.discrepancy.findings.certainty import SIZE_FORM_FRACTION, Certainty
from estimation.discrepancy.search.model import Model
from estimation.weak_form.balances import Balances
from estimation.weak_form.band import BAND_MASS_RATIO, Band

from ...runs import simulate, simulate_two_hands
from ...weak_form.motions import RAIL, RAIL_MASS, TRUE, cart_of, noisy, on_rail, weaving

DRAWS = 12
NAMES = ("mass", "com_x", "com_y", "inertia", "viscous_drag.linear", "viscous_drag.angular")


@pytest.fixture(scope="module")
def drawn():
    """Values and standard deviations (draws, names)."""
    clean, guess, found = weaving(TRUE), cart_of((20.0, 0.2, 0.0, 2.0, 3.5, 1.0)), []
    for seed in range(DRAWS):
        told = Certainty(Model.started([Balances.of(noisy(clean, seed), guess)], guess)).parameters
        found.append([(told[name].value, told[name].std) for name in NAMES])
    return np.moveaxis(np.array(found), 2, 0)


@pytest.mark.long
def test_deviations_are_those_of_errors(drawn):
    """Root mean square of errors over deviations told: of 12 draws it scatters by 20 %. They may be told too large by
    what a model could leave out (1 % of the wrench), and must not be told too small."""
    values, stds = drawn
    standard = (values - np.array(TRUE)) / stds
    size = np.sqrt((standard**2).mean(axis=0))
    assert (size < 1.5).all()
    assert (size > 0.15).all()


@pytest.mark.parametrize("wheels", [(), (Wheel("fixed", 0.0, 0.0),), (Wheel("caster", 0.6, 0.2),)])
def test_forms_leave_open_a_share_of_what_was_added(wheels):
    """And nothing of what the file has."""
    guess = replace(cart_of(TRUE), wheels=wheels)
    log = simulate_two_hands((*TRUE, 0.02))
    model = Model.started([Balances.of(log, guess)], guess)
    model = model.refitted(guess.with_effect(RollingResistance(0.02)))
    certainty, rolling = Certainty(model), model.cart.effects[-1]
    rows = np.sqrt(np.diagonal(certainty.covariance))
    for key, left in (
        ("rolling_resistance.coefficient", SIZE_FORM_FRACTION * rolling.coefficient),
        ("viscous_drag.linear", 0.0),
    ):
        own, told = list(certainty.parameters).index(key), certainty.parameters[key]
        assert told.std == pytest.approx(np.hypot(rows[own], left), rel=1e-9)


def test_what_the_bracket_leaves_open_is_told():
    """Beside a band that says nothing of its own, the mass moves to the bracket's middle, and half of it is as much as
    a standard deviation."""
    model = Model.started([Balances.of(on_rail(20.0), RAIL)], RAIL)
    closed = Certainty(model)
    opened = Certainty(model, (Band(0.1, RAIL_MASS, 1e3 * RAIL_MASS, 0.05 * RAIL_MASS),))
    ratio = opened.cart.inertia.mass / closed.cart.inertia.mass
    assert ratio == pytest.approx(1.05, rel=1e-6)
    told = opened.parameters["mass"]
    share = np.hypot(closed.parameters["mass"].std / closed.cart.inertia.mass, 0.05)
    assert told.std / told.value == pytest.approx(share, rel=1e-4)
    assert closed.cart.inertia.mass == pytest.approx(RAIL_MASS, rel=0.01)


def test_a_model_and_its_band_that_disagree_are_as_unsure_as_that():
    """Each weighs by its own variance, the band's with what bands may differ by that agree; half of the way between
    them (a tenth, of logarithms) is a deviation at least."""
    model = Model.started([Balances.of(on_rail(20.0), RAIL)], RAIL)
    alone = Certainty(model)
    own = alone.parameters["mass"]
    share = own.std / own.value
    other = own.value * np.exp(0.2)
    told = Certainty(model, (Band(0.1, other, share * other, 0.0),)).parameters["mass"]
    weight = share**2 / (share**2 + share**2 + BAND_MASS_RATIO**2)
    assert told.value == pytest.approx(own.value * np.exp(0.2 * weight), rel=1e-3)
    assert told.std / told.value == pytest.approx(max(share, 0.1), rel=2e-3)


def test_a_drag_at_its_bound_is_not_taught():
    guess = cart_of(TRUE)
    model = Model.started([Balances.of(noisy(weaving((*TRUE[:4], -2.0, 1.2), 16.0), 5), guess)], guess)
    told = Certainty(model).parameters
    assert not told["viscous_drag.linear"].identifiable
    assert told["viscous_drag.angular"].identifiable
    assert told["mass"].identifiable


@pytest.mark.some(1)
@pytest.mark.parametrize(("pose", "velocity", "seed"), [(5e-4, 5e-3, 0), (5e-4, 5e-3, 1), (2e-3, None, 0)])
def test_a_straight_push_is_not_sure_of_what_it_does_not_show(pose, velocity, seed):
    """Of a cart that hardly turns no row tells CoM and inertia; the noise of its yaw acceleration, as small a body as
    any, had told a CoM 0.29 m off, sure to 0.03 m."""
    true = {"mass": 24.0, "com_x": 0.28, "com_y": 0.03, "inertia": 2.2}
    log, _ = simulate((*true.values(), 3.0, 1.2, 0.0), seed, curved=False, noise=(pose, velocity or 0.0, 1.0))
    log = log if velocity else replace(log, velocity=None)
    guess = CartModel(Inertia(18.0, (0.2, 0.0), 1.6), effects=(ViscousDrag(3.0, 1.2),))
    told = {name: one for name, (_, one) in diagnose(log, guess).file_parameters.items()}
    assert told["mass"].identifiable
    assert not told["com_x"].identifiable
    for name, value in true.items():
        assert abs(told[name].value - value) < 3 * told[name].std


def test_what_the_file_knows_has_no_deviation():
    """A known mass had been told as ± 36 kg: by what nobody knows of one."""
    known = FirstGuess(known=("mass", "viscous_drag"))
    guess = replace(cart_of((24.0, 0.2, 0.0, 2.0, 3.0, 1.2)), first_guess=known)
    told = Certainty(Model.started([Balances.of(noisy(weaving(TRUE), 0), guess)], guess)).parameters
    for name in ("mass", "viscous_drag.linear", "viscous_drag.angular"):
        assert told[name].std == 0.0
        assert not told[name].identifiable
    assert told["mass"].value == pytest.approx(24.0)
    assert told["com_x"].identifiable
    assert told["com_x"].std > 0.0


def test_a_cart_that_coasts_straight_on_tells_its_drag_alone():
    """Speed falls by e in 8 s, so 2.5 N·s/m of 20 kg. No row tells of a body, and taking noise off finds none."""
    time, random = 0.01 * np.arange(1200), np.random.default_rng(0)
    pose = np.pad(9.6 * (1.0 - np.exp(-time / 8.0))[:, None], ((0, 0), (0, 2)))
    log = RunLog(time, pose + 5e-4 * random.standard_normal(pose.shape), None, {})
    guess = CartModel(Inertia(20.0, (0.2, 0.0), 1.6), effects=(ViscousDrag(3.0, 1.2),))
    told = {name: one for name, (_, one) in diagnose(log, guess).file_parameters.items()}
    assert told["viscous_drag.linear"].identifiable
    assert told["viscous_drag.linear"].value == pytest.approx(2.5, abs=0.01)
    for name, value, least in (("com_x", 0.2, 0.4), ("com_y", 0.0, 0.4), ("inertia", 1.6, 1.6)):
        assert told[name].value == pytest.approx(value, abs=0.05)
        assert told[name].std > least
        assert not told[name].identifiable
