"""A wrench that is recorded late: sensors and alignment by counting, and what it does to a fit."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cartgrasp.contacts import ContactWrenches
from cartgrasp.effects import ForceBias, ForceScale, TimeDelay, ViscousDrag
from cartgrasp.inertia import Inertia
from cartgrasp.logs import ArmLog, RunLog
from cartgrasp.logs.alignment import aligned
from cartgrasp.model import CartModel
from cartgrasp.simulation.sensors import SensorNoise, Sensors
from estimation import CartFilter, FilterNoise, RegressorEstimator
from estimation.whole_log.identification import identify
from estimation.whole_log.replay import replay
from tests.core.drawn import numbers
from tests.estimation.runs import STEP, simulate

INERTIA = Inertia(24.0, (0.3, 0.0), 2.0)
NO_NOISE = SensorNoise(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
LATE = 12
"""Samples."""
DELAY = TimeDelay(LATE * STEP)


def cart(*effects):
    return CartModel(INERTIA, effects=effects)


def log_of(time, wrenches):
    arms = {name: ArmLog(np.zeros((len(time), 3)), wrench) for name, wrench in wrenches.items()}
    return RunLog(np.asarray(time), np.zeros((len(time), 3)), None, arms)


@pytest.mark.parametrize("late", [0, 1, 3, 7])
def test_sensors_record_what_was_given_that_long_ago(late):
    """By counting; the other arm's sensor is in time, and a bias is there from the first sample on."""
    model = cart(TimeDelay(late * 0.01, label="left"), ForceBias(fx=1.0, label="left"))
    sensors = Sensors(model, NO_NOISE)
    given = np.random.default_rng(late).normal(size=(40, 2, 6))
    contacts = {"left": np.zeros(3), "right": np.zeros(3)}
    seen = []
    for k, (left, right) in enumerate(given):
        felt = sensors.wrenches(0.01 * k, ContactWrenches({"left": left, "right": right}, contacts)).wrenches
        np.testing.assert_array_equal(felt["right"], right)
        seen.append(felt["left"])
    expected = np.concatenate([np.zeros((late, 6)), given[: 40 - late, 0]])
    expected[:, 0] += 1.0
    np.testing.assert_allclose(seen, expected, atol=1e-14)


def test_between_two_samples_the_older_is_held():
    sensors = Sensors(cart(TimeDelay(0.015)), NO_NOISE)
    ramp = [np.full(6, float(k)) for k in range(10)]
    seen = [
        sensors.wrenches(0.01 * k, ContactWrenches({"a": w}, {"a": np.zeros(3)})).wrenches["a"][0]
        for k, w in enumerate(ramp)
    ]
    assert seen == [0.0, 0.0, 0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]


@given(delay=numbers(0.0, 0.5), jitter=st.lists(numbers(-0.002, 0.002), min_size=20, max_size=60))
def test_each_row_takes_the_sample_that_was_felt_nearest_to_it(delay, jitter):
    """Rows hold the time at which they were felt: what comes back is within half a step of a row's own."""
    time = 0.01 * np.arange(len(jitter)) + jitter
    felt = np.tile((time - delay)[:, None], 6)
    back = aligned(log_of(time, {"a": felt}), cart(TimeDelay(delay))).arms["a"].wrench[:, 0]
    known = np.isfinite(back)
    longest = np.diff(time).max()
    inside = known & (time + delay < time[-1])
    assert np.abs(back - time)[inside].max(initial=0.0) <= longest / 2 + 1e-6
    assert known[time + delay < time[-1] - longest].all() or longest > 0.012
    assert not known[time + delay > time[-1] + longest].any()


@pytest.mark.parametrize("late", [0.005, 0.035])
def test_between_two_samples_the_earlier_is_always_taken(late):
    """Each sample once, however the clock's numbers are rounded."""
    time = 17.3 + 0.01 * np.arange(200)
    rows = np.tile(np.arange(200.0)[:, None], 6)
    back = aligned(log_of(time, {"a": rows}), cart(TimeDelay(late))).arms["a"].wrench[:, 0]
    np.testing.assert_array_equal(np.diff(back[np.isfinite(back)]), 1.0)
    assert back[0] == np.floor(late / 0.01)


@pytest.mark.parametrize("late", [1, 5])
def test_whole_steps_shift_rows_and_keep_gaps(late):
    time = 3.0 + 0.01 * np.arange(50)
    rows = np.random.default_rng(1).normal(size=(50, 6))
    rows[20] = np.nan
    back = aligned(log_of(time, {"a": rows, "b": rows}), cart(TimeDelay(late * 0.01, label="a")))
    np.testing.assert_array_equal(back.arms["a"].wrench, np.concatenate([rows[late:], np.full((late, 6), np.nan)]))
    np.testing.assert_array_equal(back.arms["b"].wrench, rows)


def test_a_log_in_time_stays_itself():
    log = log_of([0.0, 1.0], {"a": np.zeros((2, 6))})
    assert aligned(log, cart(ForceScale(1.1), TimeDelay())) is log
    one = aligned(log_of([0.0], {"a": np.zeros((1, 6))}), cart(TimeDelay(0.1)))
    assert np.isnan(one.arms["a"].wrench).all()


def late_log():
    """A run with its wrenches recorded some samples late, by shifting rows; and the run as it was, without its end."""
    log, _ = simulate((24.0, 0.3, 0.0, 2.0, 3.0, 1.0, 0.0), seed=2, duration=12.0, noise=(0.0004, 0.005, 0.5))
    hand = log.arms["hand"]
    shifted = np.concatenate([np.zeros((LATE, 6)), hand.wrench[:-LATE]])
    cut = hand.wrench.copy()
    cut[-LATE:] = np.nan
    late = replace(log, arms={"hand": ArmLog(hand.contact, shifted)})
    return late, replace(log, arms={"hand": ArmLog(hand.contact, cut)})


@pytest.mark.long
def test_identify_and_a_replay_see_the_wrenches_in_time():
    """As if they had never been late; without the effect, much is left unexplained."""
    late, in_time = late_log()
    plain = CartModel(Inertia(20.0, (0.3, 0.0), 1.8), effects=(ViscousDrag(2.0, 1.0),))
    knowing = plain.with_effect(DELAY)
    noise = FilterNoise(0.0004, 0.0004, 0.005, 0.005, 0.5, 0.025)
    found, expected = identify([late], knowing, noise=noise), identify([in_time], plain, noise=noise)
    np.testing.assert_allclose(found.model_parameters[:-1], expected.model_parameters, rtol=1e-9)
    assert found.model_parameters[-1] == LATE * STEP
    assert found.parameters["mass"].value == pytest.approx(24.0, rel=0.02)
    unaware = identify([late], plain, noise=noise)
    assert unaware.parameters["mass"].std > 5 * found.parameters["mass"].std
    assert unaware.logs[0].noise_excess > 10 * found.logs[0].noise_excess

    online = replay(late, RegressorEstimator(knowing, ["hand"], noise=noise)).last.parameters["mass"]
    same = replay(in_time, RegressorEstimator(plain, ["hand"], noise=noise)).last.parameters["mass"]
    assert online.value == pytest.approx(same.value, rel=1e-9)
    assert online.value == pytest.approx(24.0, rel=0.03)


@pytest.mark.long
def test_a_filter_waits_for_late_wrenches():
    """As if they had never been late, up to where they tell."""
    late, in_time = late_log()
    plain = CartModel(Inertia(20.0, (0.3, 0.0), 1.8), effects=(ViscousDrag(2.0, 1.0),))
    noise = FilterNoise(0.0004, 0.0004, 0.005, 0.005, 0.5, 0.025)
    knowing, other = (CartFilter(cart, ["hand"], noise=noise) for cart in (plain.with_effect(DELAY), plain))
    online = replay(late, knowing).last.parameters["mass"]
    for measurement in list(in_time.measurements())[:-LATE]:
        same = other.update(measurement).parameters["mass"]
    assert online.value == pytest.approx(same.value, rel=1e-6)
    assert online.value == pytest.approx(24.0, rel=0.03)
