"""Samples that are none: refused in words before anything is changed, so that a filter goes on as if none had come."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from cartgrasp.effects import TimeDelay, ViscousDrag
from cartgrasp.errors import UsageError
from cartgrasp.inertia import Inertia
from cartgrasp.model import CartModel
from cartgrasp.motion import Measurement
from estimation import CartFilter, DisturbedFilter, FilterNoise, RegressorEstimator
from estimation.online.paper_filter import PaperFilter

from ..runs import simulate

PLANT = (24.0, 0.28, 0.06, 2.2, 3.0, 1.2, 0.0)
PLAIN = CartModel(Inertia(20.0, (0.3, 0.0), 1.8), effects=(ViscousDrag(3.0, 1.2),))
LATE = PLAIN.with_effect(TimeDelay(0.05, label="hand"))
NOISE = FilterNoise(0.0004, 0.0004, 0.005, 0.005, 1.0, 0.05)
ESTIMATORS = {
    "filter": lambda: CartFilter(PLAIN, ["hand"], noise=NOISE),
    "filter, late wrenches": lambda: CartFilter(LATE, ["hand"], noise=NOISE),
    "disturbed": lambda: DisturbedFilter(PLAIN, ["hand"], noise=NOISE),
    "disturbed, late wrenches": lambda: DisturbedFilter(LATE, ["hand"], noise=NOISE),
    "regressor": lambda: RegressorEstimator(PLAIN, ["hand"], noise=NOISE),
}
MALFORMED = {
    "pose": (np.zeros(2), [0.0, "x", 0.0], np.zeros((3, 1)), np.array([1.0])),
    "velocity": (0.5, [0.5], np.zeros(2), np.zeros(3, dtype=complex)),
    "wrenches": ({"hand": np.zeros(7)}, {"hand": None}, {"hand": ["a"] * 6}, [np.zeros(6)]),
    "contacts": ({"hand": [0.0, 0.0]}, {"hand": (1e4, 0.0, 0.0)}, {"hand": None}),
    "time": (None, "soon", np.nan, np.inf),
}


@pytest.fixture(scope="module")
def samples():
    return list(simulate(PLANT, 3, duration=3.0, noise=(0.0004, 0.005, 1.0))[0].measurements())


@pytest.mark.parametrize("which", ESTIMATORS)
def test_what_is_refused_leaves_no_trace(which, samples):
    """In time and 0.15 s late, from the first sample on: to the last bit what is told without."""
    asked, spared = ESTIMATORS[which](), ESTIMATORS[which]()
    for k, sample in enumerate(samples):
        if k % 40 == 20 or k == 0:
            for part, values in MALFORMED.items():
                for number, value in enumerate(values):
                    wrong = replace(samples[k - 15 if k and number % 2 else k], **{part: value})
                    with pytest.raises(UsageError, match=f"measurement: {part}"):
                        asked.update(wrong)
        told, expected = asked.update(sample), spared.update(sample)
    np.testing.assert_array_equal(told.model_parameters, expected.model_parameters)
    np.testing.assert_array_equal(told.motion.pose_sb, expected.motion.pose_sb)
    assert (told.health, told.time, told.suspicions) == (expected.health, expected.time, expected.suspicions)


def test_the_papers_filter_refuses_them_too(samples):
    made = PaperFilter(PLAIN, ["hand"], noise=NOISE)
    for part, values in MALFORMED.items():
        for value in values:
            with pytest.raises(UsageError, match=f"measurement: {part}"):
                made.update(replace(samples[0], **{part: value}))


@pytest.mark.parametrize("which", ESTIMATORS)
def test_numbers_of_any_kind_are_numbers(which, samples):
    """Lists, whole numbers, single precision: what is told is what floats say."""
    plain, other = ESTIMATORS[which](), ESTIMATORS[which]()
    for k, sample in enumerate(samples[:120]):
        wrenches = {"hand": np.round(sample.wrenches["hand"])}
        rounded = Measurement(sample.time, np.round(sample.pose), np.zeros(3), wrenches, {"hand": np.ones(3)})
        kinds = {
            "pose": [int(x) for x in rounded.pose],
            "velocity": (0, 0.0, 0),
            "wrenches": {"hand": wrenches["hand"].astype([int, np.float32, float][k % 3])},
            "contacts": {"hand": [1, 1.0, np.float64(1.0)]},
        }
        told, expected = other.update(replace(rounded, **kinds)), plain.update(rounded)
    np.testing.assert_array_equal(told.model_parameters, expected.model_parameters)


@pytest.mark.parametrize("which", ["filter", "disturbed", "regressor"])
@pytest.mark.parametrize("since", [0, 250])
def test_a_wrench_without_numbers_is_named_as_such(which, since, samples):
    """Not as one that has frozen."""
    made = ESTIMATORS[which]()
    for k, sample in enumerate((*samples, *(replace(one, time=one.time + 3.0) for one in samples))):
        told = made.update(replace(sample, wrenches={"hand": np.full(6, np.nan)}) if k >= since else sample)
    assert told.health == "no_wrench"
    assert [(one.kind, one.where) for one in told.suspicions] == [("missing", "hand")]
    assert told.suspicions[0].words == "hand: its wrench is NaN: the sensor, or its driver, tells no number"


def test_time_goes_on_where_no_pose_has_come(samples):
    made = ESTIMATORS["disturbed"]()
    for sample in samples[:60]:
        told = made.update(replace(sample, pose=None))
    assert told.time == samples[59].time


@pytest.mark.parametrize("which", ESTIMATORS)
def test_arrays_may_be_filled_anew(which, samples):
    """To the last bit, whether a loop makes new ones or not, with poses in time or late. Samples that waited had the
    numbers of later ones: 24 kg came out as 21 ± 1.8 with health ok, or nothing fitted."""
    fresh, used = ESTIMATORS[which](), ESTIMATORS[which]()
    pose, velocity, wrench, contact = np.zeros(3), np.zeros(3), np.zeros(6), np.zeros(3)
    for k, sample in enumerate(samples[:150]):
        old = samples[max(k - 8, 0)]
        pose[:], velocity[:] = old.pose, old.velocity
        wrench[:], contact[:] = sample.wrenches["hand"], sample.contacts["hand"]
        used.update(Measurement(old.time, pose, velocity))
        fresh.update(replace(old, wrenches={}, contacts={}))
        told = used.update(Measurement(sample.time, None, None, {"hand": wrench}, {"hand": contact}))
        expected = fresh.update(replace(sample, pose=None, velocity=None))
    np.testing.assert_array_equal(told.model_parameters, expected.model_parameters)
    np.testing.assert_array_equal(told.motion.pose_sb, expected.motion.pose_sb)
    assert (told.health, told.suspicions) == (expected.health, expected.suspicions)
