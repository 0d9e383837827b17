"""Forces that no effect of the vocabulary makes: what they follow, with which period, and how large they are.

They are put into the wrench of a log of the tests' own: what a hand gives beside what moved the cart is what resisted
it."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from cartgrasp.effects import ViscousDrag
from cartgrasp.inertia import Inertia
from cartgrasp.logs import ArmLog
from cartgrasp.model import CartModel
from estimation.discrepancy import diagnose
from estimation.discrepancy.findings.certainty import Certainty
from estimation.discrepancy.search.gains import score_gain
from estimation.discrepancy.search.laws import smooth_laws
from estimation.discrepancy.search.model import Model
from estimation.weak_form.balances import Balances

from ...runs import simulate
from ...weak_form.motions import TRUE, cart_of, noisy, weaving

TRUTH = (24.0, 0.28, 0.06, 2.2, 3.0, 1.2, 0.0)
CART = CartModel(Inertia(24.0, (0.28, 0.06), 2.2), effects=(ViscousDrag(linear=3.0, angular=1.2),))


def resisted(force, seed, duration, moment=lambda time, truth: 0.0):
    """A log in which a cart was resisted by `force(time, truth)` at {b}'s origin and a `moment`, against which the hand
    pushed and turned; truth (n, 5) is (x, y, heading, speed, yaw rate)."""
    log, truth = simulate(TRUTH, seed, duration, noise=(0.0005, 0.005, 1.0))
    ((name, arm),) = log.arms.items()
    wrench = arm.wrench.copy()
    more = force(log.time, truth)
    wrench[:, 0] += more
    wrench[:, 5] += arm.contact[:, 1] * more + moment(log.time, truth)
    return replace(log, arms={name: ArmLog(arm.contact, wrench)})


def rolled(time, speed):
    return np.cumsum(np.append(0.0, np.diff(time)) * speed)


def law_of(found):
    """The one law that was found, as a report tells it, and its effect; and nothing else."""
    (effect,) = found.effects
    assert effect.name == "learned_force"
    assert effect.probability > 0.5
    assert found.unexplained["depends_on"] == []
    return effect.as_dict()["law"], effect.law


@cache
def with_the_wheels_turn(is_drag=False, turns_back=True):
    """A log of a flat spot, or of what resembles one, and its diagnosis."""

    def force(time, truth):
        speed = truth[:, 3]
        way = rolled(time, speed if turns_back else np.abs(speed))
        return 4.0 * np.sin(2 * np.pi * way / 0.4) * (np.sign(speed) if is_drag else 1.0)

    log = resisted(force, 3, 30.0)
    return log, diagnose(log, CART)


@cache
def without_a_law(seed=3):
    return diagnose(resisted(lambda time, truth: 0.0, seed, 30.0), CART)


@pytest.mark.long
@pytest.mark.parametrize(
    ("is_drag", "turns_back"),
    [
        (False, True),
        *(pytest.param(*one, marks=pytest.mark.prove) for one in ((False, False), (True, False), (True, True))),
    ],
)
def test_a_force_with_the_wheels_turn_is_found_by_its_period(is_drag, turns_back):
    """Of the way rolled, which turns back where the cart does, or of the way travelled; a force or a drag."""
    law, own = law_of(with_the_wheels_turn(is_drag, turns_back)[1])
    assert law["of"] == "travelled_distance"
    assert law["acts_on"] == "forward_force"
    assert law["period"]["unit"] == "m"
    assert law["period"]["value"] == pytest.approx(0.4, abs=max(3 * law["period"]["std"], 0.0005))
    assert law["period"]["std"] < 0.002
    assert own.size == pytest.approx(4.0 / 2**0.5, rel=0.3)
    assert "radius 64 mm" in law["likely"]


@pytest.mark.long
@pytest.mark.parametrize("seed", [3, pytest.param(4, marks=pytest.mark.prove)])
def test_without_one_nothing_is_followed(seed):
    found = without_a_law(seed)
    assert found.verdict == "no_discrepancy"
    assert found.unexplained["depends_on"] == []
    assert not any(found.unexplained["size"].values())


@pytest.mark.prove
def test_a_period_is_the_whole_turn():
    """Of a force with its second and fifth harmonics: alone, the second looks like half a turn."""

    def force(time, truth):
        phase = 2 * np.pi * rolled(time, truth[:, 3]) / 1.6
        return 5.0 * np.sin(2 * phase) + 4.0 * np.sin(5 * phase)

    law, _ = law_of(diagnose(resisted(force, 3, 40.0), CART))
    assert law["of"] == "travelled_distance"
    assert law["period"]["value"] == pytest.approx(1.6, rel=0.002)


@pytest.mark.prove
@pytest.mark.parametrize("period", [0.85, 1.4])
def test_a_hum_is_no_change_of_the_mass_from_band_to_band(period):
    """It shakes the cart in some bands alone, which a model without it takes for another mass: in narrower ones that
    agree, rows come so seldom that another period fits as well."""
    law, _ = law_of(diagnose(resisted(lambda time, _: 9.0 * np.sin(2 * np.pi * time / period), 3, 40.0), CART))
    assert law["of"] == "time"
    assert law["period"]["value"] == pytest.approx(period, rel=0.002)


@pytest.mark.prove
def test_seams_across_the_floor_are_found_by_their_distance():
    """Where the floor itself pushes towards the nearest seam, whatever way was travelled."""

    def force(time, truth):
        return 6.0 * np.sin(2 * np.pi * truth[:, 0] / 0.7) * np.cos(truth[:, 2])

    law, _ = law_of(diagnose(resisted(force, 4, 60.0), CART))
    assert (law["of"], law["acts_on"]) == ("place", "world_force")
    assert law["period"]["value"] == pytest.approx(0.7, rel=0.003)
    assert "0.7 m of the floor along x" in law["words"]


@pytest.mark.prove
def test_a_floor_that_slopes_has_its_name():
    """A force once round with the heading, at the CoM; recorded as what resists, 4 N of 24 kg uphill along y."""

    def force(time, truth):
        return 4.0 * np.sin(truth[:, 2])

    def moment(time, truth):
        return 4.0 * (0.28 * np.cos(truth[:, 2]) - 0.06 * np.sin(truth[:, 2]))

    found = diagnose(resisted(force, 3, 40.0, moment), CART)
    assert [effect.name for effect in found.effects] == ["floor_slope"]
    assert found.effects[0].parameters["grade_y"][0] == pytest.approx(4.0 / (24.0 * 9.81), rel=0.1)


@pytest.mark.prove
def test_a_floor_with_a_grain_has_none():
    """A force twice round with the heading."""
    law, _ = law_of(diagnose(resisted(lambda time, truth: 4.0 * np.sin(2 * truth[:, 2]), 3, 40.0), CART))
    assert law["of"] == "heading"


DRAGS = {
    "time": lambda time, truth: np.sign(truth[:, 3]) * np.cos(np.pi * time / time[-1]),
    "heading": lambda time, truth: 2.5 * truth[:, 3] * np.cos(truth[:, 2]),
    "heading, two opposite ones": lambda time, truth: np.sign(truth[:, 3]) * np.sin(2 * truth[:, 2]),
    "place": lambda time, truth: np.sign(truth[:, 3]) * (truth[:, 0] - truth[:, 0].mean()) / 3,
    "yaw rate": lambda time, truth: 3 * truth[:, 3] * np.abs(truth[:, 4]),
}


@pytest.mark.long
@pytest.mark.some(1)
@pytest.mark.parametrize("name", DRAGS)
def test_a_drag_that_grows_with_something_is_found(name):
    """Flat in speed or not."""
    found = diagnose(resisted(lambda time, truth: 5.0 * DRAGS[name](time, truth), 4, 30.0), CART)
    law, _ = law_of(found)
    assert law["of"] == name.split(",")[0].replace(" ", "_")
    assert "drag" in law["acts_on"]
    assert found.verdict == "explained"


@pytest.mark.long
@pytest.mark.parametrize("seed", range(3))
def test_noise_of_the_motion_is_explained_by_no_law_and_no_light_body(seed):
    """A heading that is known to 2 mrad, and a yaw acceleration in proportion to it: the inertia is what the truth's
    is, and a moment by heading explains little more. With the noise on both sides that would be 140 to 370 nats, and an
    inertia of next to nothing."""
    true = cart_of(TRUE)
    log = replace(noisy(weaving(TRUE, 60.0, wobble=0.0), seed, pose=2e-3), velocity=None)
    model = Model.started([Balances.of(log, true)], cart_of((20.0, 0.3, 0.0, 2.0, 2.0, 1.0)))
    std = Certainty(model).parameters["inertia"].std
    assert abs(model.cart.inertia.about_com - true.inertia.about_com) < 3 * std < 0.2
    laws = smooth_laws(model.motions, model.cart)
    law = next(one for one in laws if (one.name, one.form) == ("heading", "moment"))
    more = replace(model, laws=(law,)).refitted(model.cart)
    assert score_gain(model.score, more.score, None) < 30.0
