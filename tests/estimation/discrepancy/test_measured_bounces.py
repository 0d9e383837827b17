"""Carts that ran down a track and bounced, with velocities that were made from the poses: they say nothing new, so
slope and stop are as on the log as it is, and as it is known that they were (the data's README)."""

import math
from pathlib import Path

import pytest

from benchmarks.measured.carts import INCLINE
from benchmarks.measured.variants import VARIANTS
from cartgrasp.logs import read_log
from estimation.discrepancy import diagnose

DATA = Path(__file__).parents[4] / "shared" / "data" / "real" / "incline"
OF_VELOCITIES = {variant.name: variant.change for variant in VARIANTS if variant.name.startswith("velocities ")}

pytestmark = pytest.mark.skipif(not DATA.is_dir(), reason="the measured logs are not part of the project")


@pytest.mark.prove
@pytest.mark.parametrize(
    ("name", "variant"),
    [
        ("good_cart", "velocities fitted"),
        ("good_cart", "velocities 50 ms late"),
        ("good_cart", "velocities 3 % large"),
        ("magnetic_bumper", "velocities fitted"),
    ],
)
def test_velocities_made_from_poses_change_nothing(name, variant):
    found = diagnose(OF_VELOCITIES[variant](read_log(DATA / f"{name}.csv")), INCLINE)
    told = {effect.name: effect.parameters for effect in found.effects}
    assert set(told) == {"floor_slope", "end_stop"}
    assert 1.7 < math.degrees(math.atan(-told["floor_slope"]["grade_x"][0])) < 2.3
    assert 1.12 < told["end_stop"]["position"][0] < 1.18


@pytest.mark.long
def test_flights_that_are_too_short_to_tell_anything_are_left_out():
    """Of a log of 25 Hz, in which the last bounces are a few rows each; the slope gains 6 nats, and closes the gap."""
    change = next(variant.change for variant in VARIANTS if variant.name == "means of four")
    found = diagnose(change(read_log(DATA / "sail.csv")), INCLINE)
    assert {effect.name for effect in found.effects} == {"floor_slope", "end_stop"}
    assert found.steps[0].attempts[0].key == "floor_slope"
