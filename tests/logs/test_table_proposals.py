"""What `cartgrasp topics` makes of names, layouts and numbers."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from cartgrasp.errors import LogError
from cartgrasp.logs.tables.proposing import propose
from cartgrasp.logs.tables.proposing.layout import layout_of
from cartgrasp.logs.tables.proposing.names import meaning_of
from cartgrasp.logs.tables.proposing.proposal import is_akin
from cartgrasp.logs.tables.questions import value_of, without_marks
from cartgrasp.logs.tables.table_map import open_questions
from cartgrasp.yaml_file import parse_yaml

NAMES = {
    "time_ms": ("t", "ms", ""),
    "Elapsed Time [s]": ("t", "s", ""),
    "pos_x [mm]": ("x", "mm", ""),
    "X-Position (mm)": ("x", "mm", ""),
    "Weg X / mm": ("x", "mm", ""),
    "yaw_deg": ("theta", "deg", ""),
    "push_fwd_N": ("fx", "N", ""),
    "F_lat [N]": ("fy", "N", ""),
    "hand force forward (lbf)": ("fx", "lbf", "hand"),
    "Heading (°)": ("theta", "deg", ""),
    "v_x_m_s": ("vx", "m/s", ""),
    "field.twist.twist.linear.x": ("vx", None, ""),
    "omega in deg/s": ("omega", "deg/s", ""),
    "yawRate_dps": ("omega", "deg/s", ""),
    "Fx(lbf)": ("fx", "lbf", ""),
    "X [N]": ("fx", "N", ""),
    "forceLeftX_kN": ("fx", "kN", "left"),
    "/left_ft/wrench/torque/z": ("tz", None, "left"),
    "Yaw moment (Nm)": ("tz", "N·m", ""),
    "left_contact_x_m": ("px", "m", "left"),
    "orientation.w": ("qw", None, ""),
    "fx_daN": ("fx", "daN", ""),
    "Mz [mNm]": ("tz", "mN·m", ""),
    "yaw [gon]": ("theta", "gon", ""),
    "position[y]": ("y", None, ""),
    "Fx [left]": ("fx", None, "left"),
}


@pytest.mark.parametrize("name", NAMES)
def test_names(name):
    found = meaning_of(name)
    assert (found.role, found.unit, found.group) == NAMES[name]


@pytest.mark.parametrize(
    "name", ["cmd_vx", "theta_ref", "accel_x", "roll_deg", "battery_V", "max", "index", "vz", "side", "forward", ""]
)
def test_names_of_other_things(name):
    assert meaning_of(name) is None


def test_a_label_of_another_quantity_is_odd():
    assert meaning_of("vel_x [N]").odd == "N"


@pytest.mark.parametrize("label", ["cN", "oz-in", "g", "grad", "x10 N"])
def test_a_label_that_is_not_known_is_no_part_of_a_name(label):
    found = meaning_of(f"fx [{label}]")
    assert (found.role, found.unit, found.group, found.odd) == ("fx", None, "", label)
    assert meaning_of("fx", label) == found


LAYOUTS = {
    "a,b\n1,2\n3,4\n": (",", ".", 1, 2),
    "\n1;2,5\n3;4,5\n": (";", ",", None, 2),
    "# a rig\n# t x\n0.1 2\n0.2 3\n": (" ", ".", 2, 3),
    "Logger\n\na\tb\ns\tmm\n1\t2\n2\t3\n": ("\t", ".", 3, 5),
    "a;state\n1.5;on\n2.5;off\n": (";", ".", 1, 2),
}


@pytest.mark.parametrize("text", LAYOUTS)
def test_layouts(tmp_path, text):
    (tmp_path / "t.csv").write_text(text)
    found = layout_of(tmp_path / "t.csv").format
    assert (found.separator, found.decimal, found.header, found.first) == LAYOUTS[text]


def test_commas_that_may_part_thousands_are_asked_about(tmp_path):
    (tmp_path / "t.csv").write_text("t;x\n1,000;2,500\n2,000;3,500\n")
    assert not layout_of(tmp_path / "t.csv").is_sure
    assert 'decimal: ",?"' in propose(tmp_path / "t.csv").text


def test_no_table(tmp_path):
    (tmp_path / "t.csv").write_text("a letter\nto nobody\n")
    with pytest.raises(LogError, match="no rows of two columns of numbers"):
        propose(tmp_path / "t.csv")


@pytest.mark.parametrize(
    ("one", "other", "are"),
    [("run3_pose", "run3_left", True), ("run3_pose", "run4_left", False), ("pose-3", "ft-3", True), ("a", "b", False)],
)
def test_files_of_one_run(one, other, are):
    assert is_akin(Path(f"{one}.csv"), Path(f"{other}.csv")) is are


def circling(tmp_path, header, *changes):
    """A push on a curve by one hand, with columns t, x, y, theta, fx, tz, some of them changed."""
    t = np.arange(0, 20, 0.02)
    u, r = 0.5 + 0.3 * np.sin(t), 0.4 * np.sin(0.7 * t)
    theta = np.cumsum(r) * 0.02
    x, y = np.cumsum(u * np.cos(theta)) * 0.02, np.cumsum(u * np.sin(theta)) * 0.02
    columns = [t, x, y, theta, 20 * 0.3 * np.cos(t) + 3 * u, 0.4 * r]
    for j, factor in changes:
        columns[j] = factor * columns[j]
    rows = (",".join(f"{value:.7f}" for value in row) for row in zip(*columns, strict=True))
    path = tmp_path / "mine.csv"
    path.write_text("\n".join([header, *rows]) + "\n")
    return path


LABELLED = "t_s,x_m,y_m,theta_rad,Fx_N,Mz_Nm"
BARE = "t,x,y,theta,Fx,Mz"


def asked(path):
    return {".".join(q.where): q.said for q in open_questions(parse_yaml(propose(path).text, "m"), "m")}


def test_only_what_nobody_can_see_is_asked_of_a_labelled_table(tmp_path):
    assert set(asked(circling(tmp_path, LABELLED))) == {"arms.arm.contact", "arms.arm.unmeasured"}


def test_what_numbers_say_of_units_without_labels(tmp_path):
    text = propose(circling(tmp_path, BARE, (0, 1e3), (1, 1e3), (2, 1e3), (3, 180 / np.pi), (4, 1e-3))).text
    for part in ("time: {column: t, unit: ms}", "column: x, unit: mm?", "column: theta, unit: deg}", "unit: kN?"):
        assert part in text


@pytest.mark.parametrize(
    ("change", "place", "said"),
    [
        (((3, -1.0),), "pose.theta.sign", "-1"),
        (((4, -1.0),), "arms.arm.force", "on_sensor"),
        (((0, 1e3),), "time.unit", "s"),
        (((1, 1e3), (2, 1e3)), "pose.x.unit", "m"),
        (((3, 180 / np.pi),), "pose.theta.unit", "rad"),
        (((4, 1e-3),), "arms.arm.force", "on_cart"),
    ],
)
def test_what_contradicts_physics_is_asked(tmp_path, change, place, said):
    assert asked(circling(tmp_path, LABELLED, *change))[place] == said


def test_a_way_that_hardly_turns_tells_no_sign(tmp_path):
    """Nor does one whose rows have no rate say anything of velocities' units."""
    t = np.arange(0, 20, 0.02)
    x, noise = t + 0.3 * np.sin(t), np.random.default_rng(0).normal(0, 1e-3, (2, len(t)))
    rows = "\n".join(
        f"{a:.6f},{b:.6f},{c:.6f},{d:.6f},0.0,0.0" for a, b, c, d in zip(x, *noise, 1 + 0.3 * np.cos(t), strict=True)
    )
    (tmp_path / "mine.csv").write_text(f"x_m,y_m,theta_rad,vx,vy,omega\n{rows}\n")
    questions = asked(tmp_path / "mine.csv")
    assert questions["pose.theta.sign"] == "1"
    assert questions["time"] is None
    assert "pose.vx.unit" in questions


def test_columns_that_nobody_knows_are_no_reason_to_believe_that_nobody_pushes(tmp_path):
    questions = asked(circling(tmp_path, "t_s,x_m,y_m,theta_rad,channel_7,channel_8"))
    assert "arms" in questions


def test_columns_that_are_taken_for_the_same_are_asked_about(tmp_path):
    """Else the first would be taken in silence: raw beside filtered forces, or a name that stands twice."""
    path = circling(tmp_path, "t_s,x_m,y_m,theta_rad,fx raw [N],fx filtered [N]")
    assert asked(path)["arms.arm.fx.column"] == "fx raw [N]"
    path = circling(tmp_path, "t_s,x_m,y_m,theta_rad,Fx_N,Fx_N")
    assert asked(path)["arms.arm.fx.column"] == "5"


@pytest.mark.parametrize("name", ["Fx #1 raw", "&Fx raw", "'Fx' raw", "Fx: raw"])
def test_a_guess_that_is_right_is_the_columns_name(tmp_path, name):
    """YAML would end it at its ` #`."""
    path = circling(tmp_path, f"t_s,x_m,y_m,theta_rad,{name},{name.replace('raw', 'filtered')}")
    text = propose(path).text
    assert [said for where, said in asked(path).items() if where.endswith("fx.column")] == [name]
    arms = without_marks(parse_yaml(text, "m"), "m")["arms"]
    assert [arm["fx"]["column"] for arm in arms.values()] == [name]


@pytest.mark.parametrize(
    ("text", "value"), [("1", 1), ("-0.5", -0.5), ("[1, 2]", [1, 2]), ("'1'", "1"), ('"a b"', "a b")]
)
def test_answers_are_read_as_yaml(text, value):
    assert value_of(text) == value


def test_a_moment_without_its_force_is_told(tmp_path):
    path = circling(tmp_path, "t_s,x_m,y_m,theta_rad,Fx_N,tz left [Nm]")
    assert propose(path).notes == ("tz left [Nm] is left out: tz, but no fx or fy is of the same part",)


def test_a_force_with_text_in_it_is_no_reason_to_believe_that_nobody_pushes(tmp_path):
    path = circling(tmp_path, LABELLED)
    lines = path.read_text().splitlines()
    lines[500] = ",".join([*lines[500].split(",")[:4], "#REF!", "OVL"])
    path.write_text("\n".join(lines) + "\n")
    assert "arms" in asked(path)
    told = "Fx_N is left out: line 501: '#REF!' is not a number (a missing sample is a blank cell or nan)"
    assert propose(path).notes[0] == told


def test_times_of_text_are_told(tmp_path):
    path = circling(tmp_path, LABELLED)
    names, *rows = path.read_text().splitlines()
    path.write_text("\n".join([names, *(f"2026-03-01 10:00:{row}" for row in rows)]) + "\n")
    assert "t_s holds text; write its times as seconds" in propose(path).text


def test_hostile_names_are_quoted(tmp_path):
    path = circling(tmp_path, 't_s,"x: [m] {b}",y_m,theta_rad,"Fx # é? [N]",Mz_Nm')
    document = parse_yaml(propose(path).text, "m")
    assert document["pose"]["x"]["column"] == "x: [m] {b}"
    assert document["arms"]["é"]["fx"]["column"] == "Fx # é? [N]"
