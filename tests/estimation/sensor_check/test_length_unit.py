"""Poses in another unit of length."""

from dataclasses import replace

import numpy as np
import pytest

from cartgrasp.errors import DataError
from estimation.sensor_check import check_sensors, look_at
from estimation.sensor_check.sizes import POSITION_UNITS, check_jumps, length_unit_suspicions

from .logs import CART, on_rail, two_hands


@pytest.mark.parametrize("name", ["mm", "cm"])
@pytest.mark.parametrize("make", [two_hands, on_rail])
def test_a_cart_does_not_go_so_fast(name, make):
    """Before, forces were told to be in kN."""
    log = make(1)
    noise = 0.002 * np.random.default_rng(0).standard_normal((len(log), 2))
    place = (log.pose[:, :2] + noise) / POSITION_UNITS[name]
    moved = replace(log, pose=np.column_stack([place, log.pose[:, 2]]), velocity=None)
    (told,) = (one for one in length_unit_suspicions(moved) if one.where == "pose")
    assert (told.kind, told.factor, told.is_refused) == ("unit", POSITION_UNITS[name], True)
    assert f"x and y are in {name}" in told.words
    look = look_at(moved, CART)
    assert {(one.kind, one.where) for one in look.suspicions if one.is_refused} == {("unit", "pose")}
    assert look.unjudged == "mend the poses first"


@pytest.mark.parametrize("make", [two_hands, on_rail])
def test_a_sound_log_is_in_metres(make):
    log = make(0)
    jumping = np.random.default_rng(0).random(len(log)) < 0.02
    assert length_unit_suspicions(log) == ()
    assert length_unit_suspicions(replace(log, pose=log.pose + 500.0 * jumping[:, None])) == ()
    assert length_unit_suspicions(replace(log, pose=np.full_like(log.pose, np.nan))) == ()


@pytest.mark.parametrize("column", ["wrench", "contact"])
def test_a_column_without_a_value_is_named(column):
    log = two_hands(0)
    arm = log.arms["left"]
    values = getattr(arm, column).copy()
    values[:, 1] = np.nan
    told = check_sensors(replace(log, arms={**log.arms, "left": replace(arm, **{column: values})}), CART)
    assert [(one.kind, one.where) for one in told] == [("holes", "left")]
    assert told[0].words.startswith({"wrench": "left.fy: blank", "contact": "left.py: blank"}[column])


def test_stamps_that_come_in_bursts_are_told_as_such():
    """They were told as a jump by 0.00 m, and to cut the log there."""
    log = on_rail(1)
    pairs = log.time + np.where(np.arange(len(log)) % 2 == 0, 0.00999, 0.0)
    with pytest.raises(DataError, match=r"in 1e-05 s at t = .* stamp rows when they are measured"):
        check_jumps(replace(log, time=pairs), 5e-6)
