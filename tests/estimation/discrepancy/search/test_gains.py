"""What differs surely, by how it acts."""

from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cartgrasp.effects.effect import Gate
from estimation.discrepancy.search.gains import CONFUSABLE, SURE, WORTH, margin

gains = st.lists(st.floats(-50.0, 50.0), min_size=3, max_size=12)


@given(gains)
def test_what_happens_once_is_told_by_no_other_stretch(gains):
    """All else is, and what acts at a time or place has to be worth a name besides."""
    less, more = (SimpleNamespace(score=SimpleNamespace(stretches=np.array(g))) for g in ([0.0] * len(gains), gains))
    by_chance = SURE * len(gains) ** 0.5 * np.std(gains)
    assert margin(less, more, Gate.ALWAYS) == pytest.approx(max(CONFUSABLE, by_chance))
    assert margin(less, more, Gate.WHILE, Gate.ALWAYS) == WORTH
    for gate in (Gate.INSIDE, Gate.FROM):
        assert margin(less, more, Gate.ALWAYS, gate) == pytest.approx(max(WORTH, by_chance))
