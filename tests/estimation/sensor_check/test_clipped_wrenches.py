"""Force sensors that are pushed beyond their range, and those that only seem to."""

from dataclasses import replace

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from cartgrasp.logs import ArmLog
from estimation.sensor_check.check import corrected_log
from estimation.sensor_check.stuck_wrenches import CLIP_MARGIN_INTERVAL, clipped_arm, range_limits, without_clipped
from estimation.whole_log.identification import identify

from .logs import CART, cart_of, two_hands
from .test_frozen_wrenches import ROWS, TIME, wrench


@given(seed=st.integers(0, 99), low=st.floats(-4.5, -2.0), high=st.floats(2.0, 4.5), which=st.integers(0, 5))
def test_ends_of_range_are_found(seed, low, high, which):
    rows = wrench(seed)
    rows[:, which] = np.clip(rows[:, which], low, high)
    found = {(one.component, one.value) for one in range_limits(rows)}
    assert found == {(which, low), (which, high)}
    arm = ArmLog(np.zeros((ROWS, 3)), rows)
    left_out = np.isnan(without_clipped(arm, TIME).wrench).any(axis=1)
    at = TIME[np.isin(rows[:, which], [low, high])]
    np.testing.assert_array_equal(left_out, (np.abs(TIME[:, None] - at) < CLIP_MARGIN_INTERVAL).any(axis=1))
    assert all("the end of the sensor's range" in said.words for said in clipped_arm("left", arm, TIME))


@settings(max_examples=20)
@given(seed=st.integers(0, 99), step=st.floats(0.1, 3.0))
def test_what_only_seems_so_is_kept(seed, step):
    """A hand that only pushes, coarse steps, and a robot that gives what it may, without noise."""
    rows, given_ = wrench(seed), np.clip(wrench(seed, 0.0), -3.0, 3.0)
    for one in (rows, np.maximum(rows, 0.0), np.round(rows / step) * step, given_, np.zeros((ROWS, 6)), rows[:3]):
        assert list(range_limits(one)) == []


def test_a_clipped_sensor_is_told_and_the_mass_is_right():
    """Before, nothing was told, and it was 21.7 ± 0.9 kg."""
    sound = two_hands(1)
    most = {name: np.quantile(np.abs(arm.wrench[:, 0]), 0.9) for name, arm in sound.arms.items()}
    limits = {name: np.array([force, *[np.inf] * 5]) for name, force in most.items()}
    log = replace(
        sound,
        arms={k: ArmLog(a.contact, np.clip(a.wrench, -limits[k], limits[k])) for k, a in sound.arms.items()},
    )
    told = corrected_log(log, CART).suspicions
    assert {(one.kind, one.where) for one in told} == {("scale", "left"), ("scale", "right")}
    mass = identify([log], cart_of(0.7)).parameters["mass"]
    assert abs(mass.value - 24.0) < 1.0
    assert mass.std < 1.5
