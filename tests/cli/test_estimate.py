"""`cartgrasp estimate` on logs made by hand, on logs with holes, and on the real EMPS axis."""

from __future__ import annotations

import csv
import io
import math
from pathlib import Path

import numpy as np
import pytest

from benchmarks.measured.carts import on_a_rail

from .commands import run
from .pushed_cart import DX, DY, HEADER, LINEAR, MASS, as_csv, pushed_cart

GUESS = """\
name: a guess
mass: 18.0
com: [0.20, 0.00]
inertia: 1.5
constraints:
  - no_lateral_slip: {x: 0.0}
effects:
  viscous_drag: {linear: 2.0, angular: 1.0}
"""
PARAMETERS = ["mass", "com_x", "com_y", "inertia", "viscous_drag.linear", "viscous_drag.angular"]
UNITS = ["kg", "m", "m", "kg·m²", "N·s/m", "N·m·s/rad"]
ONLINE = pytest.mark.parametrize("method", ["filter", "regressor"])
"""Both sit the same exam."""
EMPS = Path(__file__).parents[3] / "shared" / "data" / "emps" / "DATA_EMPS.mat"
WHEELCHAIR = EMPS.parents[1] / "real" / "wheelchair" / "push.csv"


@pytest.fixture(scope="module")
def weaving():
    return pushed_cart()


def estimate(capsys, folder, table, *flags, header=HEADER, cart=GUESS):
    (folder / "run.csv").write_text(as_csv(table, header))
    (folder / "cart.yaml").write_text(cart, encoding="utf-8")
    return run(capsys, "estimate", folder / "run.csv", "--cart", folder / "cart.yaml", "--json", *flags)


def parameters(answer):
    """The checked parameters: strict JSON, and every number there is finite."""
    assert answer.status == 0, answer.err
    assert answer.err == ""
    document = answer.json
    assert set(document) == {"time", "parameters", "health", "checked"}
    for parameter in document["parameters"].values():
        assert set(parameter) == {"value", "std", "unit", "identifiable"}
        assert math.isfinite(parameter["value"])
        assert parameter["std"] >= 0
        assert isinstance(parameter["identifiable"], bool)
    return document["parameters"]


@ONLINE
def test_a_weaving_cart_is_learned(capsys, tmp_path, weaving, method):
    out = tmp_path / "series.csv"
    answer = estimate(capsys, tmp_path, weaving, "--out", out, "--method", method)
    found = parameters(answer)
    assert list(found) == PARAMETERS
    assert [p["unit"] for p in found.values()] == UNITS
    assert answer.json["time"] == pytest.approx(19.99)
    assert answer.json["health"] == "ok"
    assert found["mass"]["value"] == pytest.approx(MASS, rel=0.03)
    assert found["com_x"]["value"] == pytest.approx(DX, abs=0.02)
    assert found["com_y"]["value"] == pytest.approx(DY, abs=0.02)
    assert found["viscous_drag.linear"]["value"] == pytest.approx(LINEAR, abs=1.0)
    assert all(found[name]["identifiable"] for name in ("mass", "com_x", "com_y", "inertia"))
    rows = list(csv.DictReader(io.StringIO(out.read_text())))
    assert list(rows[0]) == ["t", *(f"{p}{s}" for p in PARAMETERS for s in ("", ".std")), "health"]
    assert len(rows) == len(weaving)
    assert float(rows[0]["mass"]) == pytest.approx(18)
    for name in PARAMETERS:
        assert float(rows[-1][name]) == found[name]["value"]
        assert float(rows[-1][f"{name}.std"]) == found[name]["std"]


def test_errors_are_as_large_as_they_are_said_to_be(capsys, tmp_path):
    truth = {"mass": MASS, "com_x": DX, "com_y": DY, "viscous_drag.linear": LINEAR}
    scores = []
    for seed in range(1, 2):
        found = parameters(estimate(capsys, tmp_path, pushed_cart(seed=seed)))
        scores += [(found[name]["value"] - value) / found[name]["std"] for name, value in truth.items()]
    assert np.abs(scores).max() < 4.5


@pytest.mark.some(1)
@ONLINE
def test_a_straight_run_teaches_neither_com_x_nor_inertia(capsys, tmp_path, method):
    found = parameters(estimate(capsys, tmp_path, pushed_cart(curves=False), "--method", method))
    assert not found["com_x"]["identifiable"]
    assert not found["inertia"]["identifiable"]
    assert found["mass"]["identifiable"]
    assert found["mass"]["value"] == pytest.approx(MASS, rel=0.03)


@pytest.mark.some(1)
@ONLINE
def test_without_velocity(capsys, tmp_path, weaving, method):
    keep = [i for i, name in enumerate(HEADER) if name not in ("vx", "vy", "omega")]
    found = parameters(
        estimate(capsys, tmp_path, weaving[::2, keep], "--method", method, header=[HEADER[i] for i in keep])
    )
    assert found["mass"]["value"] == pytest.approx(MASS, rel=0.05)


def holes(table, columns, start, stop):
    table = table.copy()
    rows = (table[:, 0] > start) & (table[:, 0] < stop)
    for name in columns:
        table[rows, HEADER.index(name)] = np.nan
    return table


HOLES = {
    "velocity for a while": (["vx", "vy", "omega"], 3, 9),
    "velocity from the first row": (["vx", "vy", "omega"], -1, 4),
    "one component of the velocity": (["vy"], 3, 9),
    "pose for a while": (["x", "y", "theta"], 9, 11),
    "pose at first": (["x", "y", "theta"], -1, 1),
    "heading at first": (["theta"], -1, 1),
    "an arm for a while": ([f"right.{p}" for p in ("fx", "fy", "fz", "tx", "ty", "tz")], 9, 11),
    "an arm at first": ([f"right.{p}" for p in ("fx", "fy", "fz", "tx", "ty", "tz")], -1, 1),
    "one axis of an arm": (["left.fx"], 9, 11),
    "contacts but the first": ([f"left.{p}" for p in ("px", "py", "pz")], 0.005, 99),
}


@pytest.mark.some(3)
@ONLINE
@pytest.mark.parametrize("which", HOLES)
def test_samples_that_are_missing(capsys, tmp_path, weaving, which, method):
    found = parameters(estimate(capsys, tmp_path, holes(weaving, *HOLES[which])[::2], "--method", method))
    assert found["mass"]["value"] == pytest.approx(MASS, rel=0.1)


@pytest.mark.some(2)
@pytest.mark.parametrize("method", ["filter", "regressor", "paper"])
def test_a_gap_of_three_seconds(capsys, tmp_path, weaving, method):
    t = weaving[:, 0]
    answer = estimate(capsys, tmp_path, weaving[(t < 9) | (t > 12)][::2], "--method", method)
    found = parameters(answer)
    if method != "paper":
        assert found["mass"]["value"] == pytest.approx(MASS, rel=0.05)


@ONLINE
def test_nothing_but_holes(capsys, tmp_path, weaving, method):
    everything = [name for name in HEADER if name != "t"]
    answer = estimate(capsys, tmp_path, holes(weaving[:100], everything, -1, 99), "--method", method)
    found = parameters(answer)
    assert found["mass"]["value"] == pytest.approx(18)
    assert not any(p["identifiable"] for p in found.values())
    assert answer.json["health"] == "stale"


@ONLINE
def test_no_wrench_at_all(capsys, tmp_path, weaving, method):
    forces = [name for name in HEADER if name.split(".")[-1] in ("fx", "fy", "fz", "tx", "ty", "tz")]
    answer = estimate(capsys, tmp_path, holes(weaving[:600:2], forces, -1, 99), "--method", method)
    assert answer.json["health"] == "no_wrench"
    assert not parameters(answer)["mass"]["identifiable"]


@pytest.mark.parametrize("rows", [1, 2, 3, 8])
@pytest.mark.parametrize("method", ["filter", "regressor", "paper"])
def test_short_logs(capsys, tmp_path, weaving, rows, method):
    found = parameters(estimate(capsys, tmp_path, weaving[:rows], "--method", method))
    assert found["mass"]["value"] == pytest.approx(18, rel=0.2)


def test_the_literal_filter(capsys, tmp_path, weaving):
    answer = estimate(capsys, tmp_path, weaving[:300], "--method", "paper")
    assert list(parameters(answer))[:4] == PARAMETERS[:4]
    assert answer.json["health"] in ("paper_literal", "diverged")
    rail = GUESS.replace("{x: 0.0}\n", "{x: 0.0}\n  - no_rotation: {}\n")
    estimate(capsys, tmp_path, weaving[:9], "--method", "paper", cart=rail).refused(2, "one rolling constraint")


@pytest.mark.some(3)
@pytest.mark.parametrize(
    "structure", ["[]", "[no_lateral_slip: {x: 0.1}]", "[no_lateral_slip: {x: 0}, no_rotation: {}]"]
)
@ONLINE
def test_other_carts(capsys, tmp_path, weaving, structure, method):
    cart = GUESS.replace("\n  - no_lateral_slip: {x: 0.0}", f" {structure}")
    assert list(parameters(estimate(capsys, tmp_path, weaving[:600:3], "--method", method, cart=cart))) == PARAMETERS


def test_the_table_for_people(capsys, tmp_path, weaving):
    estimate(capsys, tmp_path, weaving[:50])
    answer = run(capsys, "estimate", tmp_path / "run.csv", "--cart", tmp_path / "cart.yaml")
    assert answer.status == 0
    assert [line.split()[0] for line in answer.out.splitlines()[3:9]] == PARAMETERS
    assert "50 rows over 0.49 s; its sensors were not judged: 0.49 s at 100 Hz are too short" in answer.err


def test_the_table_leaves_out_what_stands_as_the_file_has_it(capsys, tmp_path, weaving):
    cart = GUESS + "  caster_realignment: {swivel_torque: 0.3, trail: 0.06}\n"
    told = parameters(estimate(capsys, tmp_path, weaving[:50], cart=cart))
    stands = {name for name, one in told.items() if one["std"] == 0.0}
    assert "caster_realignment.trail" in stands
    answer = run(capsys, "estimate", tmp_path / "run.csv", "--cart", tmp_path / "cart.yaml")
    assert {name for name in told if name in answer.out} == told.keys() - stands


def test_refusals_are_one_line(capsys, tmp_path, weaving):
    good = as_csv(weaving[:20])
    (tmp_path / "cart.yaml").write_text(GUESS)
    log = tmp_path / "run.csv"
    arguments = ["estimate", log, "--cart", tmp_path / "cart.yaml", "--json"]
    lines = good.splitlines()
    for content, place in (
        ("", f"{log}:1"),
        (lines[0], f"{log}:2"),
        (good.replace("theta", "thta", 1), f"{log}:1: theta"),
        ("\n".join([*lines[:5], lines[3], *lines[5:]]), f"{log}:6: t"),
        ("\n".join([*lines[:5], lines[5] + ",1", *lines[6:]]), f"{log}:6"),
    ):
        log.write_text(content)
        run(capsys, *arguments).refused(3, place)
    log.write_text(good)
    run(capsys, *arguments, "--method", "magic").refused(2, "--method", "magic", "filter")
    run(capsys, *arguments, "--out", tmp_path / "nowhere" / "s.csv").refused(2, "--out", "nowhere")
    run(capsys, *arguments, "--out", tmp_path).refused(2, "--out", "is a folder")
    (tmp_path / "cart.yaml").write_text(GUESS.replace("mass: 18.0", "mass: -18.0"))
    run(capsys, *arguments).refused(2, f"{tmp_path / 'cart.yaml'}:2:1: mass", "-18")
    run(capsys, "estimate", log, "--cart", tmp_path / "no.yaml").refused(2, "no.yaml")
    run(capsys, "estimate", tmp_path / "no.mat").refused(3, "no.mat", "no such file")


@pytest.mark.some(8)
@pytest.mark.parametrize("scale", [1e12, 1e100, 1e160, 1e300])
@pytest.mark.parametrize("columns", ["pose", "velocity", "wrench", "contact"])
def test_numbers_beyond_reason(capsys, tmp_path, weaving, scale, columns):
    """They run, or are refused as data in one line; they never end in a traceback or a NaN."""
    table = weaving[:60].copy()
    first = {"pose": 1, "velocity": 4, "contact": 7, "wrench": 10}[columns]
    table[20:, first : first + 3] *= scale
    for method in ("filter", "regressor", "paper"):
        answer = estimate(capsys, tmp_path, table, "--method", method)
        if answer.status == 0:
            assert set(answer.json) == {"time", "parameters", "health", "checked"}
        else:
            answer.refused(3, tmp_path / "run.csv")


@pytest.mark.some(4)
@pytest.mark.parametrize("value", ["1.0e-300", "1.0e-9", "1.0e+5", "1.0e+9", "1.0e+15", "1.0e+300"])
@pytest.mark.parametrize("key", ["mass: 18.0", "inertia: 1.5", "linear: 2.0", "angular: 1.0", "0.20"])
def test_a_cart_beyond_reason(capsys, tmp_path, weaving, key, value):
    """As above; what its file may hold and no floor carries."""
    cart = GUESS.replace(key, f"{key.split(':')[0]}: {value}" if ":" in key else value)
    assert cart != GUESS
    for method in ("filter", "regressor", "paper"):
        answer = estimate(capsys, tmp_path, weaving[:600:4], "--method", method, cart=cart)
        if answer.status == 0:
            assert set(answer.json) == {"time", "parameters", "health", "checked"}
        else:
            answer.refused(answer.status)
            assert answer.status in (2, 3)


@ONLINE
def test_a_gap_beyond_reason(capsys, tmp_path, weaving, method):
    for jump in (1e6, 1e150, 1e300):
        table = weaving[:60].copy()
        table[30:, 0] = jump * np.arange(1, 31)
        answer = estimate(capsys, tmp_path, table, "--method", method)
        assert answer.status in (0, 3)
        if answer.status == 3:
            answer.refused(3, tmp_path / "run.csv")


@pytest.mark.skipif(not WHEELCHAIR.is_file(), reason=f"the measured log is not at {WHEELCHAIR}")
def test_a_person_who_leans_teaches_nothing(capsys, tmp_path):
    """On a rolling wheelchair no rigid body fits force and motion (the data's README): the filter says so, and why."""
    cart = tmp_path / "cart.yaml"
    on_a_rail("wheelchair", 110.0, 2.0).save(cart)
    shown = run(capsys, "estimate", WHEELCHAIR, "--cart", cart, "--out", tmp_path / "series.csv")
    assert (tmp_path / "series.csv").read_text(encoding="utf-8").splitlines()[-1].endswith(",inconsistent")
    assert "does not fit this log, so it taught nothing" in shown.out
    assert " yes\n" not in shown.out
    assert "mass is not identifiable" not in shown.out


@pytest.mark.skipif(not EMPS.is_file(), reason=f"the EMPS data set is not at {EMPS}")
def test_the_real_axis(capsys):
    """Janot, Gautier, Brunot (2019), known from a long fit of all of it: 95.1089 kg, offset 3.16 N."""
    answer = run(capsys, "estimate", EMPS, "--json")
    found = parameters(answer)
    mass = found["mass"]
    assert abs(mass["value"] - 95.1089) < 2 * mass["std"] < 0.01 * 95.1089
    assert found["mass"]["identifiable"]
    assert {"viscous_drag.linear", "rolling_resistance.coefficient", "force_bias.fx"} <= set(found)
    assert 150 < found["viscous_drag.linear"]["value"] < 250
    bias = found["force_bias.fx"]
    assert abs(bias["value"] - -3.16) < 3 * bias["std"]
    assert not found["com_x"]["identifiable"]
