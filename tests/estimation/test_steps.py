"""A step of the search: what it tells as alike, and whose chi-squared can be compared."""

import pytest

from cartgrasp.effects import ForceBias, ForceMisalignment, ForceScale, LoadSlosh, TimeDelay
from estimation.discrepancy.isolability import Isolability
from estimation.discrepancy.selection import IMPLAUSIBLE, Attempt, Step, _is_late, _keeps_noise


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
    told = step.beside({"rolling_resistance": Isolability(9.0, alike)})
    assert told.confusable == ("stribeck_friction", "floor_slope")
    assert step.beside({}) is step


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
