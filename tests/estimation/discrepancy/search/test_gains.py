"""What differs surely, by how it acts."""

from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.signal import lfilter

from cartgrasp.effects.effect import Gate
from estimation.discrepancy.search.gains import CONFUSABLE_NATS, GAIN_SIGMAS, MIN_GAIN_NATS, margin
from estimation.discrepancy.search.model import LONG_MEAN_INTERVAL, MIN_LONG_MEANS, Model

gains = st.lists(st.floats(-50.0, 50.0), min_size=3, max_size=12)


@given(gains)
def test_what_happens_once_is_told_by_no_other_stretch(gains):
    """All else is, and what acts at a time or place has to be worth a name besides."""
    less, more = (SimpleNamespace(score=SimpleNamespace(stretches=np.array(g))) for g in ([0.0] * len(gains), gains))
    by_chance = GAIN_SIGMAS * len(gains) ** 0.5 * np.std(gains)
    assert margin(less, more, Gate.ALWAYS) == pytest.approx(max(CONFUSABLE_NATS, by_chance))
    assert margin(less, more, Gate.WHILE, Gate.ALWAYS) == MIN_GAIN_NATS
    for gate in (Gate.INSIDE, Gate.FROM):
        assert margin(less, more, Gate.ALWAYS, gate) == pytest.approx(max(MIN_GAIN_NATS, by_chance))


@pytest.mark.parametrize("duration", [7.0, 60.0])
@pytest.mark.parametrize("memory", [0.0, 0.6])
def test_the_colour_of_what_is_left_is_that_of_a_first_order_process(memory, duration):
    """In closed form: the variance of means over that of the same means, were rows independent; a short log's means
    are shorter."""
    step, found = 0.1, []
    for seed in range(40):
        white = np.random.default_rng(seed).standard_normal(round(duration / step))
        left = lfilter([(1.0 - memory**2) ** 0.5], [1.0, -memory], white)
        one_log = SimpleNamespace(
            logs=[SimpleNamespace(row_step=step)], cart=SimpleNamespace(constraints=SimpleNamespace(n_free=1))
        )
        score = SimpleNamespace(fit=np.zeros(0), scale=1.0)
        found.append(Model.variance_inflation_beside(one_log, left[:, None, None], score))
    m = min(LONG_MEAN_INTERVAL, duration / MIN_LONG_MEANS) / step
    closed = (1.0 + memory) / (1.0 - memory) - 2.0 * memory * (1.0 - memory**m) / (m * (1.0 - memory) ** 2)
    assert min(found) >= 1.0  # white rows are never taken for whiter
    assert np.median(found) == pytest.approx(closed, rel=0.25, abs=0.4)
