"""A wrench that is recorded late: sensors against a list, alignment against a line, and what it does to a fit."""

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
from estimation import CartFilter, FilterNoise
from estimation.batch import identify
from estimation.replay import replay
from tests.core.drawn import numbers
from tests.estimation.runs import STEP, simulate

INERTIA = Inertia(24.0, (0.3, 0.0), 2.0)
LATE = 12
"""Samples."""


def cart(*effects):
    return CartModel(INERTIA, effects=effects)


def log_of(time, wrenches):
    arms = {name: ArmLog(np.zeros((len(time), 3)), wrench) for name, wrench in wrenches.items()}
    return RunLog(np.asarray(time), np.zeros((len(time), 3)), None, arms)


@pytest.mark.parametrize("late", [0, 1, 3, 7])
def test_sensors_record_what_was_given_that_long_ago(late):
    """By counting; the other arm's sensor is in time, and a bias is there from the first sample on."""
    model = cart(TimeDelay(late * 0.01, label="left"), ForceBias(fx=1.0, label="left"))
    sensors = Sensors(model, SensorNoise.quiet())
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
    sensors = Sensors(cart(TimeDelay(0.015)), SensorNoise.quiet())
    ramp = [np.full(6, float(k)) for k in range(10)]
    seen = [
        sensors.wrenches(0.01 * k, ContactWrenches({"a": w}, {"a": np.zeros(3)})).wrenches["a"][0]
        for k, w in enumerate(ramp)
    ]
    assert seen == [0.0, 0.0, 0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]


@given(delay=numbers(0.0, 0.5), steps=st.lists(numbers(0.001, 0.1), min_size=2, max_size=30))
def test_a_line_comes_back_as_it_was(delay, steps):
    """Recorded late by `delay`, `a + b t` is `a + b (t - delay)`; linear between rows, it comes back exactly."""
    time = np.cumsum(steps)
    slope, start = np.arange(6.0) - 2.0, np.linspace(-3.0, 3.0, 6)
    log = log_of(time, {"a": start + slope * (time - delay)[:, None]})
    back = aligned(log, cart(TimeDelay(delay))).arms["a"].wrench
    known = time + delay < time[-1] - 1e-6
    np.testing.assert_allclose(back[known], (start + slope * time[:, None])[known], atol=1e-9)
    assert np.isnan(back[time + delay > time[-1] + 1e-6]).all()


@pytest.mark.parametrize("late", [1, 5])
def test_whole_steps_shift_rows_and_keep_gaps(late):
    time = 3.0 + 0.01 * np.arange(50)
    rows = np.random.default_rng(1).normal(size=(50, 6))
    rows[20] = np.nan
    back = aligned(log_of(time, {"a": rows, "b": rows}), cart(TimeDelay(late * 0.01, label="a")))
    np.testing.assert_array_equal(back.arms["a"].wrench, np.concatenate([rows[late:], np.full((late, 6), np.nan)]))
    np.testing.assert_array_equal(back.arms["b"].wrench, rows)
    between = aligned(log_of(time, {"a": rows}), cart(TimeDelay(0.005))).arms["a"].wrench
    assert np.isnan(between).all(axis=1).nonzero()[0].tolist() == [19, 20, 49]


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


def test_a_batch_fit_and_a_replay_see_the_wrenches_in_time():
    """As if they had never been late; without the effect, much is left unexplained."""
    late, in_time = late_log()
    plain = CartModel(Inertia(20.0, (0.3, 0.0), 1.8), effects=(ViscousDrag(2.0, 1.0),))
    knowing = plain.with_effect(TimeDelay(LATE * STEP))
    noise = FilterNoise(0.0004, 0.0004, 0.005, 0.005, 0.5, 0.025)
    found, expected = identify([late], knowing, noise=noise), identify([in_time], plain, noise=noise)
    np.testing.assert_allclose(found.model_parameters[:-1], expected.model_parameters, rtol=1e-9)
    assert found.model_parameters[-1] == LATE * STEP
    assert found.parameters["mass"].value == pytest.approx(24.0, rel=0.02)
    unaware = identify([late], plain, noise=noise)
    assert unaware.parameters["mass"].std > 5 * found.parameters["mass"].std
    assert unaware.logs[0].noise_excess > 10 * found.logs[0].noise_excess

    online = replay(late, CartFilter(knowing, ["hand"], noise=noise)).last.parameters["mass"]
    same = replay(in_time, CartFilter(plain, ["hand"], noise=noise)).last.parameters["mass"]
    assert online.value == pytest.approx(same.value, rel=1e-9)
    assert online.value == pytest.approx(24.0, rel=0.03)
