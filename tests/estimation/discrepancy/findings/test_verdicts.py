"""What a diagnosis calls the gap that is left, and what nobody would call by an effect's name."""

from types import SimpleNamespace

import pytest

from cartgrasp.effects import (
    DirectionalDrag,
    ExternalPush,
    FloorPatch,
    ForceBias,
    LoadSlosh,
    StribeckFriction,
    TimeDelay,
    ViscousDrag,
    WheelDragImbalance,
)
from cartgrasp.inertia import Inertia
from cartgrasp.model import CartModel
from cartgrasp.wheels import Wheel, WheelSet
from estimation.discrepancy.diagnosis.diagnosis import Diagnosis
from estimation.discrepancy.findings.gap import Gap
from estimation.discrepancy.search.candidates import families
from estimation.discrepancy.search.plausibility import is_plausible

WHEELS = WheelSet.of(
    (Wheel("fixed", 0.0, 0.3), Wheel("fixed", 0.0, -0.3), Wheel("caster", 0.7, 0.0, 0.05)), rolls_along_x=True
)


@pytest.mark.parametrize(
    ("after", "floor", "verdict"),
    [
        (0.010, 0.010, "explained"),
        (0.030, 0.010, "partly_explained"),
        (0.030, 0.016, "explained"),
        (0.006, 0.001, "explained"),
        (0.060, 0.001, "partly_explained"),
    ],
)
def test_a_gap_far_above_the_floor_is_not_explained(after, floor, verdict):
    """Unless little is left of what was there: 0.1 m."""
    gap = Gap(0.1, 0.1, after, floor, {}, {})
    found = SimpleNamespace(disagrees=True, effects=("one",), gap=gap)
    assert Diagnosis.verdict.func(found) == verdict


@pytest.mark.parametrize(
    ("effect", "is_one"),
    [
        (ExternalPush(start=1.0, duration=0.5, force=9.0), True),
        (ExternalPush(start=1.0, duration=9.0, force=9.0), False),  # nobody pushes for 9 s
        (WheelDragImbalance(force=4.0, moment=-1.2), True),
        (WheelDragImbalance(force=0.1, moment=-0.2), False),  # where no wheel is
        (StribeckFriction(breakaway=3.0, speed=0.1), True),
        (StribeckFriction(breakaway=3.0, speed=0.6), False),  # far from standstill
        (LoadSlosh(mass=3.0, frequency=1.2), True),
        (LoadSlosh(mass=3.0, frequency=1.2, damping=0.9), False),  # nothing swings
        (TimeDelay(delay=0.013), True),
        (TimeDelay(delay=0.006), False),  # sensors that hold or average are as late
    ],
)
def test_what_nobody_would_call_so_has_no_name(effect, is_one):
    assert bool(is_plausible(effect, WHEELS)) is is_one


def cart_with(*effects):
    return CartModel(Inertia(24.0, (0.28, 0.06), 2.2), effects=effects)


@pytest.mark.parametrize(
    "labels", [(), ("",), ("2",), ("", "2"), ("", "3"), ("2", "3"), ("carpet",), ("", "carpet", "2")]
)
@pytest.mark.parametrize("kind", [ExternalPush, FloorPatch])
def test_what_comes_again_has_a_label_of_its_own(kind, labels):
    cart = cart_with(*(kind(label=label) for label in labels))
    variants = [one for family in families(cart, ["arm"]) for one in family.variants]
    offered = {one.label for one in variants if isinstance(one, kind)}
    assert len(offered) == 1
    assert offered.isdisjoint(labels)
    for one in variants:
        cart.with_effect(one)


def test_what_was_taken_out_comes_back_under_its_label():
    """So that it can be told that it is the same."""
    offered = {family.variants[0].key for family in families(cart_with(ExternalPush(label="2")), ["arm"])}
    assert "external_push" in offered


def test_what_always_acts_comes_once():
    names = {family.variants[0].name for family in families(cart_with(ViscousDrag(), ForceBias(label="arm")), ["arm"])}
    assert not names & {"viscous_drag", "force_bias"}
    assert DirectionalDrag().name in names
