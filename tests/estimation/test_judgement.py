"""Each reason for which an effect is not named, and that nothing else stands in its way."""

from dataclasses import dataclass, field
from types import SimpleNamespace

import numpy as np
import pytest

from cartgrasp.effects import (
    CasterRealignment,
    DirectionalDrag,
    ExternalPush,
    FloorPatch,
    FloorSlope,
    ForceBias,
    ForceScale,
    LoadSlosh,
    PayloadChange,
    QuadraticDrag,
    StribeckFriction,
    TimeDelay,
    ViscousDrag,
    WheelDragImbalance,
)
from cartgrasp.inertia import Inertia
from cartgrasp.model import CartModel
from cartgrasp.wheels import Wheel, WheelSet
from estimation.discrepancy.evidence import Finding
from estimation.discrepancy.generic import Dependence
from estimation.discrepancy.held_out import Gain, deviation_of_mean
from estimation.discrepancy.judgement import Judge
from estimation.discrepancy.strange_carts import drives_itself
from estimation.prior import Prior

WHEELS = WheelSet.of(
    (Wheel("fixed", 0.0, 0.3), Wheel("fixed", 0.0, -0.3), Wheel("caster", 0.7, 0.0, 0.05)), rolls_along_x=True
)


@dataclass
class Proof:
    """What is measured on held-out stretches, given."""

    share: float = 0.5
    noise: float = 0.0
    of_rest: float = 0.0
    log_likelihood: float = 0.0
    is_everywhere: bool = False
    rolling: tuple = (WHEELS, 0.8)
    share_everywhere: float = 0.0

    @property
    def everywhere(self):
        return Proof(self.share_everywhere, log_likelihood=self.log_likelihood)

    def covers(self, effect):
        return self.is_everywhere and isinstance(effect, FloorPatch)

    def gain(self, fitted, better):
        return Gain(self.share, self.noise, self.of_rest)

    def likelihood(self, fitted, better):
        return self.log_likelihood


@dataclass
class Fit:
    dependence: object = None
    by_direction: dict = field(default_factory=dict)
    effect: object = None
    excess: float = 1.0
    is_late: bool = False
    regressions: tuple = (SimpleNamespace(step=0.01),)
    others: tuple = ()
    added: tuple = ()
    mass: float = 20.0
    prior: Prior = field(default_factory=Prior)
    prior_cart: CartModel = field(default_factory=lambda: CartModel(Inertia(20.0, (0.3, 0.0), 1.5)))

    @property
    def cart(self):
        return CartModel(Inertia(self.mass, (0.3, 0.0), 1.5), effects=(*self.others, self.effect or ViscousDrag()))

    def follows(self, lasts):
        seen = self.dependence
        return seen if seen and (seen.is_periodic or seen.is_of_the_floor or not lasts) else None

    def misfit(self, direction):
        return self.by_direction[direction]


def follows(foretold, period=2.2, name="time, periodic"):
    """What fits all of the residual, and foretells that share of its squares."""
    return Dependence(name, 0, period, "s", 40.0, 1.0, foretold)


def patch(x, y, label="", side=1.0):
    return FloorPatch(x_min=x, x_max=x + side, y_min=y, y_max=y + side, coefficient=0.03, label=label)


def judged(effect=None, score=50.0, change=(0.1, 0.1), proof=None, before=None, strongest=0.0, **model):
    judge = Judge(before or Fit(), proof or Proof(), strongest)
    effect = effect or QuadraticDrag(coefficient=5.0)
    none = np.zeros(0)
    found = Finding(effect, score, score, none, none, none, *change)
    return judge.verdict(found, score, Fit(effect=effect, **model))


LATE = TimeDelay(delay=0.08)


def test_what_is_probable_steady_and_gains_is_added():
    assert judged().is_added


def test_what_does_not_swing_is_judged_beside_a_late_sensor_as_elsewhere():
    assert judged(strongest=2000.0, before=Fit(added=(LATE,))).is_added
    assert judged(LoadSlosh(mass=3.0), strongest=2000.0).is_added


@pytest.mark.parametrize(
    ("case", "said"),
    [
        ({"score": 6.9}, "below 7"),
        ({"effect": LoadSlosh(mass=3.0), "score": 11.9}, "below 12"),
        ({"strongest": 6000.0}, "below 60"),
        ({"effect": TimeDelay(delay=0.009)}, "less than a sample"),
        ({"effect": LoadSlosh(mass=3.0), "strongest": 2000.0, "before": Fit(added=(LATE,))}, "below 100"),
        ({"change": (0.6, 0.1)}, "another part of the log"),
        ({"change": (0.1, 0.6)}, "another part of the log"),
        ({"proof": Proof(share=0.04)}, "closes 4.0 %"),
        ({"proof": Proof(share=-0.06, log_likelihood=50.0)}, "closes -6.0 %"),
        ({"proof": Proof(share=-0.5, noise=0.25, log_likelihood=5.9)}, "closes -50.0 %"),
        ({"effect": ExternalPush(start=1.0, duration=0.5, force=9.0), "score": 19.0}, "below 20"),
        ({"effect": ExternalPush(start=1.0, duration=0.5, force=9.0), "strongest": 1000.0}, "below 150"),
        ({"effect": ExternalPush(start=1.0, duration=0.5, force=9.0, moment=5.0), "score": 99.0}, "below 100"),
        ({"effect": PayloadChange(time=9.0, mass=3.0), "strongest": 5000.0}, "below 100"),
        ({"effect": ExternalPush(duration=0.5), "proof": Proof(share=0.0, log_likelihood=50.0)}, "closes 0.0 %"),
        ({"effect": FloorPatch(x_max=9.0, y_max=9.0), "proof": Proof(is_everywhere=True)}, "nearly everywhere"),
        ({"effect": WheelDragImbalance(force=4.0, moment=0.1)}, "both wheels drag alike"),
        ({"effect": WheelDragImbalance(force=0.1, moment=-0.2)}, "where no wheel is"),
        ({"effect": ExternalPush(start=1.0, duration=9.0, force=9.0)}, "nobody pushes for 9.0 s"),
        ({"effect": StribeckFriction(breakaway=3.0, speed=0.5)}, "far from standstill"),
        ({"effect": LoadSlosh(mass=3.0, damping=0.9)}, "nothing swings"),
        ({"effect": DirectionalDrag(forward=-11.0, backward=11.0)}, "drive itself"),
        (
            {
                "effect": ExternalPush(start=1.0, duration=0.5, force=9.0),
                "before": Fit(follows(0.11), {0: 500.0}),
            },
            "follows time, periodic",
        ),
        ({"before": Fit(follows(0.12), {0: 900.0})}, "follows time, periodic"),
    ],
)
def test_a_reason_against_it(case, said):
    verdict = judged(**case)
    assert not verdict.is_added
    assert said in verdict.reason


@pytest.mark.parametrize(
    "proof",
    [
        Proof(share=0.051),
        Proof(share=0.0, of_rest=0.31),
        Proof(share=0.001, log_likelihood=4.1),
        Proof(share=-0.5, noise=0.25, log_likelihood=6.1),
    ],
)
def test_one_gain_is_enough(proof):
    assert judged(proof=proof).is_added


@pytest.mark.parametrize(
    ("place", "is_another"),
    [
        ((0.2, 0.2, 0.6), False),
        ((-0.1, -0.1, 1.2), False),
        ((0.5, -3.0, 9.0), False),
        ((1.1, 0.0), False),
        ((1.3, 0.0), True),
        ((0.0, -1.3), True),
        ((-2.0, -2.0), True),
    ],
)
@pytest.mark.parametrize(
    "proof", [Proof(share=0.04, log_likelihood=90.0), Proof(share=0.04, of_rest=0.9)], ids=["likely", "of the rest"]
)
def test_a_second_patch_at_the_firsts_place_is_its_form(place, is_another, proof):
    """A carpet with ramps for edges is one, whose middle and rim look like two; unless it moves the cart itself."""
    told = {"effect": patch(*place[:2], "2", *place[2:]), "others": (patch(0.0, 0.0),)}
    assert judged(**told, proof=proof).is_added == is_another
    assert judged(**told, proof=Proof(share=0.06)).is_added


def test_a_patch_in_a_gust_is_a_patch():
    """Nothing else that acts there is a form of it."""
    assert judged(patch(0.0, 0.0), proof=Proof(share=0.01, log_likelihood=9.0), others=(FloorSlope(),)).is_added


def test_what_a_period_does_not_foretell_is_none_of_its():
    assert judged(before=Fit(follows(0.11), {0: 900.0})).is_added
    assert judged(before=Fit(follows(0.09), {0: 9000.0})).is_added


@pytest.mark.parametrize(
    ("name", "foretold", "is_one"),
    [("speed", 0.3, True), ("heading", 0.12, True), ("heading", 0.13, False), ("place", 0.13, False)],
)
def test_what_follows_heading_or_place_far_better_is_no_drag(name, foretold, is_one):
    """It takes away 100 of 900. A floor that slopes is tried before what takes away less than it; speed is what drags
    follow in other forms."""
    before = Fit(follows(foretold, None, name), {0: 900.0})
    assert judged(before=before).is_added == is_one
    assert judged(before=before).is_nameless != is_one


def test_a_push_is_no_part_of_what_follows_anything():
    push = ExternalPush(start=1.0, duration=0.5, force=9.0)
    for name in ("speed", "heading"):
        assert f"follows {name}" in judged(push, before=Fit(follows(0.11, None, name), {0: 900.0})).reason


def test_a_push_is_proven_where_it_is():
    push = ExternalPush(start=1.0, duration=0.5, force=9.0)
    assert judged(push, proof=Proof(share=0.0, share_everywhere=0.2)).is_added


def test_a_strong_push_counts_beside_any_effect():
    push = ExternalPush(start=1.0, duration=0.5, force=9.0)
    assert judged(push, score=190.0, proof=Proof(share=0.2, share_everywhere=0.2), strongest=5000.0).is_added


def test_a_lasting_change_counts_beside_a_strong_effect():
    assert judged(PayloadChange(time=9.0, mass=3.0), proof=Proof(share=0.2), strongest=2000.0).is_added


def test_a_lasting_change_is_proven_by_what_came_after_it():
    assert judged(PayloadChange(time=9.0, mass=3.0), proof=Proof(share=0.0, log_likelihood=5.0)).is_added


@pytest.mark.parametrize(
    ("mass", "is_one"), [(-8.0, True), (-16.9, True), (-17.1, False), (-49.0, False), (300.0, True)]
)
def test_no_more_is_taken_off_than_is_there(mass, is_one):
    """Of 20 kg."""
    verdict = judged(PayloadChange(time=9.0, mass=mass), score=90.0)
    assert verdict.is_added == is_one
    assert is_one or "of 20 kg, it would leave" in verdict.reason


@pytest.mark.parametrize(("mass", "is_one"), [(6.0, True), (13.0, True), (14.0, False)])
def test_a_load_that_swings_is_a_part_of_the_cart(mass, is_one):
    """Of 20 kg: two thirds at most."""
    verdict = judged(LoadSlosh(mass=mass, frequency=1.2), score=90.0)
    assert verdict.is_added == is_one
    assert is_one or "of 20 kg, 14 kg would swing" in verdict.reason


def test_a_drag_may_be_less_one_way_than_what_is_known_of_it():
    """On a cart that drags more than that in all; and a floor that slopes drives no cart along all headings."""
    cart = CartModel(Inertia(20.0, (0.3, 0.0), 1.5), effects=(ViscousDrag(linear=12.0),))
    for effect in (DirectionalDrag(forward=-11.0, backward=11.0), FloorSlope(grade_x=0.05)):
        assert not drives_itself(cart.with_effect(effect), 0.8)
    assert drives_itself(cart.with_effect(DirectionalDrag(forward=-17.0, backward=11.0)), 0.8)


@pytest.mark.parametrize("grade", [0.003, 0.05])
def test_a_cart_without_drag_needs_nothing(grade):
    """Whatever a sum over headings leaves of a floor's slope."""
    assert judged(FloorSlope(grade_x=grade, grade_y=-0.7 * grade), before=Fit(effect=FloorSlope())).is_added


@pytest.mark.parametrize(
    ("forward", "backward", "is_one"),
    [(16.7, 16.5, False), (9.1, 10.0, False), (8.9, 10.0, True), (0.0, 3.0, True), (10.0, 0.0, True)],
)
def test_a_drag_that_is_alike_both_ways_has_none(forward, backward, is_one):
    """It is viscous drag, where the cart has none yet that could make up for both."""
    drag = DirectionalDrag(forward=forward, backward=backward)
    verdict = judged(drag, before=Fit(effect=QuadraticDrag()))
    assert verdict.is_added == is_one
    assert is_one or "it is viscous_drag" in verdict.reason
    assert judged(drag, before=Fit(effect=ViscousDrag(linear=4.0))).is_added


def test_what_is_remembered_may_have_been_remembered_wrongly():
    casters = CasterRealignment(swivel_torque=0.2, trail=0.05)
    assert judged(casters, change=(0.1, 0.9)).is_added
    assert "another part of the log" in judged(casters, change=(0.1, 1.1)).reason


def test_a_delay_of_some_samples_is_one():
    assert judged(TimeDelay(delay=0.013)).is_added


@pytest.mark.parametrize(("gain", "is_one"), [(0.39, False), (0.41, True), (0.9, True), (2.45, True), (2.55, False)])
def test_a_gain_is_that_of_a_sensor(gain, is_one):
    assert judged(ForceScale(gain=gain)).is_added == is_one


@pytest.mark.parametrize(
    ("effect", "without", "mass", "is_one"),
    [
        (ForceScale(gain=0.6), 12.0, 20.0, True),
        (ForceScale(gain=0.6), 16.0, 27.0, True),
        (ForceScale(gain=2.0), 20.0, 11.9, False),
        (ForceScale(gain=0.6), 20.0, 28.1, False),
        (ForceScale(gain=0.6), 31.0, 29.0, True),
        (ForceBias(fx=3.0), 20.0, 11.9, False),
        (QuadraticDrag(coefficient=5.0), 20.0, 11.9, True),
    ],
)
def test_a_sensor_that_is_read_rightly_makes_no_other_cart(effect, without, mass, is_one):
    """Of 20 kg, to 40 %; but for one that was further off before."""
    verdict = judged(effect, before=Fit(mass=without), mass=mass)
    assert verdict.is_added == is_one
    assert is_one or f"{mass:.3g} kg, far from 20 kg" in verdict.reason


def test_how_a_delay_varies_is_not_seen_from_another():
    drifting = {"effect": TimeDelay(delay=0.025), "change": (0.1, 0.9)}
    assert "another part of the log" in judged(**drifting).reason
    assert judged(**drifting, before=Fit(is_late=True)).is_added


@pytest.mark.parametrize(("found", "is_one"), [(0.155, False), (0.145, True)])
def test_how_a_delay_varies_is_not_seen_far_from_it(found, is_one):
    """A screening at 0.145 s says little of one that a search found at 0.156 s."""
    none, judge = np.zeros(0), Judge(Fit(), Proof(), 0.0)
    screened = Finding(TimeDelay(delay=found), 50.0, 50.0, none, none, none, 0.1, 0.9)
    assert judge.verdict(screened, 50.0, Fit(effect=TimeDelay(delay=0.156))).is_added == is_one


def test_a_tight_wheel_is_plausible():
    assert judged(WheelDragImbalance(force=4.0, moment=-1.2)).is_added


def test_noise_of_a_gain():
    """Of means of rollouts, neighbours of which share half: what they scatter by, over many draws."""
    white = np.random.default_rng(0).standard_normal((2000, 81))
    shared = white[:, 1:] + white[:, :-1]
    told = [deviation_of_mean(1e-4 * one) for one in shared]
    assert np.mean(np.square(told)) ** 0.5 == pytest.approx(1e-4 * shared.mean(axis=1).std(), rel=0.05)


@pytest.mark.parametrize(
    ("case", "is_nameless"),
    [
        ({"change": (0.1, 0.6)}, True),
        ({"before": Fit(follows(0.12), {0: 900.0})}, True),
        ({"before": Fit(follows(0.11), {0: 900.0})}, False),
        ({"score": 6.9}, False),
        ({"effect": LoadSlosh(mass=3.0, damping=0.9)}, False),
        ({"effect": ForceScale(gain=4.2)}, True),
        ({"effect": ForceScale(gain=0.6), "mass": 8.0}, True),
        ({"effect": LoadSlosh(mass=3.0, damping=0.9), "change": (0.1, 1.1)}, False),
    ],
)
def test_what_is_there_without_a_name(case, is_nameless):
    """So that nothing that explains less is its name: it drifts, follows a period that no effect has, or is what spoils
    an arm's wrenches."""
    assert judged(**case).is_nameless == is_nameless
