"""Tables of anybody's columns through a map: the numbers against conversions that are written out here, and what a map
or a table is refused for."""

from __future__ import annotations

import re
import shutil

import numpy as np
import pytest
import scipy.constants as constants
from scipy.spatial.transform import Rotation

from cartgrasp.errors import CartgraspError, FileError, LogError
from cartgrasp.logs import read_log
from cartgrasp.logs.csv_log import PAGE
from cartgrasp.logs.tables.proposing import propose
from cartgrasp.logs.tables.units import UNITS, unit_of

from ..cli.commands import ROOT

N = 40
TIME = 0.02 * np.arange(N)
X, Y, THETA = 0.5 * TIME, 0.1 * TIME**2, 3.0 + 0.4 * TIME
FX, TZ = 20 + TIME, 0.5 * np.cos(TIME)
MAP = """\
table: {separator: ";", decimal: ",", header: 2, first: 4}
time: {column: Zeit, unit: ms}
pose:
  x: {column: x, unit: mm}
  y: {column: y, unit: cm}
  theta: {column: Winkel, unit: deg, sign: -1}
arms:
  hand:
    contact: [-0.25, 0.2, 1.0]
    force: on_sensor
    measures: [fx, tz]
    fx: {column: Kraft, unit: kN}
    tz: {column: 6, unit: lbf·in}
    unmeasured: zero
"""


def rows(*columns, decimal="."):
    return [[f"{value:.9g}".replace(".", decimal) for value in row] for row in zip(*columns, strict=True)]


@pytest.fixture
def table(tmp_path):
    """Milliseconds, mm, cm, degrees clockwise and wrapped, kN felt by the sensor; semicolons, decimal commas."""
    degrees = (-np.degrees(THETA) + 180) % 360 - 180
    moment = -TZ / (constants.pound_force * constants.inch)
    cells = rows(1e3 * TIME, 1e3 * X, 1e2 * Y, degrees, -1e-3 * FX, moment, decimal=",")
    lines = ["Messung 3", "Zeit;x;y;Winkel;Kraft;Moment", "ms;mm;cm;°;kN;in-lb", *(";".join(row) for row in cells)]
    path = tmp_path / "mine.csv"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


def mapped(path, text=MAP):
    path.with_name(f"{path.name}.topics.yaml").write_text(text, encoding="utf-8")
    return path


def test_units_signs_and_commas(table):
    log = read_log(mapped(table))
    assert np.allclose(log.time, TIME, atol=1e-9)
    assert np.allclose(log.pose[:, :2], np.column_stack([X, Y]), atol=1e-8)
    turned = log.pose[:, 2] - THETA
    assert np.allclose(turned, 2 * np.pi * np.round(turned[0] / (2 * np.pi)), atol=1e-8)  # unwrapped, whole turns off
    wrench = np.column_stack([FX, 0 * FX, 0 * FX, 0 * FX, 0 * FX, TZ])
    assert np.allclose(log.arms["hand"].wrench, wrench, atol=1e-6)
    assert np.array_equal(log.arms["hand"].contact, np.tile([-0.25, 0.2, 1.0], (N, 1)))
    assert log.velocity is None


def test_what_a_sensor_does_not_measure_may_be_missing(table):
    wrench = read_log(mapped(table, MAP.replace("unmeasured: zero", "unmeasured: missing"))).arms["hand"].wrench
    assert np.isnan(wrench[:, 1:5]).all()
    assert np.isfinite(wrench[:, [0, 5]]).all()


def test_units_are_those_of_scipy():
    said = {"lbf": constants.pound_force, "kgf": constants.kilogram_force, "in": constants.inch, "ft": constants.foot}
    said |= {"mph": constants.mph, "km/h": constants.kmh, "deg": constants.degree, "rpm": 2 * np.pi / 60}
    said |= {"lbf·ft": constants.pound_force * constants.foot, "kgf·cm": constants.kilogram_force / 100}
    known = {unit: size for units in UNITS.values() for unit, size in units.items()}
    assert all(known[unit] == pytest.approx(size, rel=1e-12) for unit, size in said.items())


@pytest.mark.parametrize(
    ("word", "dimension", "unit"),
    [
        ("N*m", "moment", "N·m"),
        ("°/s", "rate", "deg/s"),
        ("ft-lb", "moment", "lbf·ft"),
        ("µs", "time", "us"),
        ("MN", "force", None),
        ("N", "length", None),
    ],
)
def test_ways_to_write_units(word, dimension, unit):
    assert unit_of(word, dimension) == unit


def test_a_wheel_and_a_second_side(tmp_path):
    """An angle times a radius is a way, a moment over it a force; one of two sides was measured."""
    path = tmp_path / "wheel.csv"
    angle = (200 + 100 * TIME / TIME[-1] * 6) % 360
    path.write_text("\n".join(["a,m", *(",".join(row) for row in rows(angle, TZ))]) + "\n")
    text = """\
time: {rate: 50}
pose: {x: {column: a, unit: deg, radius: 0.3, zero: start}, y: 0.0, theta: 0.0}
arms:
  rim: {contact: [0, 0, 0], force: on_cart, measures: [fx], unmeasured: zero,
        fx: {column: m, unit: N·m, radius: 0.3, factor: 2.0}}
"""
    log = read_log(mapped(path, text))
    assert np.allclose(log.pose[:, 0], np.radians(600 * TIME / TIME[-1]) * 0.3, atol=1e-7)
    assert np.allclose(log.arms["rim"].wrench[:, 0], 2 * TZ / 0.3, atol=1e-7)
    assert np.allclose(log.time, TIME)
    every = read_log(mapped(path, "table: {every: 4}\n" + text))
    assert np.array_equal(every.time, log.time[::4])
    assert np.array_equal(every.pose, log.pose[::4])


def test_a_sensor_with_a_file_and_a_clock_of_its_own(tmp_path):
    """Rows at the poses' times, each the mean of the samples around it."""
    (tmp_path / "run_pose.csv").write_text("\n".join(["t,x,y,q", *(",".join(r) for r in rows(TIME, X, Y, THETA))]))
    fine = np.arange(-0.01, 0.9, 0.005)
    (tmp_path / "run_ft.csv").write_text("\n".join(["ms,f", *(",".join(r) for r in rows(1e3 * fine, 3 * fine))]))
    text = """\
time: {column: t, unit: s}
pose: {x: {column: x, unit: m}, y: {column: y, unit: m}, theta: {column: q, unit: rad}}
arms:
  hand: {file: run_ft.csv, time: {column: ms, unit: ms}, contact: [0, 0, 1], force: on_cart, measures: [fx],
         fx: {column: f, unit: N}, unmeasured: zero}
"""
    log = read_log(mapped(tmp_path / "run_pose.csv", text))
    assert np.allclose(log.time, TIME)
    assert np.allclose(log.arms["hand"].wrench[:, 0], 3 * TIME, atol=3 * 0.005)
    shutil.move(tmp_path / "run_ft.csv", tmp_path.parent / "run_ft.csv")
    with pytest.raises(FileError, match="in the same folder"):
        read_log(mapped(tmp_path / "run_pose.csv", text.replace("run_ft", "../run_ft")))


@pytest.mark.parametrize("frame", ["world", "cart"])
def test_quaternions_and_velocities(tmp_path, frame):
    velocity = np.column_stack([np.full(N, 0.5), 0.2 * TIME, np.full(N, 0.4)])
    written = velocity.copy()
    if frame == "cart":
        c, s = np.cos(THETA), np.sin(THETA)
        written[:, :2] = np.column_stack([c * 0.5 + s * velocity[:, 1], c * velocity[:, 1] - s * 0.5])
    quaternion = Rotation.from_euler("ZYX", np.column_stack([THETA, 0.02 + 0 * TIME, -0.03 + 0 * TIME])).as_quat()
    header = "t,x,y,qx,qy,qz,qw,vx,vy,w"
    table = rows(TIME, X, Y, *quaternion.T, *written.T)
    (tmp_path / "q.csv").write_text("\n".join([header, *(",".join(row) for row in table)]))
    text = f"""\
time: {{column: t, unit: s}}
pose:
  x: {{column: x, unit: m}}
  y: {{column: y, unit: m}}
  theta: {{quaternion: [qx, qy, qz, qw]}}
  velocity: columns
  frame: {frame}
  vx: {{column: vx, unit: m/s}}
  vy: {{column: vy, unit: m/s}}
  omega: {{column: w, unit: rad/s}}
arms: {{}}
"""
    log = read_log(mapped(tmp_path / "q.csv", text))
    assert np.allclose(np.exp(1j * log.pose[:, 2]), np.exp(1j * THETA), atol=1e-7)
    assert np.allclose(log.velocity, velocity, atol=1e-7)
    assert log.arms == {}


def test_parquet(tmp_path):
    arrow = pytest.importorskip("pyarrow")
    import pyarrow.parquet

    columns = {"t_ms": 1e3 * TIME, "x": X, "y": Y, "yaw": THETA, "state": ["on"] * N}
    pyarrow.parquet.write_table(arrow.table(columns), tmp_path / "mine.parquet")
    text = """\
time: {column: t_ms, unit: ms}
pose: {x: {column: x, unit: m}, y: {column: y, unit: m}, theta: {column: yaw, unit: rad}}
arms: {}
"""
    log = read_log(mapped(tmp_path / "mine.parquet", text))
    assert np.allclose(log.table, np.column_stack([TIME, X, Y, THETA]), atol=1e-12)
    with pytest.raises(LogError, match="state: 'on' is not a number"):
        read_log(mapped(tmp_path / "mine.parquet", text.replace("column: yaw", "column: state")))


@pytest.mark.parametrize("kind", ["timestamp", "duration", "int64", "uint64"])
def test_parquet_with_stamps_to_the_nanosecond(tmp_path, kind):
    """As pandas and ROS write them: whole numbers are read, dates are refused as text, where they had been no error of
    this library's."""
    arrow = pytest.importorskip("pyarrow")
    import pyarrow.parquet

    stamps = arrow.array(1_732_000_000_123_456_789 + np.round(1e9 * TIME).astype(np.int64))
    types = {"timestamp": arrow.timestamp("ns", tz="UTC"), "duration": arrow.duration("ns")}
    stamps = stamps.cast(types.get(kind, kind))
    path = tmp_path / "mine.parquet"
    pyarrow.parquet.write_table(arrow.table({"t": stamps, "x": X, "y": Y, "yaw": THETA}), path)
    text = """\
time: {column: t, unit: ns}
pose: {x: {column: x, unit: m}, y: {column: y, unit: m}, theta: {column: yaw, unit: rad}}
arms: {}
"""
    assert "column: yaw" in propose(path).text
    if kind == "timestamp":
        with pytest.raises(
            LogError, match=r"t: '2024-11-19 07:06:40\.123456789Z' is not a number \(write times as sec"
        ):
            read_log(mapped(path, text))
    else:
        log = read_log(mapped(path, text))
        assert np.allclose(log.time - 1732000000.123456789, TIME, atol=5e-7, rtol=0)


OPEN = """\
time: {column: Zeit, unit: ms?}
pose:
  x: {column: x, unit: mm}
  y: {column: y, unit: }
  theta: {column: Winkel, unit: deg, sign: -1?}
arms:
  hand:
    contact:
    force:
    measures: [fx]
    fx: {column: "Kraft?", unit: kN}
"""


def test_all_that_is_open_is_told_at_once(table):
    with pytest.raises(FileError) as caught:
        read_log(mapped(table, OPEN))
    message = str(caught.value)
    assert len(message.splitlines()) == 1
    assert message.startswith(f"{table}.topics.yaml:1:")
    for part in (
        "time.unit: ms? is a guess: take its question mark away",
        "line 5: pose.theta.sign: -1? is a guess",
        "line 11: arms.hand.fx.column: Kraft? is a guess",
        "line 4: pose.y.unit: is not stated: one of m, mm",
        "line 8: arms.hand.contact: is not stated",
        "line 9: arms.hand.force: is not stated",
        "line 7: arms.hand.unmeasured: is not stated: zero if fy, fz, tx, ty, tz",
        f"{PAGE} explains",
    ):
        assert part in message
    assert (ROOT / PAGE).is_file()


def test_all_missing_columns_are_told_at_once(tmp_path):
    (tmp_path / "mine.csv").write_text("time_ms,x,left.fx\n0,1,2\n")
    with pytest.raises(LogError) as caught:
        read_log(tmp_path / "mine.csv")
    for part in ("1: t: this column is missing; so are y, theta, left.px", "left.tz", "cartgrasp topics", PAGE):
        assert part in str(caught.value)


BAD_MAPS = {
    "no unit of it": (("unit: mm", "unit: N"), "pose.x.unit: N is no unit of length"),
    "a column that isn't there": (
        ("column: Kraft,", "column: Krafd,"),
        "Krafd: there is no such column; did you mean Kraft?",
    ),
    "a number beyond the columns": (("column: 6", "column: 7"), "there is no such column; there are 1 to 6"),
    "what is not measured": (("measures: [fx, tz]", "measures: [fx]"), "tz: is not among what the sensor measures"),
    "a bag's map": (("  x:", "  topic: /odom\n  x:"), "a table is no bag"),
    "an unknown key": (("unit: mm", "units: mm"), "unknown key"),
    "no arms": (("arms:", "arms: {}\nothers:"), "others"),
    "a radius of a moment": (("unit: lbf·in", "unit: lbf·in, radius: 1.0"), "ways (of an angle) and forces"),
    "another decimal mark": (('decimal: ","', 'decimal: "."'), "is not a number (a missing"),
    "another separator": (('separator: ";"', 'separator: ","'), "columns: what parts cells"),
    "a header that isn't there": (("header: 2", "header: 200"), "the file has"),
    "no rows": (("first: 4", "first: 400"), "no rows"),
    "a row of names": (("first: 4", "first: 3"), "3: x: 'mm' is not a number"),
    "a bare name": (
        ("y: {column: y, unit: cm}", "y: y"),
        "pose.y: 'y' is neither a number nor a mapping `{key: value}`",
    ),
    "a factor in quotes": (("unit: mm", 'unit: mm, factor: "2"'), "pose.x.factor: '2' is not a number"),
    "another case": (("column: Kraft,", "column: kraft,"), "did you mean Kraft?"),
    "times and a rate": (("unit: ms}", "unit: ms, rate: 100}"), "time.rate: is for rows without times"),
    "a column twice": (("column: Kraft,", "column: 6,"), "tz.column: 6 is fx already"),
    "a contact in mm": (("contact: [", "contact: [-250, 0, 1000] #"), "contact: [-250.0, 0.0, 1000.0] is beyond 50 m"),
    "a sensor in degrees": (
        ("    force:", "    sensor: {rpy: [0, 0, 90]}\n    force:"),
        "sensor.rpy: 90 rad is more than two turns, or not finite; angles are in rad; 90 degrees are 1.571 rad",
    ),
    "a body in degrees": (("  x:", "  body: [0, 0, 90]\n  x:"), "pose.body: 90 rad"),
    "a time of a sensor without a file": (("    force:", "    time: {rate: 9}\n    force:"), "a file of its own"),
}


@pytest.mark.parametrize("kind", BAD_MAPS)
def test_maps_that_do_not_fit(table, kind):
    change, why = BAD_MAPS[kind]
    text = MAP.replace(*change)
    assert text != MAP
    with pytest.raises(CartgraspError, match=re.escape(why)) as caught:
        read_log(mapped(table, text))
    assert len(str(caught.value).splitlines()) == 1


BAD_CELLS = {
    "a group of digits": ("1.234,5", "'1.234,5' is not a number"),
    "a point": ("0.5", "'0.5' is not a number"),
    "a word": ("high", "'high' is not a number"),
    "nothing that is finite": ("1e999", "is not a number"),
    "what is no measurement": ("1e30", "in SI units is no measurement"),
}


@pytest.mark.parametrize("kind", BAD_CELLS)
def test_cells_that_are_no_numbers(table, kind):
    cell, why = BAD_CELLS[kind]
    lines = table.read_text(encoding="utf-8").splitlines()
    cells = lines[9].split(";")
    lines[9] = ";".join([cells[0], cell, *cells[2:]])
    table.write_text("\n".join(lines), encoding="utf-8")
    with pytest.raises(LogError, match=re.escape(why)) as caught:
        read_log(mapped(table))
    assert caught.value.place.line == 10


def test_a_clock_that_goes_back(table):
    lines = table.read_text(encoding="utf-8").splitlines()
    lines[9], lines[10] = lines[10], lines[9]
    table.write_text("\n".join(lines), encoding="utf-8")
    with pytest.raises(LogError, match=r"mine\.csv:11: Zeit: .* goes back"):
        read_log(mapped(table))


def test_shorter_columns_end_where_their_clock_does(table):
    """Runs side by side, of other lengths."""
    text = table.read_text(encoding="utf-8") + ";;;;;\n;;;;;\n"
    table.write_text(text, encoding="utf-8")
    assert len(read_log(mapped(table))) == N
    table.write_text(text + ";1;;;;\n", encoding="utf-8")
    with pytest.raises(LogError, match="a row without a time"):
        read_log(mapped(table))
