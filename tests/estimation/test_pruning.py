"""What later effects have made superfluous goes, of two of which either would do the later one; and what does harm."""

from dataclasses import dataclass, field, replace
from types import SimpleNamespace

import pytest

from cartgrasp.effects import (
    ExternalPush,
    FloorSlope,
    LoadSlosh,
    RollingResistance,
    StribeckFriction,
    WheelDragImbalance,
)
from cartgrasp.wheels import Wheel, WheelSet
from estimation.discrepancy.held_out import Gain
from estimation.discrepancy.pruning import pruned, still_plausible
from estimation.discrepancy.selection import Attempt, Step

WHEELS = WheelSet.of((Wheel("fixed", 0.0, 0.25), Wheel("fixed", 0.0, -0.25)), rolls_along_x=True)
SLOSH, ROLLING, STRIBECK = LoadSlosh(mass=3.0), RollingResistance(coefficient=0.02), StribeckFriction(breakaway=3.0)


@dataclass(frozen=True)
class Fit:
    """Of effects, with the chi-squared that is left by names of those that are there."""

    added: tuple
    left: dict
    excess: float = 1.0

    def without(self, key):
        return Fit(tuple(e for e in self.added if e.key != key), self.left)

    def chi_squared(self, keys=()):
        return self.left[tuple(e.name for e in self.added)]


def left_of(fitted, proof):
    """What is left, and the keys of what is not."""
    left, _ = pruned(fitted, proof)
    return left, tuple(e.key for e in fitted.added if e.key not in {one.key for one in left.added})


class Proof:
    """Nothing is gained on rollouts; likelihoods are those of all rows."""

    def gain(self, fitted, better):
        return Gain(0.0, 0.0, 0.0)

    def likelihood(self, fitted, better):
        return 0.5 * (fitted.chi_squared() - better.chi_squared())

    def gap(self, fitted):
        return 0.02

    def without(self, fitted, key):
        return fitted.without(key)


class Rollouts(Proof):
    """With gaps (m) by names of effects."""

    def __init__(self, gaps):
        self.gaps = gaps

    def gap(self, fitted):
        return self.gaps[tuple(e.name for e in fitted.added)]


@pytest.mark.parametrize(("without_stribeck", "gone"), [(102.0, "stribeck_friction"), (300.0, "rolling_resistance")])
def test_of_two_of_which_either_would_do_the_earlier_stays(without_stribeck, gone):
    left = {
        ("rolling_resistance", "stribeck_friction"): 100.0,
        ("stribeck_friction",): 101.0,
        ("rolling_resistance",): without_stribeck,
        (): 1000.0,
    }
    fitted, removed = left_of(Fit((ROLLING, STRIBECK), left), Proof())
    assert removed == (gone,)
    assert [e.name for e in fitted.added] == [
        name for name in ("rolling_resistance", "stribeck_friction") if name != gone
    ]


@pytest.mark.parametrize(("rolling_alone", "near"), [(300.0, True), (440.0, False)])
def test_what_would_do_nearly_as_well_is_told_though_it_went(rolling_alone, near):
    """Chi-squared of 1000 without either, and of 101 with the one that stays."""
    left = {
        ("load_slosh", "rolling_resistance", "stribeck_friction"): 100.0,
        ("load_slosh", "stribeck_friction"): 101.0,
        ("load_slosh", "rolling_resistance"): rolling_alone,
        ("rolling_resistance", "stribeck_friction"): 600.0,
        ("load_slosh",): 1000.0,
        ("stribeck_friction",): 600.0,
    }
    fitted, replaced = pruned(Fit((SLOSH, ROLLING, STRIBECK), left), Proof())
    assert [effect.name for effect in fitted.added] == ["load_slosh", "stribeck_friction"]
    assert replaced == [("stribeck_friction", "rolling_resistance")] * near
    step = Step((), Attempt("stribeck_friction", "stribeck_friction", 400.0, None, "added"), ("floor_slope",))
    assert step.instead_of(replaced).confusable == ("floor_slope", *["rolling_resistance"] * near)
    assert step.instead_of([("load_slosh", "rolling_resistance")]).confusable == ("floor_slope",)
    assert step.instead_of([("stribeck_friction", "stribeck_friction")]).confusable == ("floor_slope",)


def test_what_is_needed_stays():
    left = {
        ("load_slosh", "rolling_resistance"): 100.0,
        ("rolling_resistance",): 150.0,
        ("load_slosh",): 140.0,
    }
    fitted, removed = left_of(Fit((SLOSH, ROLLING), left), Proof())
    assert not removed
    assert len(fitted.added) == 2


@pytest.mark.parametrize(("gap", "gone"), [(0.021, ()), (0.023, ("rolling_resistance",))])
def test_what_takes_simulations_away_from_the_log_goes(gap, gone):
    """However well it fits the wrenches; what the same rollouts say within a tenth is nothing against it."""
    left = {("load_slosh", "rolling_resistance"): 100.0, ("rolling_resistance",): 190.0, ("load_slosh",): 190.0}
    gaps = {("load_slosh", "rolling_resistance"): gap, ("load_slosh",): 0.02, ("rolling_resistance",): 0.03, (): 0.04}
    fitted, removed = left_of(Fit((SLOSH, ROLLING), left), Rollouts(gaps))
    assert removed == gone
    assert len(fitted.added) == 2 - len(gone)


def test_a_push_is_not_judged_by_what_it_does_elsewhere():
    push = ExternalPush(start=1.0, duration=1.0, force=5.0)
    fitted, removed = left_of(Fit((push,), {}), Rollouts({("external_push",): 0.05, (): 0.02}))
    assert fitted.added == (push,)
    assert not removed


@dataclass(frozen=True)
class Refit(Fit):
    """With values of effects beside all others, by their names."""

    values: dict = field(default_factory=dict)

    @property
    def cart(self):
        return SimpleNamespace(effects=tuple(self.values.get(e.name, e) for e in self.added))

    def without(self, key):
        return replace(self, added=tuple(e for e in self.added if e.key != key))


@pytest.mark.parametrize(("moment", "stays"), [(-2.0, True), (-0.4, False)])
@pytest.mark.parametrize("last", [False, True])
def test_what_stood_for_a_later_effect_too_goes(moment, stays, last):
    """A wheel that drags with a lever of 0.2 m alone, and of 0.04 m beside a slope: both wheels drag alike. Of the last
    one the judge has just said what he thinks."""
    wheel, slope = WheelDragImbalance(force=10.0, moment=-2.0), FloorSlope(grade_x=0.01)
    judge = SimpleNamespace(implausible=lambda effect: effect.implausible(WHEELS, 0.8))
    added = (slope, wheel) if last else (wheel, slope)
    fitted = Refit(added, {}, values={"wheel_drag_imbalance": replace(wheel, moment=moment)})
    kept = still_plausible(fitted, judge)
    assert [e.name for e in kept.added] == [e.name for e in added if stays or last or e is slope]
