"""Effects of one's own, which work in numpy: mistakes in them are refused in a sentence, and files have them."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import ClassVar

import numpy as np
import pytest

from cartgrasp import foreign_effects
from cartgrasp.cart_file import load_cart
from cartgrasp.effects import Contribution, ForceEffect, ViscousDrag
from cartgrasp.errors import UsageError
from cartgrasp.model import CartModel

from .test_kernels import OURS, Ballast, Lag


class OfOneShape(Lag):
    """With one number of a contribution in place of the whole."""

    name: ClassVar[str] = "of_one_shape"
    spoilt: ClassVar[tuple[str, str]] = ("wrench_b", "value")

    def _spoilt(self, method, part):
        return replace(part, **{self.spoilt[1]: np.ones(1)}) if method == self.spoilt[0] else part

    def wrench_b(self, situation, memory, parameters):
        return self._spoilt("wrench_b", super().wrench_b(situation, memory, parameters))

    def memory_rate(self, situation, memory, parameters):
        return self._spoilt("memory_rate", super().memory_rate(situation, memory, parameters))


@pytest.mark.parametrize(
    ("method", "name", "shape"),
    [
        ("wrench_b", "value", (3,)),
        ("wrench_b", "by_velocity", (3, 3)),
        ("wrench_b", "by_phi", (3, 4)),
        ("wrench_b", "by_memory", (3, 1)),
        ("wrench_b", "by_parameters", (3, 2)),
        ("memory_rate", "by_pose", (1, 3)),
        ("memory_rate", "by_parameters", (1, 2)),
    ],
)
def test_what_numpy_would_stretch_is_refused(method, name, shape):
    """Whether it is asked at one state or at rows of them."""
    spoilt = type("Spoilt", (OfOneShape,), {"spoilt": (method, name)})
    cart = CartModel(OURS.inertia, effects=(ViscousDrag(3.0), spoilt()))
    where = re.escape(f"of_one_shape.{method}: {name} has shape (1,), but {shape}")
    with pytest.raises(UsageError, match=f"^{where} is needed$"):
        cart.effect_wrench(cart.state())
    with pytest.raises(UsageError, match=f"^{where} or {re.escape(str((5, *shape)))} is needed$"):
        cart.rate(np.tile(cart.state(), (5, 1)), np.zeros(3))


def test_a_change_of_inertia_that_numpy_would_stretch_is_refused():
    class Stretched(Ballast):
        def phi_change(self, time, parameters):
            return Contribution(np.ones(4), by_parameters=np.ones(1))

    cart = CartModel(OURS.inertia, effects=(Stretched(),))
    with pytest.raises(
        UsageError, match=r"^ballast.phi_change: by_parameters has shape \(1,\), but \(4, 1\) is needed$"
    ):
        cart.phi_at(0.0)


def test_an_effect_that_returns_no_contribution_is_refused():
    class Bare(Lag):
        def wrench_b(self, situation, memory, parameters):
            return np.zeros(3)

    with pytest.raises(UsageError, match=r"^lag.wrench_b: array.* is no Contribution; return Contribution\(value"):
        CartModel(OURS.inertia, effects=(Bare(),)).effect_wrench(np.zeros(6))


def test_shapes_are_checked_once_for_carts_of_one_structure(monkeypatch):
    asked = []
    monkeypatch.setattr(foreign_effects, "check_shapes", lambda *given: asked.append(given[0]))
    cart, rows = CartModel(OURS.inertia, effects=(Lag(),)), np.zeros((5, 6))
    for state in (rows[0], rows[0], rows, rows):
        cart.effect_wrench(state)
        cart.with_parameters(cart.parameters * 1.1).effect_wrench(state)
    assert asked == ["lag.wrench_b", "lag.memory_rate"] * 2


def test_a_name_of_the_library_is_refused():
    """Files would give such a cart back with the library's effect."""

    class Thick(Lag):
        name: ClassVar[str] = "viscous_drag"

    class Thin(ViscousDrag):
        pass

    for effect in (Thick(), Thin()):
        where = f"effects: viscous_drag: {type(effect).__name__} has the name of an effect of the library; give it one"
        for make in (
            lambda own: CartModel(OURS.inertia, effects=(own,)),
            OURS.without_effect("viscous_drag").with_effect,
        ):
            with pytest.raises(UsageError, match=where):
                make(effect)


@pytest.mark.parametrize("given", [((5.0,), {}), ((), {"linear": 5.0}), ((), {})], ids=["place", "name", "none"])
def test_a_class_that_is_no_dataclass_is_refused(given):
    class Undecorated(ForceEffect):
        linear: float = 0.0
        name = "undecorated"
        parameters = Lag.parameters[:1]

        def wrench_b(self, situation, memory, parameters):
            return Contribution(np.zeros(3))

    values, named = given
    with pytest.raises(UsageError, match=r"^Undecorated: the class .* put @dataclass\(frozen=True\) above it"):
        Undecorated(*values, **named)


def test_one_without_values_needs_be_none():
    class Wind(ForceEffect):
        name = "wind"
        parameters = ()

        def wrench_b(self, situation, memory, parameters):
            return Contribution(np.array([2.0, 0.0, 0.0]))

    assert [Wind().key, Wind(label="north").key] == ["wind", "wind.north"]
    cart = CartModel(OURS.inertia, effects=(Wind(),))
    assert cart.effect_wrench(cart.state()).tolist() == [2.0, 0.0, 0.0]


def test_files_are_read_with_effects_of_ones_own(tmp_path):
    cart = CartModel(OURS.inertia, effects=(ViscousDrag(3.0), Lag(2.5), Lag(1.0, 0.5, label="rear"), Ballast(4.0)))
    path = cart.save(tmp_path / "cart.yaml")
    again = load_cart(path, effects=[Ballast, Lag])
    assert again == cart
    assert again.parameter_names == cart.parameter_names


def test_a_file_with_an_effect_that_is_not_given_says_how_to_give_it(tmp_path):
    path = CartModel(OURS.inertia, effects=(Lag(), Ballast())).save(tmp_path / "cart.yaml")
    for known, missing in (((), "lag"), ((Lag,), "ballast")):
        where = rf":\d+:\d+: effects.{missing}: unknown effect; .*an effect of your own is given in Python: load_cart\("
        with pytest.raises(UsageError, match=where):
            load_cart(path, effects=known)


@pytest.mark.parametrize(
    ("effects", "words"),
    [
        (Lag, "effects: .* is no list; write effects="),
        ([Lag()], r"effects: Lag\(.* is no type; write effects=\[CubicDrag\], the classes of your own"),
        ([float], "effects: float is no Effect; write"),
    ],
)
def test_what_is_no_class_of_an_effect_is_refused(tmp_path, effects, words):
    path = CartModel(OURS.inertia, effects=(Lag(),)).save(tmp_path / "cart.yaml")
    with pytest.raises(UsageError, match=words):
        load_cart(path, effects=effects)
