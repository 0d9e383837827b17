"""Labels of effects that a search tries beside those of a cart."""

import pytest

from cartgrasp.effects import ExternalPush, FloorPatch, ForceBias, ViscousDrag
from cartgrasp.inertia import Inertia
from cartgrasp.model import CartModel
from estimation.discrepancy.vocabulary import trials


def cart_with(*effects):
    return CartModel(Inertia(24.0, (0.28, 0.06), 2.2), effects=effects)


@pytest.mark.parametrize(
    "labels", [(), ("",), ("2",), ("", "2"), ("", "3"), ("2", "3"), ("carpet",), ("", "carpet", "2")]
)
@pytest.mark.parametrize("kind", [ExternalPush, FloorPatch])
def test_what_comes_again_has_a_label_of_its_own(kind, labels):
    cart = cart_with(*(kind(label=label) for label in labels))
    offered = {one.label for one in trials(cart, ["arm"]) if isinstance(one, kind)}
    assert len(offered) == 1
    assert offered.isdisjoint(labels)
    for one in trials(cart, ["arm"]):
        cart.with_effect(one)


def test_what_was_taken_out_comes_back_under_its_label():
    """So that it can be told that it is the same."""
    offered = {one.label for one in trials(cart_with(ExternalPush(label="2")), ["arm"]) if one.name == "external_push"}
    assert offered == {""}


def test_what_always_acts_comes_once():
    names = {one.name for one in trials(cart_with(ViscousDrag(), ForceBias(label="arm")), ["arm"])}
    assert not names & {"viscous_drag", "force_bias"}
