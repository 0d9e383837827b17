"""The whole check: what is promised of every suspicion, and logs that were measured."""

from dataclasses import FrozenInstanceError, replace
from pathlib import Path

import numpy as np
import pytest

from cartgrasp.cart_file import cart_from_text
from cartgrasp.logs import ArmLog, RunLog
from cartgrasp.logs.emps import rail_cart, read_emps
from estimation.sensor_check import KINDS, REFUSED, Suspicion, check_sensors, velocities_put_right
from estimation.sensor_check.suspicion import TOLD

from .sensor_logs import CART, RAIL, found, late, on_rail, sealed, two_hands, with_wrenches

SHARED = Path(__file__).parents[3] / "shared" / "data"
REAL = {"car/drive_and_coast.csv": 205.0, "wheelchair/push.csv": 105.0}
"""kg, the middle of what two-way least squares brackets."""
COASTING = ("incline/good_cart.csv", "incline/magnetic_bumper.csv", "incline/sail.csv", "incline/still.csv")
needs_data = pytest.mark.skipif(not SHARED.exists(), reason="the measured logs are not here")


def rail_of(mass):
    rail = "constraints: [no_lateral_slip: {x: 0.0}, no_rotation: {}]"
    return cart_from_text(f"name: r\nmass: {mass}\ncom: [0, 0]\ninertia: 1.0\n{rail}\n", "rail")


def measured(path):
    table = np.genfromtxt(SHARED / "real" / path, delimiter=",", names=True, deletechars="")
    pose = np.column_stack([table["x"], table["y"], table["theta"]])
    names = {name.split(".")[0] for name in table.dtype.names if "." in name}
    arms = {
        name: ArmLog(
            np.column_stack([table[f"{name}.p{c}"] for c in "xyz"]),
            np.column_stack([table[f"{name}.{k}{c}"] for k in "ft" for c in "xyz"]),
        )
        for name in names
    }
    n = len(table)
    return RunLog(table["t"], pose, None, arms or {"none": ArmLog(np.zeros((n, 3)), np.zeros((n, 6)))})


def test_a_suspicion_is_frozen_and_says_what_stops():
    one = Suspicion("sign", "left", 0.95, -1.0, "left: reversed")
    assert one.is_refused
    assert not replace(one, probability=0.89).is_refused
    assert not replace(one, kind="lag").is_refused
    assert set(REFUSED) < set(KINDS)
    with pytest.raises(FrozenInstanceError):
        one.probability = 0.1  # type: ignore[misc]


def test_a_sound_log_gives_nothing():
    assert check_sensors(two_hands(0), CART) == ()
    assert check_sensors(on_rail(), RAIL) == ()


def test_all_that_is_told_keeps_to_the_contract():
    log = late(with_wrenches(two_hands(0), lambda w: -w, ("right",)), 0.05, 1.04)
    told = check_sensors(replace(log, pose=np.round(log.pose / 0.01) * 0.01), CART)
    assert {one.kind for one in told} >= {"sign", "lag", "scale", "quantised"}
    for one in told:
        assert one.kind in KINDS
        assert TOLD <= one.probability <= 1.0
        assert one.factor is None or np.isfinite(one.factor)
        assert "\n" not in one.words
        assert any(c.isdigit() for c in one.words)


def test_several_faults_are_told_side_by_side():
    """Each with the others put right: degrees, body velocities, a reversed sensor, and repeats."""
    log = two_hands(1)
    c, s = np.cos(log.pose[:, 2]), np.sin(log.pose[:, 2])
    vx, vy, omega = log.velocity.T
    wrong = with_wrenches(log, lambda w: -w, ("left",))
    wrong = replace(
        wrong,
        pose=log.pose * [1, 1, 180 / np.pi],
        velocity=np.column_stack([c * vx + s * vy, c * vy - s * vx, omega]),
    )
    told = found(check_sensors(wrong, CART))
    assert told.keys() == {("unit", "pose"), ("frame", "velocity"), ("sign", "left")}
    assert min(told.values()) > 0.9


def test_a_whole_log_in_millimetres_and_milliseconds():
    log = two_hands(0)
    wrong = replace(log, time=log.time * 1e3, pose=log.pose * [1e3, 1e3, 1], velocity=log.velocity * [1e3, 1e3, 1])
    told = found(check_sensors(wrong, CART))
    assert {("unit", "time"), ("unit", "pose"), ("unit", "velocity")} <= told.keys()
    assert not {key for key in told if key[0] == "sign"}


def test_short_logs_give_no_error():
    log = two_hands(0)
    for n in (2, 5, 30, 120):
        arms = {name: ArmLog(arm.contact[:n], arm.wrench[:n]) for name, arm in log.arms.items()}
        short = replace(log, time=log.time[:n], pose=log.pose[:n], velocity=log.velocity[:n], arms=arms)
        assert not {one.kind for one in check_sensors(short, CART) if one.is_refused}


def test_logs_with_blank_columns_give_no_error():
    log = two_hands(0)
    nothing = np.full_like(log.pose, np.nan)
    assert not [one for one in check_sensors(replace(log, pose=nothing), CART) if one.is_refused]
    assert check_sensors(replace(log, velocity=nothing), CART) == ()
    blank = with_wrenches(log, lambda w: np.full_like(w, np.nan))
    assert check_sensors(blank, CART) == ()


@pytest.mark.parametrize("lag", [0.02, 0.05])
def test_the_velocities_of_a_sealed_log_are_put_right(lag):
    log, cart = sealed("nothing", 1)
    told = found(check_sensors(late(log, lag, 1.05), cart))
    assert told.keys() == {(kind, where) for kind in ("lag", "scale") for where in ("velocity", "yaw_rate")}
    right = velocities_put_right(late(log, lag, 1.05))
    assert check_sensors(right, cart) == ()


@needs_data
@pytest.mark.parametrize("path", REAL)
@pytest.mark.parametrize("guess", [0.4, 1.0, 2.5])
def test_measured_pushes_raise_no_alarm(path, guess):
    """The chair's wrench has a wave once a turn of its wheel, 1.94 m, which its pushes nearly keep step with."""
    told = {one.kind: one for one in check_sensors(measured(path), rail_of(guess * REAL[path]))}
    assert told.keys() <= ({"quantised", "offset"} if "chair" in path else set())
    if "offset" in told:
        assert told["offset"].factor == pytest.approx(1.94, rel=0.1)


@needs_data
@pytest.mark.parametrize("path", REAL)
def test_measured_pushes_that_are_made_wrong_are_told(path):
    """Signs and places for sure; kilogrammes that the car's rough push would explain as well are told with 0.85."""
    log, cart = measured(path), rail_of(REAL[path])
    for change, kind in ((-1.0, "sign"), (1e-3, "unit"), (1 / 9.80665, "unit")):
        told = found(check_sensors(with_wrenches(log, lambda w, c=change: c * w), cart))
        assert next(p for (k, where), p in told.items() if k == kind and where in log.arms) > 0.8
    backwards = found(check_sensors(replace(log, pose=-log.pose), cart))
    assert next(p for (k, where), p in backwards.items() if k == "sign" and where in log.arms) > 0.9
    millimetres = found(check_sensors(replace(log, pose=log.pose * 1e3), cart))
    assert millimetres[("unit", "pose")] > 0.9


@needs_data
@pytest.mark.parametrize("path", COASTING)
def test_coasting_carts_raise_no_alarm_and_their_centimetres_are_told(path):
    told = {one.kind: one for one in check_sensors(measured(path), rail_of(0.5))}
    assert told.keys() <= {"quantised"}
    if "still" not in path:
        assert told["quantised"].factor == pytest.approx(0.01, rel=1e-3)


@needs_data
def test_the_encoder_of_a_measured_wheelchair_is_told():
    told = {one.kind: one for one in check_sensors(measured("wheelchair/push.csv"), rail_of(110.0))}
    assert told["quantised"].factor == pytest.approx(np.radians(0.09) * 0.3086, rel=0.03)


@needs_data
def test_a_measured_axis_raises_no_alarm():
    log = read_emps(SHARED / "emps" / "DATA_EMPS.mat")
    assert check_sensors(log, rail_cart()) == ()
    reversed_drive = found(check_sensors(with_wrenches(log, lambda w: -w), rail_cart()))
    assert reversed_drive[("sign", "drive")] > 0.9
