"""How loud wrenches are, by rows drawn at a known loudness, and by a cart whose force sensors' noise remembers."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.sealed.sensors import noise
from cartgrasp.logs import ArmLog
from cartgrasp.studies.consistency import PRIOR, drawn_cart, exact_noise
from cartgrasp.studies.estimators import CONTROL_PERIOD, HANDS, Job, drive_cart, guess
from estimation import CartFilter
from estimation.online.regressor.regression_belief import Innovation
from estimation.online.regressor.wrench_noise_scale import NOISE_VARIANCE_FACTORS, WrenchNoiseScale

ELSE = np.array([[0.02, 0.001], [0.001, 0.004]])
WHITE = np.diag([0.5, 0.06])
"""What noise of the motion, and wrenches of white noise, do to a row."""
FORCE, MOMENT = 3.0, 0.2
HELD_BY = 0.047
"""s."""


def told(rows):
    """Of rows (k, 2), each of which counts on what the ones before told."""
    loudness = WrenchNoiseScale()
    for row in rows:
        spread = ELSE + loudness.variance_factor * WHITE
        loudness = loudness.after(
            Innovation(
                0.0, np.zeros(0), np.zeros((0, 0)), np.zeros((0, 0)), *(own := (row, 4.0 * spread, spread)), own, WHITE
            )
        )
    return loudness.variance_factor


def drawn(seed, loudness, n=300):
    return np.random.default_rng(seed).multivariate_normal(np.zeros(2), ELSE + loudness * WHITE, n)


@settings(max_examples=30, deadline=None)
@given(loudness=st.floats(1.0, NOISE_VARIANCE_FACTORS[-1]), seed=st.integers(0, 2**32 - 1))
def test_it_finds_how_loud_rows_are_drawn(loudness, seed):
    """Levels are a factor of two apart, and louder ones are rarer."""
    assert loudness / 2.2 < told(drawn(seed, loudness)) < 1.8 * loudness


@settings(max_examples=15, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), size=st.floats(1.0, 6.0), period=st.floats(60.0, 200.0))
def test_what_goes_on_pulling_the_same_way_is_no_noise(seed, size, period):
    """A slow wave of up to six deviations: by the rows' own squares it would be as loud as their mean square."""
    slow = size * np.sqrt(np.diag(ELSE + WHITE)) * np.sin(2.0 * np.pi * np.arange(300) / period)[:, None]
    assert told(drawn(seed, 1.0) + slow) < 1.5


@settings(max_examples=15, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), size=st.floats(5.0, 1e4))
def test_a_second_of_outliers_in_half_a_minute_is_no_noise(seed, size):
    rows = drawn(seed, 1.0)
    rows[200:210] += size * np.sqrt(np.diag(WHITE))
    assert told(rows) < 2.1


@settings(max_examples=15, deadline=None)
@given(
    value=st.sampled_from([np.nan, np.inf, -np.inf, 1e300]), spread=st.sampled_from([0.0, np.nan, np.inf, 1e300, -1.0])
)
def test_rows_beyond_numbers_tell_nothing(value, spread):
    """A singular one among them."""
    loudness, known = WrenchNoiseScale(), ELSE + WHITE
    sound = Innovation(
        0.0, np.zeros(0), np.zeros((0, 0)), np.zeros((0, 0)), *(own := (np.zeros(2), known, known)), own, WHITE
    )
    full = np.full((2, 2), spread)
    strange = Innovation(
        np.nan,
        np.zeros(0),
        np.zeros((0, 0)),
        np.zeros((0, 0)),
        *(own := (np.array([value, 0.1]), full, full)),
        own,
        full,
    )
    with np.errstate(all="ignore"):
        for row in 4 * [sound] + 4 * [strange] + 4 * [sound]:
            loudness = loudness.after(row)
    assert np.isfinite(loudness.log_likelihoods).all()
    assert loudness.variance_factor == 1.0


@pytest.fixture(scope="module")
def remembered():
    """A drive with forces that nearly are exact, and the noise to be added to them, by arm."""
    driven = drive_cart(drawn_cart(7), Job("curves", "quiet", 7))
    random, size, time = np.random.default_rng(7), np.repeat([FORCE, MOMENT], 3), driven.log.time
    return driven, {
        name: size * noise(arm.wrench.shape, time, HELD_BY, random) for name, arm in driven.log.arms.items()
    }


def test_a_sound_cart_whose_forces_have_a_memory_is_sound(remembered):
    """Sums of such noise have `coth(dt / 2 t)` times the variance of white noise, which is 9.4."""
    driven, beside = remembered
    declared = replace(exact_noise("quiet"), force=FORCE, moment=MOMENT)
    arms = {name: ArmLog(arm.contact, arm.wrench + beside[name]) for name, arm in driven.log.arms.items()}
    online = CartFilter(guess(), list(HANDS), noise=declared, prior=PRIOR)
    found = [online.update(one) for one in replace(driven.log, arms=arms).measurements()]
    (said,) = found[-1].suspicions
    assert (said.kind, said.where) == ("noise", "wrench")
    assert 3.0 < said.factor**2 < 1.5 / np.tanh(CONTROL_PERIOD / (2.0 * HELD_BY))
    later = [one for one in found if one.time > 5.0]
    assert np.mean([one.health == "ok" for one in later]) > 0.9
    mass = found[-1].parameters["mass"]
    assert abs(mass.value - drawn_cart(7).inertia.mass) < 3.0 * mass.std
