"""Arms and contacts refuse what can't be meant, and say which arm, what and why."""

from __future__ import annotations

import numpy as np
import pytest

from cartgrasp.arms import Arm, Friction
from cartgrasp.contacts import ContactSet, ContactWrenches, Segment
from cartgrasp.errors import UsageError

POINT = (-0.25, 0.2, 1.0)
HANDLE = (POINT, (-0.25, -0.2, 1.0))


def test_an_arm_keeps_what_it_is_given():
    arm = Arm("left", [POINT], yaw=0.3, force_limit=(60, 60, 40), moment_limit=(8, 8, 6), friction=Friction(0.6))
    np.testing.assert_array_equal(arm.wrench_limit, [60, 60, 40, 8, 8, 6])
    np.testing.assert_array_equal(arm.contacts.first, POINT)
    assert arm.weights == (1, 1, 1, 10, 10, 10)
    assert np.isinf(Arm("right", [POINT]).wrench_limit).all()
    assert Arm("left", [POINT]) == Arm("left", ContactSet((POINT,)))


def test_a_handle_is_held_in_its_middle_first():
    arm = Arm("left", segment=HANDLE)
    np.testing.assert_allclose(arm.contacts.first, [-0.25, 0.0, 1.0])
    np.testing.assert_allclose(arm.contacts.segments[0].at(0.25), [-0.25, 0.1, 1.0])
    assert Arm("left", [POINT], segment=HANDLE).contacts == ContactSet((POINT,), (Segment(*HANDLE),))


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: Arm("", [POINT]), "name '' must be a word"),
        (lambda: Arm("a.b", [POINT]), "name 'a.b' must be a word without a dot"),
        (lambda: Arm("a:b", [POINT]), "name 'a:b'"),
        (lambda: Arm("left"), "contacts: none given"),
        (lambda: Arm("left", [(0, 0)]), "arm left: contacts: .*; 3 numbers are needed, 2 given"),
        (lambda: Arm("left", [(0, 0, np.nan)]), "arm left: contacts: .* nan is not a number"),
        (lambda: Arm("left", [(0, 0, np.inf)]), "contacts: .* inf is not a number from -50 to 50"),
        (lambda: Arm("left", [("here", 0, 0)]), "arm left: contacts: .*here.* is not "),
        (lambda: Arm("left", [0.0, 0.0, 0.0]), "arm left: contacts: .* is one point; a list"),
        (lambda: Arm("left", segment=(POINT,)), "arm left: segment: 2 ends are needed, 1 given"),
        (lambda: Arm("left", segment=(POINT, POINT, POINT)), "arm left: segment: 2 ends are needed, 3 given"),
        (lambda: Arm("left", ContactSet((POINT,)), segment=HANDLE), "arm left: segment: .*ContactSet"),
        (lambda: Arm("left", [POINT], yaw=np.nan), "arm left: yaw: nan is not a number"),
        (
            lambda: Arm("left", [POINT], force_limit=(1, 2)),
            "arm left: force_limit: .*; 3 numbers are needed, 2 given",
        ),
        (lambda: Arm("left", [POINT], force_limit=(1, 2, -3)), "arm left: force_limit: .* -3 is not a number >= 0"),
        (
            lambda: Arm("left", [POINT], moment_limit=(1, np.nan, 3)),
            "arm left: moment_limit: .* nan is not",
        ),
        (lambda: Arm("left", [POINT], weights=(1,) * 5), "arm left: weights: .*; 6 numbers are needed, 5 given"),
        (lambda: Arm("left", [POINT], weights=(1, 1, 1, 1, 1, -1)), "arm left: weights: .* -1 is not a number from 0"),
        (
            lambda: Arm("left", [POINT], weights=(1, 1, 1, 1, 1, np.inf)),
            "arm left: weights: .* inf is not",
        ),
        (lambda: Arm("left", [(0, 0, 1e7)]), "contacts: .* from -50 to 50"),
        (lambda: Arm("left", [POINT], force_limit=(1, 2, 1e300)), "arm left: force_limit: .* beyond 1e\\+12"),
        (lambda: Arm("left", [POINT], payload=1e300), "arm left: payload: .*1e\\+300"),
        (lambda: Friction(1e300), "friction: mu: 1e\\+300"),
        (lambda: Friction(-0.1), "friction: mu: -0.1 is not a number from 0 to 100"),
        (lambda: Friction(np.nan), "friction: mu: nan"),
        (lambda: Friction(0.5, 2), "friction: sides: 2 is neither a whole number of 3 to 256"),
        (lambda: Friction(0.5, 4.0), "friction: sides: 4.0 is neither"),
        (lambda: Friction(0.5, "round"), "friction: sides: 'round' is neither"),
        (lambda: ContactSet(((0.0, np.nan, 0.0),)), "contacts: .* nan is not a number"),
        (lambda: ContactWrenches({"left": np.zeros(6)}, {"right": np.zeros(3)}), "name the same arms"),
    ],
)
def test_what_cannot_be_meant_is_refused(call, words):
    with pytest.raises(UsageError, match=words):
        call()
