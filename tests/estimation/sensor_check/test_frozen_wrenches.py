"""Force sensors that freeze, and those that only seem to."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cartgrasp.logs import ArmLog
from estimation.sensor_check.check import corrected_log
from estimation.sensor_check.stuck_wrenches import frozen_arm, frozen_wrench, without_frozen
from estimation.whole_log.identification import identify

from .logs import CART, cart_of, two_hands

ROWS = 1000
TIME = 0.01 * np.arange(ROWS)


def wrench(seed, noise=0.3):
    clean = np.column_stack([5.0 * np.sin(0.7 * (i + 1) * TIME) for i in range(6)])
    return clean + noise * np.random.default_rng(seed).standard_normal(clean.shape)


@given(seed=st.integers(0, 99), first=st.integers(2, 800), count=st.integers(4, 150))
def test_a_run_of_repeats_is_no_measurement(seed, first, count):
    """A repeat now and then stays: a driver that is a little faster than its sensor."""
    rows = wrench(seed)
    rows[50::97] = rows[49::97][: len(rows[50::97])]
    rows[first : first + count] = rows[first - 1]
    found = frozen_wrench(rows)
    assert (
        set(range(first, first + count)) <= set(np.flatnonzero(found.rows)) <= set(range(first - 1, first + count + 1))
    )
    kept = without_frozen(ArmLog(np.zeros((ROWS, 3)), rows)).wrench
    np.testing.assert_array_equal(np.isnan(kept).all(axis=1), found.rows)
    (said,) = frozen_arm("left", ArmLog(np.zeros((ROWS, 3)), rows), TIME)
    assert (said.kind, said.where, said.put_right) == ("repeated", "left", True)
    assert "a sensor that froze" in said.words


@settings(max_examples=20)
@given(seed=st.integers(0, 99), hold=st.integers(2, 10))
def test_what_only_seems_so_is_kept(seed, hold):
    rows, rests = wrench(seed), wrench(seed, 0.0)
    rests[300:500] = rests[300]
    nothing = np.where((TIME > 5.0)[:, None], 0.0, rows)
    held = rows[np.arange(ROWS) // hold * hold]
    for one in (rows, rests, nothing, held, np.round(rows / 2.0) * 2.0, np.zeros((ROWS, 6)), rows[:2], rows[:0]):
        assert frozen_wrench(one) is None


@pytest.mark.some(1)
@pytest.mark.parametrize("arms", [("left",), ("left", "right")])
def test_a_frozen_sensor_is_told_and_teaches_nothing(arms):
    """Before, units were suspected, and somebody who pushes."""
    sound = two_hands(1)
    frozen = (sound.time > 15.0) & (sound.time < 21.0)
    first = int(np.argmax(frozen))
    changed = {
        name: ArmLog(arm.contact, np.where(frozen[:, None] & (name in arms), arm.wrench[first], arm.wrench))
        for name, arm in sound.arms.items()
    }
    log = replace(sound, arms=changed)
    told = corrected_log(log, CART).suspicions
    assert [(one.kind, one.where) for one in told] == [("repeated", name) for name in arms]
    mass = identify([log], cart_of(0.7)).parameters["mass"]
    assert abs(mass.value - 24.0) < 4.0 * mass.std < 4.0


@pytest.mark.parametrize("step", [0.1, 0.5])
def test_a_coarse_sensor_that_rests_is_not_frozen(step):
    """Between pushes it tells its offset, for longer than by chance; without these rows drag was told 11 % too large,
    by 4.6 deviations."""
    random, time = np.random.default_rng(0), 0.01 * np.arange(6000)
    push = np.where(time % 6.0 < 3.5, 25.0 * np.sin(np.pi * (time % 6.0) / 3.5), 0.0)
    tremor = np.where(push > 0.0, 0.6, 0.0)[:, None] * random.standard_normal((6000, 2))
    rows = np.zeros((6000, 6))
    rows[:, :2] = 1.3 + np.column_stack([push, 0.1 * push]) + tremor + 0.02 * random.standard_normal((6000, 2))
    assert frozen_wrench(step * np.round(rows / step)) is None
