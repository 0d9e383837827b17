"""What effects in numpy return has the shape that it is added to."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import ClassVar

import numpy as np
import pytest

from cartgrasp import foreign_effects
from cartgrasp.effects import Contribution, ViscousDrag
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
