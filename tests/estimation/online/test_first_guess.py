"""How sure a cart's file says that it is: read, written back, and believed by filter, fit and search."""

import numpy as np
import pytest

from cartgrasp.cart_file import cart_from_text, cart_text
from cartgrasp.errors import FileError
from estimation import CartFilter, Prior
from estimation.discrepancy.search.model import structure_prior
from estimation.whole_log.identification import identify

from ..runs import simulate

TEXT = """\
mass: 20.0
com: [0.3, 0.0]
inertia: 1.8
constraints:
  - no_lateral_slip: {x: 0.0}
effects:
  viscous_drag: {linear: 2.0, angular: 1.0}
  rolling_resistance: {coefficient: 0.015}
std: {mass: 2.0, com_y: 0.01}   # weighed
known: [inertia, viscous_drag.angular]
"""
TRUTH = (24.0, 0.28, 0.06, 2.2, 3.0, 1.0, 0.02)


def test_it_is_read_and_written_back_as_it_was():
    cart = cart_from_text(TEXT)
    assert dict(cart.first_guess.std) == {"mass": 2.0, "com_y": 0.01}
    assert cart.first_guess.known == ("inertia", "viscous_drag.angular")
    heavier = cart.with_parameters(cart.parameters * np.r_[1.1, 1.1, 1.1, 1.1, np.ones(3)])
    text = cart_text(heavier)
    assert "std: {mass: 2.0, com_y: 0.01}   # weighed" in text
    assert "known: [inertia, viscous_drag.angular]" in text
    assert cart_from_text(text).first_guess == cart.first_guess


@pytest.mark.parametrize(
    ("line", "other", "told"),
    [
        ("std: {mass: 2.0", "std: {mas: 2.0", "std.mas: is no parameter of this cart; did you mean mass?"),
        ("std: {mass: 2.0", "std: {mass: 0", "std.mass: 0 is not positive"),
        ("std: {mass: 2.0", "std: {mass: heavy", "std.mass: 'heavy' is not a number"),
        ("std: {mass: 2.0", "std: {inertia: 2.0", "known.0: inertia stands under `std` too"),
        ("[inertia,", "[masse,", "known.0: 'masse' is no parameter of this cart; did you mean mass?"),
    ],
)
def test_mistakes_are_told_with_their_place(line, other, told):
    with pytest.raises(FileError) as refused:
        cart_from_text(TEXT.replace(line, other), "cart.yaml")
    assert told in str(refused.value)
    assert str(refused.value).startswith("cart.yaml:")


def test_what_is_said_is_believed():
    """2 kg of 20 are a tenth of the logarithm; what nothing is said of is as unsure as ever."""
    cart = cart_from_text(TEXT)
    deviations = Prior().deviations(cart)
    assert deviations[[0, 1, 2]] == pytest.approx([2.0, 0.2, 0.01])
    prior = structure_prior(cart, cart)
    assert prior.std[[0, 2]] == pytest.approx([0.1, 0.01])
    assert prior.free.tolist() == [True, True, True, False, True, False, True]


@pytest.mark.long
@pytest.mark.parametrize("sure", [0.02, 20.0])
def test_a_fit_lies_between_log_and_first_guess(sure):
    """By how sure each is: one who weighed the cart to 20 g is hardly moved by a log that tells 100 g."""
    log, _ = simulate(TRUTH, 1, 10.0, noise=(0.0004, 0.005, 1.0))
    cart = cart_from_text(TEXT.replace("mass: 2.0,", f"mass: {sure},").replace("known: [inertia, ", "known: ["))
    mass = identify([log], cart).parameters["mass"]
    truth = 20.0 if sure < 1 else 24.0
    assert mass.value == pytest.approx(truth, abs=0.5)
    assert mass.std < sure


@pytest.mark.long
@pytest.mark.parametrize("known", ["mass", "com_y", "inertia"])
def test_what_is_known_is_not_moved(known):
    log, _ = simulate(TRUTH, 2, 6.0, noise=(0.0004, 0.005, 1.0))
    truth = {"mass": 24.0, "com_y": 0.06, "inertia": 2.2}[known]
    text = TEXT.replace("mass: 20.0", "mass: 24.0").replace("com: [0.3, 0.0]", "com: [0.3, 0.06]")
    text = text.replace("inertia: 1.8", "inertia: 2.2").replace("std: {mass: 2.0, com_y: 0.01}", "")
    cart = cart_from_text(text.replace("known: [inertia, viscous_drag.angular]", f"known: [{known}]"))
    found = identify([log], cart).parameters[known]
    assert (found.value, found.std, found.identifiable) == (pytest.approx(truth, rel=1e-9), 0.0, False)
    online = CartFilter(cart, ["hand"])
    for measurement in log.measurements():
        last = online.update(measurement).parameters
    assert last[known].value == pytest.approx(truth, rel=0.01)  # beside an unknown mass, it drifts by a thousandth
    assert not last[known].identifiable
    assert last["viscous_drag.linear"].identifiable
