"""Pushes, places and loads that stand in for what has no name."""

from dataclasses import dataclass, field, replace
from types import SimpleNamespace

import pytest

from cartgrasp.effects import (
    ExternalPush,
    FloorPatch,
    FloorSlope,
    LoadSlosh,
    PayloadChange,
    RollingResistance,
    WheelMisalignment,
)
from estimation.discrepancy import diagnosis
from estimation.discrepancy.stand_ins import MOST, MUCH, stand_ins

PUSH, LATER = ExternalPush(start=1.0, duration=1.0, force=5.0), ExternalPush(start=9.0, duration=1.0, label="2")
PATCH, LOAD = FloorPatch(x_max=1.0, y_max=1.0, coefficient=0.03), PayloadChange(time=3.0, mass=5.0)
ROLLING, SLOPE, SLOSH = RollingResistance(coefficient=0.02), FloorSlope(grade_x=0.01), LoadSlosh(mass=3.0)
ANGLE = WheelMisalignment(angle=0.02)


@dataclass(frozen=True)
class Fit:
    added: tuple


@dataclass(frozen=True)
class Proof:
    """Gaps (m): of the nominal model 10 floors, of any other so much of its square above one floor."""

    left: float
    nominal: str = "nominal"

    def gap(self, fitted):
        return 10.0 if fitted is self.nominal else (1 + self.left * 99) ** 0.5

    def floor(self, fitted):
        return 1.0


def names(*added, left):
    return stand_ins(Fit(added), Proof(left))


@pytest.mark.parametrize("added", [(PUSH,), (PATCH,), (LOAD,), (PUSH, PATCH), (ROLLING, PUSH), (LOAD, SLOPE), ()])
def test_one_of_a_kind_that_explains_most_keeps_its_name(added):
    assert names(*added, left=0.0) == names(*added, left=MUCH - 0.05) == ()


@pytest.mark.parametrize(
    ("added", "lost"),
    [
        ((PUSH, LATER), ("external_push", "external_push.2")),
        ((ROLLING, PUSH, LATER), ("external_push", "external_push.2")),
        ((PUSH, SLOSH, LATER), ("external_push", "load_slosh", "external_push.2")),
        ((ANGLE, PUSH, LATER), ("external_push", "external_push.2")),
        ((LOAD, PUSH, LATER), ("external_push", "external_push.2")),
    ],
)
def test_a_second_of_a_kind_is_a_picture_of_something_else(added, lost):
    """And what was found beside the first; two carpets may be two, where nothing is left."""
    assert names(*added, left=0.05) == lost
    assert names(*added, left=0.0) == ()
    third = ExternalPush(start=20.0, duration=1.0, label="3")
    assert names(*added, third, left=0.0) == (*lost, "external_push.3")


@pytest.mark.parametrize(
    ("added", "lost"),
    [
        ((PUSH,), ("external_push",)),
        ((ROLLING, PATCH), ("floor_patch",)),
        ((PATCH, ROLLING), ("floor_patch", "rolling_resistance")),
        ((ROLLING, SLOPE), ()),
    ],
)
def test_beside_much_that_is_left_nothing_that_passes_has_a_name(added, lost):
    assert names(*added, left=MUCH + 0.05) == lost


def test_where_most_is_left_no_force_has_a_name():
    assert names(ROLLING, SLOPE, left=MOST + 0.05) == ("rolling_resistance", "floor_slope")
    assert names(ANGLE, ROLLING, left=MOST + 0.05) == ("rolling_resistance",)
    assert names(ANGLE, left=MOST + 0.05) == ()


@dataclass(frozen=True)
class Search:
    """Of a diagnosis; pushes are told whole after it, from where they begin to where they end."""

    final: Fit
    held_out: object = field(default_factory=lambda: SimpleNamespace(rolling=(None, 1.0)))
    removed: tuple = ()
    nameless: tuple = ()


@pytest.mark.parametrize(("seconds", "stays"), [(5.5, True), (9.0, False)])
def test_a_push_that_is_told_to_last_for_long_has_no_name(seconds, stays, monkeypatch):
    def proven(fitted):
        told = [replace(e, duration=seconds) if isinstance(e, ExternalPush) else e for e in fitted.added]
        return SimpleNamespace(cart=SimpleNamespace(effects=told)), ("load_slosh",) if SLOSH in fitted.added else ()

    monkeypatch.setattr(diagnosis, "proven", proven)
    monkeypatch.setattr(Fit, "without_all", lambda f, keys: Fit(tuple(e for e in f.added if e.key not in keys)), False)
    found, certainty = diagnosis._proven(Search(Fit((ROLLING, PUSH, SLOSH))))
    assert found.final.added == ((ROLLING, PUSH) if stays else (ROLLING,))
    assert found.removed == ("load_slosh", *([] if stays else ["external_push"]))
    assert found.nameless == (() if stays else ("external_push",))
    assert [e.name for e in certainty.cart.effects] == [e.name for e in found.final.added] + ["load_slosh"] * stays


def test_what_may_be_noise_is_not_left():
    class Noise(Proof):
        def gap(self, fitted):
            return 1.4

    assert stand_ins(Fit((PUSH,)), Noise(0.0)) == ()
