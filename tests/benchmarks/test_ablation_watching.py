"""Numbers that carry along what they would have been: what is not noticed makes no difference, by working it out."""

from __future__ import annotations

import math
import operator

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from benchmarks.ablation.every import CONSTANTS
from benchmarks.ablation.watching import Watched, is_watched, noticed
from estimation.discrepancy.search import gains, plausibility

KEYS = (("a", "off"), ("a", "1.3"), ("b", "off"))
NUMBERS = st.floats(-5, 5).map(lambda x: round(x, 2) + 0.0) | st.sampled_from([0.0, 1.0, math.inf])
ARRAY = np.array([-2.0, 0.5, 1.0, 4.0])

USES = {
    "chosen": lambda a, b: max(a, b, 1.0) if a < 2.0 else min(b, 0.5),
    "scaled": lambda a, b: float(np.float64(2.0) * a + b / 4.0 - 1.0),
    "array": lambda a, b: (a < ARRAY).sum() + bool((b * ARRAY <= 1.0).any()),
    "list": lambda a, b: float(np.array([a, b, 1.0], dtype=float)[0]),
    "table": lambda a, b: [k for k, v in {"x": a, "y": b}.items() if 1.5 * v < 3.0],
    "index": lambda a, b: "abcdefghijklmnop"[round(min(abs(a), 7.0) + 0.0 * (b == b))],
    "rows": lambda a, b: ARRAY[: max(round(a if abs(a) < 9 else 9.0), 1)].tolist(),
    "math": lambda a, b: math.copysign(1.0, a) if b else 0.0,
    "text": lambda a, b: f"{a:.1f}" if not b > 0 else "",
    "sorted": lambda a, b: sorted([3.0, 1.0, a, b]).index(3.0),
    "ufunc": lambda a, b: bool(np.hypot(a, 1.0) > 2.0) + bool(np.maximum(a, b) > 0.0),
    "reduced": lambda a, b: float(np.add.reduce([a, b])),
    "unused": lambda a, b: 7,
}


@pytest.mark.filterwarnings("ignore:invalid value:RuntimeWarning")
@pytest.mark.parametrize("use", USES.values(), ids=USES)
@given(a=NUMBERS, b=NUMBERS, others=st.tuples(NUMBERS, NUMBERS, NUMBERS))
def test_what_is_not_noticed_makes_no_difference(use, a, b, others):
    found = set()
    values = dict(zip(KEYS, others, strict=True))
    first = Watched(a, {key: values[key] for key in KEYS[:2]}, found)
    second = Watched(b, {key: values[key] for key in KEYS[2:]}, found)
    told = use(first, second)
    told = told.left() if isinstance(told, Watched) else told
    assert same(told, use(a, b))
    for key in set(KEYS) - found:
        moved = use(values[key] if key[0] == "a" else a, values[key] if key[0] == "b" else b)
        assert same(moved, told), key


def same(one, other):
    return np.array_equal(one, other) or (one != one and other != other)


@pytest.mark.parametrize("compare", [operator.lt, operator.le, operator.gt, operator.ge])
@pytest.mark.parametrize("other", [3.0, np.float64(3.0), 3])
def test_only_what_decides_otherwise_is_noticed(compare, other):
    """From both sides, with numbers of Python's and of numpy's."""
    for turned in (False, True):
        found = set()
        watched = Watched(2.0, {("a", "0.7"): 1.4, ("a", "2"): 4.0}, found)
        said = compare(other, watched) if turned else compare(watched, other)
        assert type(said) is bool
        assert said == (compare(other, 2.0) if turned else compare(2.0, other))
        assert found == {("a", "2")}


def test_constants_are_watched_together_and_for_a_while():
    """A gain of 14 is above WORTH (10 or so) and times 1.3, and above a tenth of the least size of an effect."""
    known = {c.full_name: c for c in CONSTANTS}
    constants = [
        known[name]
        for name in (
            "gains.MIN_GAIN_NATS",
            "plausibility.MIN_SETTINGS[time_delay.delay]",
            "candidates.DRAGS_TOLD_BY_TURNING",
        )
    ]
    before = gains.MIN_GAIN_NATS, dict(plausibility.MIN_SETTINGS)
    delay = before[1]["time_delay.delay"]

    def diagnosed():
        return 1.2 * before[0] > gains.MIN_GAIN_NATS, 0.9 * delay < plausibility.MIN_SETTINGS["time_delay.delay"]

    said, found = noticed(diagnosed, constants, ("off", "0.7", "1.3"))
    assert said == (True, True)
    assert found == {
        ("gains.MIN_GAIN_NATS", "1.3"),
        ("plausibility.MIN_SETTINGS[time_delay.delay]", "off"),
        ("plausibility.MIN_SETTINGS[time_delay.delay]", "0.7"),
        ("candidates.DRAGS_TOLD_BY_TURNING", "off"),  # names are not watched
    }
    assert (gains.MIN_GAIN_NATS, dict(plausibility.MIN_SETTINGS)) == before
    assert [is_watched(c) for c in constants] == [True, True, False]
