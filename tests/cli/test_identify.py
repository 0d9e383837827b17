"""`cartgrasp identify` on logs made by hand, on logs with holes, and on the real EMPS axis."""

from __future__ import annotations

import math

import numpy as np
import pytest

from cartgrasp.cart_file import load_cart

from .commands import run
from .pushed_cart import DX, DY, HEADER, MASS, as_csv, pushed_cart
from .test_estimate import EMPS, HOLES, PARAMETERS, UNITS, holes

GUESS = """\
name: a guess             # of somebody
mass: 18.0                # kg
com: [0.20, 0.00]
inertia: 1.5
constraints:
  - no_lateral_slip: {x: 0.0}
effects:
  viscous_drag: {linear: 2.0, angular: 1.0}
"""


@pytest.fixture(scope="module")
def weaving():
    return pushed_cart()


def identify(capsys, folder, tables, *flags, header=HEADER, cart=GUESS):
    logs = [folder / f"run{i}.csv" for i in range(len(tables))]
    for log, table in zip(logs, tables, strict=True):
        log.write_text(as_csv(table, header))
    (folder / "cart.yaml").write_text(cart, encoding="utf-8")
    return run(capsys, "identify", *logs, "--cart", folder / "cart.yaml", "--json", *flags)


def parameters(answer):
    assert answer.status == 0, answer.err
    document = answer.json
    assert set(document) == {"parameters", "logs", "checked"}
    for parameter in document["parameters"].values():
        assert set(parameter) == {"value", "std", "unit", "identifiable"}
        assert math.isfinite(parameter["value"])
        assert parameter["std"] >= 0
        assert isinstance(parameter["identifiable"], bool)
    return document["parameters"]


def test_a_weaving_cart_is_learned_and_saved(capsys, tmp_path, weaving):
    answer = identify(capsys, tmp_path, [weaving[1000:]], "--out", tmp_path / "new" / "folder")
    found = parameters(answer)
    assert list(found) == PARAMETERS
    assert [p["unit"] for p in found.values()] == UNITS
    for name, value in {"mass": MASS, "com_x": DX, "com_y": DY}.items():
        assert abs(found[name]["value"] - value) < 4 * found[name]["std"]
        assert found[name]["identifiable"]
    saved = tmp_path / "new" / "folder" / "cart.yaml"
    assert str(saved) in answer.err
    text = saved.read_text(encoding="utf-8")
    assert [line.split(":")[0] for line in text.splitlines()] == [line.split(":")[0] for line in GUESS.splitlines()]
    assert "# of somebody" in text
    assert load_cart(saved).inertia.mass == pytest.approx(found["mass"]["value"])


def test_two_logs(capsys, tmp_path, weaving):
    answer = identify(capsys, tmp_path, [weaving[800:1400], weaving[1400:]])
    assert abs(parameters(answer)["mass"]["value"] - MASS) < 4 * parameters(answer)["mass"]["std"]
    assert [log["name"] for log in answer.json["logs"]] == [str(tmp_path / f"run{i}.csv") for i in range(2)]


@pytest.mark.some(3)
@pytest.mark.parametrize("which", HOLES)
def test_samples_that_are_missing(capsys, tmp_path, weaving, which):
    found = parameters(identify(capsys, tmp_path, [holes(weaving, *HOLES[which])[::4]]))
    assert found["mass"]["value"] == pytest.approx(MASS, rel=0.05)


def test_without_velocity(capsys, tmp_path, weaving):
    keep = [i for i, name in enumerate(HEADER) if name not in ("vx", "vy", "omega")]
    found = parameters(identify(capsys, tmp_path, [weaving[::2, keep]], header=[HEADER[i] for i in keep]))
    assert found["mass"]["value"] == pytest.approx(MASS, rel=0.03)


@pytest.mark.parametrize("rows", [1, 2, 3, 8])
def test_short_logs(capsys, tmp_path, weaving, rows):
    found = parameters(identify(capsys, tmp_path, [weaving[:rows]]))
    assert found["mass"]["value"] == pytest.approx(18, rel=0.3)
    assert not found["mass"]["identifiable"]


def test_nothing_but_holes(capsys, tmp_path, weaving):
    everything = [name for name in HEADER if name != "t"]
    found = parameters(identify(capsys, tmp_path, [holes(weaving[:100], everything, -1, 99)]))
    assert found["mass"]["value"] == pytest.approx(18)
    assert not any(p["identifiable"] for p in found.values())


@pytest.mark.parametrize(
    "structure", ["[]", "[no_lateral_slip: {x: 0.1}]", "[no_lateral_slip: {x: 0}, no_rotation: {}]"]
)
def test_other_carts(capsys, tmp_path, weaving, structure):
    cart = GUESS.replace("\n  - no_lateral_slip: {x: 0.0}", f" {structure}")
    assert list(parameters(identify(capsys, tmp_path, [weaving[:600:3]], cart=cart))) == PARAMETERS


def test_casters_remember(capsys, tmp_path, weaving):
    wheels = "wheels:\n  - {kind: fixed, x: 0.0, y: 0.3}\n  - {kind: fixed, x: 0.0, y: -0.3}\n"
    wheels += "  - {kind: caster, x: 0.7, y: 0.2, trail: 0.05}\n  - {kind: caster, x: 0.7, y: -0.2, trail: 0.05}\n"
    cart = GUESS + "  caster_realignment: {swivel_torque: 0.1}\n" + wheels
    found = parameters(identify(capsys, tmp_path, [weaving[800:1600:2]], cart=cart))
    assert found["mass"]["value"] == pytest.approx(MASS, rel=0.03)


def test_the_table_for_people(capsys, tmp_path, weaving):
    identify(capsys, tmp_path, [weaving[:50]])
    answer = run(capsys, "identify", tmp_path / "run0.csv", "--cart", tmp_path / "cart.yaml")
    assert answer.status == 0
    assert "viscous_drag.linear" in answer.out
    assert "50 rows over 0.49 s; its sensors were not judged: 0.49 s at 100 Hz are too short" in answer.err


def test_refusals_are_one_line(capsys, tmp_path, weaving):
    good = as_csv(weaving[:20])
    (tmp_path / "cart.yaml").write_text(GUESS)
    log = tmp_path / "run.csv"
    arguments = ["identify", log, "--cart", tmp_path / "cart.yaml", "--json"]
    log.write_text(good.replace("theta", "thta", 1))
    run(capsys, *arguments).refused(3, f"{log}:1: theta")
    log.write_text(good)
    run(capsys, *arguments, "--out", log).refused(2, "--out", "can't be made")
    run(capsys, *arguments, log).refused(2, log, "is given twice")
    run(capsys, "identify", log).refused(2, "--cart is missing")
    run(capsys, "identify", "--cart", tmp_path / "cart.yaml").refused(2, "LOG")
    run(capsys, "identify", log, "--cart", tmp_path / "no.yaml").refused(2, "no.yaml")
    run(capsys, "identify", tmp_path / "no.csv", "--cart", tmp_path / "cart.yaml").refused(3, "no.csv")


@pytest.mark.parametrize("scale", [1e12, 1e100, 1e160, 1e300])
@pytest.mark.parametrize("columns", ["t", "pose", "velocity", "wrench", "contact"])
def test_numbers_beyond_reason(capsys, tmp_path, weaving, scale, columns):
    """They run, or are refused as data in one line; they never end in a traceback or a NaN."""
    table = weaving[800:860].copy()
    first, n = {"t": (0, 1), "pose": (1, 3), "velocity": (4, 3), "contact": (7, 3), "wrench": (10, 3)}[columns]
    table[20:, first : first + n] *= scale
    answer = identify(capsys, tmp_path, [table])
    if answer.status == 0:
        assert all(np.isfinite(p["std"]) for p in parameters(answer).values())
    else:
        answer.refused(3, tmp_path / "run0.csv")


@pytest.mark.skipif(not EMPS.is_file(), reason=f"the EMPS data set is not at {EMPS}")
def test_the_real_axis(capsys):
    """Janot, Gautier, Brunot (2019): 95.1089 kg, offset 3.16 N."""
    found = parameters(run(capsys, "identify", EMPS, "--json"))
    assert found["mass"]["value"] == pytest.approx(95.1, abs=0.5)
    assert found["mass"]["identifiable"]
    assert abs(found["mass"]["value"] - 95.1089) < 3 * found["mass"]["std"]
    bias = found["force_bias.fx"]
    assert abs(bias["value"] - -3.16) < 3 * bias["std"]
    assert not found["com_x"]["identifiable"]


@pytest.mark.parametrize("flags", [(), ("--json",)])
def test_a_sensor_of_an_arm_that_no_log_has_is_named(capsys, tmp_path, weaving, flags):
    (tmp_path / "run.csv").write_text(as_csv(weaving[::4]))
    strange = GUESS + "  force_bias: {gripper: {fx: 1.0}}\n  force_scale: {left: {gain: 1.0}}\n"
    (tmp_path / "cart.yaml").write_text(strange, encoding="utf-8")
    answer = run(capsys, "identify", tmp_path / "run.csv", "--cart", tmp_path / "cart.yaml", *flags)
    assert answer.status == 0, answer.err
    told = "a guess: force_bias.gripper: no log has that arm; there are left, right"
    assert (told in answer.err) == (not flags)
    assert "force_scale.left: no log" not in answer.err
