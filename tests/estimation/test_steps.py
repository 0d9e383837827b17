"""A step of the search: what it tells as alike, and whose chi-squared can be compared."""

from types import SimpleNamespace

import pytest

from cartgrasp.effects import (
    ExternalPush,
    FloorPatch,
    ForceBias,
    ForceMisalignment,
    ForceScale,
    LoadSlosh,
    QuadraticDrag,
    TimeDelay,
)
from estimation.discrepancy.diagnosis import Diagnosis
from estimation.discrepancy.isolability import Isolability
from estimation.discrepancy.judgement import ADDED, UNSTEADY, Verdict
from estimation.discrepancy.selection import IMPLAUSIBLE, Attempt, Step, _is_late, _judged, _keeps_noise, _Look, _Search


def attempt(name, log_factor, verdict="less probable than another"):
    return Attempt(name, name, log_factor, None, verdict)


def test_what_looks_alike_on_a_motion_and_explains_nearly_as_much_is_told():
    """Beside what is told already; not what explains far less, looks other, or can't be."""
    added = attempt("rolling_resistance", 400.0, "added")
    others = (
        attempt("floor_slope", 390.0),
        attempt("force_bias", 250.0),
        attempt("load_slosh", 380.0),
        attempt("wheel_drag_imbalance", 395.0, IMPLAUSIBLE),
    )
    alike = ("floor_slope", "force_bias", "wheel_drag_imbalance")
    step = Step((added, *others), added, ("stribeck_friction",), 0.9)
    told = step.beside({"rolling_resistance": Isolability(9.0, dict.fromkeys(alike, 0.96))})
    assert told.confusable == ("stribeck_friction", "floor_slope")
    assert step.beside({}) is step


PUSH = ExternalPush(start=9.0, duration=0.5, force=20.0)
PATCH, SLOSH, DRAG = FloorPatch(x_max=1.0, y_max=1.0, coefficient=0.03), LoadSlosh(mass=3.0), QuadraticDrag(5.0)
NOT_PROVEN = Verdict(False, "closes 0.0 %", 0.0, is_unproven=True)


@pytest.mark.parametrize(
    ("first", "verdict", "second", "is_added"),
    [
        (SLOSH, NOT_PROVEN, PUSH, False),
        (SLOSH, NOT_PROVEN, DRAG, True),
        (PATCH, NOT_PROVEN, PUSH, True),
        (SLOSH, Verdict(False, UNSTEADY, is_nameless=True), DRAG, False),
        (SLOSH, Verdict(False, "not plausible"), PUSH, True),
    ],
)
def test_what_explains_less(first, verdict, second, is_added):
    """Of a thing without a name it is no better one; an accident is none of what lasts, if that is only not proven."""
    verdicts = {first.key: verdict, second.key: Verdict(True, ADDED, 0.5)}
    judge = SimpleNamespace(verdict=lambda found, score, model: verdicts[found], implausible=lambda effect: "")
    model = SimpleNamespace(settled=lambda: "settled")
    scored = [(90.0, first, model), (70.0, second, model)]
    attempts, better, nameless = _judged(scored, {key: key for key in verdicts}, judge)
    assert (better == "settled") is is_added
    assert (attempts[1].verdict == ADDED) is is_added
    assert attempts[0].is_there is (verdict.is_unproven or verdict.is_nameless)
    assert nameless is (model if verdict.is_nameless else None)


@pytest.mark.parametrize(
    ("second", "then", "is_found"),
    [(400.0, "floor_slope", True), (99.0, "floor_slope", False), (400.0, "load_slosh", False), (None, "", False)],
)
def test_what_is_unsteady_alone_is_named_beside_another(second, then, is_found):
    """Where that explains a tenth of it at least, and it is then what is added beside that."""

    def model(*keys):
        added = tuple(SimpleNamespace(key=key) for key in keys)
        return SimpleNamespace(added=added, settled=lambda: model(*keys), tried=lambda one: model(*keys, one.key))

    def look(fitted, name, log_factor, better=None, nameless=None):
        added = None if name is None else attempt(name, log_factor, "added")
        unnamed = attempt("floor_slope", 1000.0, UNSTEADY)
        return _Look(SimpleNamespace(fitted=fitted), None, Step((unnamed,), added), better, nameless)

    first = look(model(), None, 0.0, nameless=model("floor_slope"))
    beside = model("floor_slope", "force_bias") if second else None
    answers = iter([look(model(), second and "force_bias", second, beside), look(model(), then, 900.0)])
    search = SimpleNamespace(look=lambda fitted, strongest: next(answers), tell=lambda what: None)
    found = _Search.beside_another(search, first, 0.0)
    assert (found is not None) is is_found
    if is_found:
        assert [one.key for one in found.better.added] == ["force_bias"]
        assert found.step.added.name == "force_bias"


@pytest.mark.parametrize(
    ("log_factor", "is_there", "disagrees"), [(60, True, True), (40, True, False), (60, False, False)]
)
def test_what_is_there_without_a_name_disagrees(log_factor, is_there, disagrees):
    step = Step((Attempt("load_slosh", "load_slosh", log_factor, None, UNSTEADY, is_there),), None)
    found = SimpleNamespace(
        effects=(),
        remaining=(),
        _is_left=True,
        gap=SimpleNamespace(refitted=0.01, noise_floor=0.02),
        selection=SimpleNamespace(steps=(step,), nameless=()),
    )
    assert Diagnosis.disagrees.fget(found) is disagrees


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
    gap = SimpleNamespace(refitted=0.1, after=after, noise_floor=floor)
    found = SimpleNamespace(disagrees=True, effects=("one",), gap=gap, _much_remains=False)
    assert Diagnosis.verdict.fget(found) == verdict


@pytest.mark.parametrize(
    ("effect", "keeps"),
    [
        (LoadSlosh(mass=3.0), True),
        (ForceBias(fx=3.0), True),
        (TimeDelay(delay=0.02), True),
        (ForceMisalignment(angle=0.3), True),
        (ForceScale(gain=1.2), False),
    ],
)
def test_one_that_divides_wrenches_divides_their_noise(effect, keeps):
    assert _keeps_noise(effect) is keeps
    assert _is_late(effect) is isinstance(effect, TimeDelay)
