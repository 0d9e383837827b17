"""Logs that nobody here made, against what separate, simple means say of them (`benchmarks/measured/truths.py`),
whatever the first guess of the mass."""

from pathlib import Path

import numpy as np
import pytest

from benchmarks.measured.carts import guessed
from benchmarks.measured.logs import LOGS
from benchmarks.measured.truths import CAR, WHEELCHAIR
from cartgrasp.logs import read_log
from estimation.discrepancy import diagnose

DATA = Path(__file__).parents[4] / "shared" / "data"

pytestmark = pytest.mark.skipif(not DATA.is_dir(), reason="the measured logs are not part of the project")


def told_of(name, guess, variant="as it is"):
    one = next(log for log in LOGS if log.name == name)
    cart = guessed(one.cart, guess * one.cart.inertia.mass)
    change = next(v for v in one.variants() if v.name == variant).change
    return diagnose(change(read_log(DATA / one.path)), cart)


@pytest.mark.long
@pytest.mark.some(1)
@pytest.mark.parametrize("guess", [1 / 3, 1.0, 3.0])
def test_a_person_who_rolls_a_wheelchair(guess):
    found = told_of("wheelchair", guess)
    (effect,) = found.effects
    assert effect.name == "rolling_resistance"
    mass = found.certainty.parameters["mass"]
    assert WHEELCHAIR.mass.holds(mass.value)
    assert not mass.identifiable
    assert WHEELCHAIR.values["rolling force"].holds(effect.parameters["coefficient"][0] * mass.value * 9.81)
    assert found.gap.after < found.gap.refitted <= found.gap.before
    told = {of: one["refitted"] for of, one in (found.gap.per_horizon | found.gap.per_coordinate).items()}
    assert found.gap.refitted == told["1 s"] == pytest.approx(told["along"])


@pytest.mark.prove
def test_coarse_poses_of_a_wheelchair_tell_its_drag():
    assert [effect.name for effect in told_of("wheelchair", 1.0, "x in 5 mm").effects] == ["rolling_resistance"]


@pytest.mark.long
def test_a_person_who_leans_is_no_load_that_swings():
    assert "load_slosh" not in {effect.name for effect in told_of("wheelchair", 1.0, "last 60 %").effects}


@pytest.mark.prove
@pytest.mark.parametrize("variant", ["x in 5 mm", "first 60 %"])
def test_a_car_has_no_other_load_and_meets_no_push(variant):
    """In coarse steps, and in seven seconds, in which what drifts is like a push."""
    assert {effect.name for effect in told_of("car", 1.0, variant).effects} <= CAR.allowed


@pytest.mark.long
@pytest.mark.some(1)
@pytest.mark.parametrize("variant", ["at 100 Hz", "velocities fitted"])
def test_three_flights_tell_a_slope_that_closes_the_gap(variant):
    assert "floor_slope" in {effect.name for effect in told_of("sail", 1.0, variant).effects}


@pytest.mark.prove
@pytest.mark.parametrize("variant", ["x in mm", "x in 5 mm", "at 50 Hz", "first 60 %"])
def test_an_axis_with_two_frictions_is_no_patch_of_floor(variant):
    """The stroke is all the floor that there is."""
    found = told_of("emps", 1.0, variant)
    assert [effect.name for effect in found.effects] == ["rolling_resistance", "directional_drag"]
    mass = found.certainty.parameters["mass"]
    assert abs(mass.value - 95.1) < 2 * np.hypot(mass.std, 0.25)


@pytest.mark.prove
@pytest.mark.parametrize("guess", [1 / 3, 1.0, 3.0])
def test_a_car_whose_wheel_feels_the_force(guess):
    found = told_of("car", guess)
    assert {effect.name for effect in found.effects} <= CAR.allowed
    assert CAR.mass.holds(found.certainty.parameters["mass"].value)
    assert found.gap.refitted <= found.gap.before


def test_a_cart_that_stands():
    found = told_of("still", 1.0)
    assert found.verdict == "no_discrepancy"
    assert not found.effects
    assert not found.certainty.parameters["mass"].identifiable
