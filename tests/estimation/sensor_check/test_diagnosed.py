"""Sensors in the workflow: late and large velocities do no harm, and nothing that does is left without a word."""

from dataclasses import replace

import numpy as np
import pytest

from estimation.discrepancy import diagnose
from estimation.sensor_check import REFUSED_KINDS, SUSPICION_KINDS, Suspicion, check_sensors

from .logs import CART, RAIL, found, late, on_rail, sealed, two_hands, with_wrenches


def test_a_suspicion_says_what_stops():
    one = Suspicion("sign", "left", 0.95, -1.0, "left: reversed")
    assert one.is_refused
    assert not replace(one, probability=0.89).is_refused
    assert not replace(one, kind="lag").is_refused
    assert set(REFUSED_KINDS) < set(SUSPICION_KINDS)


@pytest.mark.long
def test_a_sound_log_gives_nothing():
    assert check_sensors(two_hands(0), CART) == ()
    assert check_sensors(on_rail(), RAIL) == ()


def test_all_that_is_told_keeps_to_the_contract():
    log = late(with_wrenches(two_hands(0), lambda w: -w, ("right",)), 0.05, 1.04)
    told = check_sensors(replace(log, pose=np.round(log.pose / 0.01) * 0.01), CART)
    assert {one.kind for one in told} >= {"sign", "lag", "scale", "quantised"}
    assert told[0].is_refused
    for one in told:
        assert one.kind in SUSPICION_KINDS
        assert 0.0 <= one.probability <= 1.0
        assert one.factor is None or np.isfinite(one.factor)
        assert "\n" not in one.words


@pytest.mark.long
@pytest.mark.some(1)
@pytest.mark.parametrize(("lag", "gain"), [(0.02, 1.0), (0.05, 1.0), (0.0, 1.03), (0.0, 1.05)])
def test_late_or_large_velocities_are_told_and_change_no_mass(lag, gain):
    """Of a cart on a rail, whose mass is 24 kg."""
    diagnosis = diagnose(late(on_rail(), lag, gain), RAIL)
    assert diagnosis.parameter_mismatch["mass"]["refitted"] == pytest.approx(24.0, rel=0.03)
    (check,) = diagnosis.checks
    assert found(check.suspicions).keys() == {("lag" if lag else "scale", "velocity")}
    assert len(diagnosis.warnings) == 1
    assert "poses" in diagnosis.warnings[0]
    assert diagnosis.sentence.count("sensors") == 0


@pytest.mark.long
def test_a_reversed_sensor_is_told_beside_the_verdict_and_not_mended():
    wrong = with_wrenches(on_rail(duration=15.0), lambda w: -w)
    diagnosis = diagnose(wrong, RAIL)
    (check,) = diagnosis.checks
    assert found(check.suspicions)["sign", "hand"] > 0.9
    assert "fx is what is recorded as -fx" in diagnosis.sentence
    document = diagnosis.report.as_dict()
    assert document["warnings"][0] == diagnosis.warnings[0]
    assert document["logs"][0]["suspicions"][0]["kind"] == "sign"


@pytest.mark.prove
def test_a_sealed_log_has_the_mass_of_the_truth():
    log, cart = sealed("nothing", 1)
    whole, wrong = (diagnose(one, cart).parameter_mismatch["mass"] for one in (log, late(log, 0.05, 1.05)))
    assert wrong["refitted"] == pytest.approx(whole["refitted"], rel=0.01)
    assert wrong["std"] == pytest.approx(whole["std"], rel=0.2)
