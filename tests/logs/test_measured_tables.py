"""The measured tables as their sources print them, read through a map alone: the logs that were once made of them by
hand."""

from __future__ import annotations

import numpy as np
import pytest

from cartgrasp.logs import read_log

from ..benchmarks.measured_logs import DATA, needs_data

pytestmark = pytest.mark.skipif(not (DATA / "raw").is_dir(), reason=f"no measured tables at {DATA / 'raw'}")
WHEELCHAIR = """\
table: {separator: ";", header: , first: 2}
time: {rate: 240}
pose:
  x: {column: 4, unit: deg, radius: 0.3086, zero: start}
  y: 0.0
  theta: 0.0
arms:
  chair:
    contact: [0.0, 0.0, 0.0]
    force: on_cart
    measures: [fx]
    fx: {column: 24, unit: N·m, radius: 0.3086, factor: 2.0}   # one of two sides was measured
    unmeasured: zero                                           # a rail takes the rest
"""
CAR = """\
table: {every: 5}
time: {column: Time, unit: s}
pose:
  x: {column: RR_Position, unit: deg, radius: 0.2921, zero: start}
  y: 0.0
  theta: 0.0
arms:
  hub:
    contact: [0.0, 0.0, 0.0]
    force: on_sensor
    measures: [fx]
    fx: {column: RR_Fx, unit: N, factor: 2.0}
    unmeasured: zero
"""
INCLINE = """\
time: {{column: "Time (s) {run}", unit: s}}
pose:
  x: {{column: "Position (m) {run}", unit: m}}
  y: 0.0
  theta: 0.0
arms: {{}}
"""
RUNS = {
    "good_cart": "good cart run #1",
    "magnetic_bumper": "bad cart magnetic run #3",
    "sail": "good cart sail Run #6",
    "still": "stationary test run #8",
}
LOGS = {
    "wheelchair.csv": (WHEELCHAIR, "wheelchair/push.csv", 6e-5),
    "car.csv": (CAR, "car/drive_and_coast.csv", 6e-5),
    **{f"incline.csv {name}": (INCLINE.format(run=run), f"incline/{name}.csv", 0.0) for name, run in RUNS.items()},
}


@needs_data
@pytest.mark.parametrize("name", LOGS)
def test_a_map_alone(tmp_path, name):
    """To how far the logs that were made by hand are rounded, which are printed with five digits and with three."""
    text, of_hand, rounding = LOGS[name]
    (tmp_path / "map.yaml").write_text(text, encoding="utf-8")
    log, expected = read_log(DATA / "raw" / name.split()[0], tmp_path / "map.yaml"), read_log(DATA / "real" / of_hand)
    assert log.columns == expected.columns
    of_forces = [column.endswith("fx") for column in log.columns]
    assert (np.abs(log.table - expected.table) <= np.where(of_forces, 10 * rounding, rounding + 1e-12)).all()
