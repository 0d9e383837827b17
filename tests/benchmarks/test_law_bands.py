"""The exam of laws' bands: what it asks, of one law, against closed forms."""

import json

import numpy as np
import pytest

from benchmarks.law_bands import Band, alone, bands, table
from benchmarks.sealed.generate import generate


def test_what_effects_beside_a_law_give_as_well_is_no_error():
    time = np.linspace(0, 10, 500)
    speed, rest = np.sin(time), np.cos(3 * time)
    rest -= speed * (speed @ rest) / (speed @ speed)
    assert alone(2.0 * speed + rest, [speed, np.zeros(500)]) == pytest.approx(rest)
    assert alone(rest, []) == pytest.approx(rest)


def test_the_table_is_of_means_by_law():
    found = [Band("hum", 4.0, 0.9, 0.2, 0.1), Band("hum+rolling_resistance", 2.0, 1.0, 0.4, 0.1)]
    last = table([*found, Band("drift", 1.0, 0.5, 0.1, 0.1)]).splitlines()
    assert last[2].split() == ["hum", "2", "95.0", "%", "3.00", "0.30", "0.10"]
    assert last[3].split()[:4] == ["all", "3", "80.0", "%"]


@pytest.mark.prove
def test_a_drift_is_within_its_band(tmp_path):
    generate(tmp_path, ["drift", "nothing"], range(31, 32), "rich")
    (found,) = bands(tmp_path, 1)
    assert found.case == "drift"
    truth = next(json.loads(p.read_text()) for p in (tmp_path / "truth").glob("*.json") if "drift" in p.read_text())
    assert found.size == pytest.approx(abs(truth["world"]["law_size"]) / 3**0.5, rel=0.2)
    assert found.held > 0.8
