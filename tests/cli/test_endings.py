"""How commands end: help, exit statuses, one line on stderr, JSON alone on stdout; and the slow commands' wiring."""

from __future__ import annotations

import json
from types import SimpleNamespace
from typing import ClassVar

import numpy as np
import pytest

from cartgrasp.cli import demo, estimate, log_inputs, main, output, plan, simulate, table1
from cartgrasp.errors import CartgraspError, DataError, PlantError, UsageError
from cartgrasp.logs import ArmLog, RunLog, read_log

from .commands import CART, PROBLEM, RAIL, problem_file, run, run_apart

STUDIES = (["study", "table1"], ["study", "excitation"], ["study", "robust"])


def test_plan_in_a_process_of_its_own(tmp_path):
    answer = run_apart("plan", problem_file(tmp_path), "--json")
    assert answer.status == 0
    assert answer.err == ""
    assert answer.json["status"] == "optimal"
    answer = run_apart("plan", tmp_path / "nowhere.yaml", "--json")
    answer.refused(2, "nowhere.yaml", "No such file")


def test_the_table_for_people(tmp_path, capsys):
    answer = run(capsys, "plan", problem_file(tmp_path))
    assert answer.status == 0
    assert answer.err == ""
    assert "left" in answer.out
    assert "effort" in answer.out
    path = problem_file(tmp_path, PROBLEM.replace("[40.0, 0.0, 3.0]", "[400.0, 0.0, 3.0]"))
    answer = run(capsys, "plan", path)
    assert answer.status == 1
    assert answer.out.startswith("infeasible: ")
    assert "nearest feasible wrench" in answer.out


@pytest.mark.parametrize(
    ("arguments", "parts"),
    [
        (["nosuch"], ["nosuch", "cartgrasp --help"]),
        (["plan"], ["PROBLEM", "cartgrasp plan --help"]),
        (["plan", "a.yaml", "b.yaml"], ["b.yaml", "--help"]),
        (["plan", "a.yaml", "--fast"], ["--fast", "--help"]),
        (["estimate"], ["LOG", "--help"]),
        (["estimate", "run.csv"], ["--cart"]),
        (["estimate", "run.csv", "--method", "magic"], ["--method", "magic", "filter", "paper"]),
        (["estimate", "run.csv", "--cart"], ["--cart"]),
        (["simulate"], ["--cart"]),
        (["simulate", "--cart", "c.yaml", "--arms", "9"], ["--arms", "4"]),
        (["simulate", "--cart", "c.yaml", "--seed", "-1"], ["--seed", "0"]),
        (["simulate", "--cart", "c.yaml", "--speed", "fast"], ["--speed", "number"]),
        (["demo", "--seed", "x"], ["--seed"]),
        (["demo", "--seed", "-3"], ["--seed"]),
        (["study", "nosuch"], ["nosuch", "cartgrasp study --help"]),
        (["study", "table1", "--rows", "12"], ["--rows 12", "1 to 11"]),
        (["study", "table1", "--rows", "one"], ["--rows one", "1 to 11"]),
        (["study", "table1", "--rows", ","], ["--rows ,", "1 to 11"]),
        (["study", "table1", "--seed", "-1"], ["--seed"]),
    ],
    ids=" ".join,
)
def test_wrong_usage(capsys, arguments, parts):
    run(capsys, *arguments).refused(2, *parts)


@pytest.mark.parametrize("command", [[], ["study"]])
def test_no_command(capsys, command):
    answer = run(capsys, *command)
    assert answer.status == 2
    assert "Usage" in answer.out
    assert len(answer.err.splitlines()) == 1
    assert "--help" in answer.err


@pytest.mark.parametrize(
    ("error", "status"),
    [
        (UsageError("a: why"), 2),
        (CartgraspError("b: why"), 2),
        (DataError("c: why"), 3),
        (PlantError("d: why"), 3),
        (KeyboardInterrupt(), 130),
    ],
)
@pytest.mark.parametrize("command", [plan, estimate, simulate, demo, table1])
def test_every_error_has_its_status(capsys, monkeypatch, tmp_path, command, error, status):
    def fail(*arguments):
        raise error

    arguments = {
        plan: ["plan", "p.yaml"],
        estimate: ["estimate", "run.csv"],
        simulate: ["simulate", "--cart", "c.yaml"],
        demo: ["demo"],
        table1: ["study", "table1"],
    }[command]
    monkeypatch.setattr(command, "run", fail)
    answer = run(capsys, *arguments)
    assert answer.status == status
    assert answer.out == ""
    if status == 130:
        assert answer.err.strip() in ("", "cartgrasp: interrupted")
    else:
        assert answer.err == f"cartgrasp: {error}\n"


def test_interrupted_within_the_progress_bar(capsys, monkeypatch, tmp_path):
    def stop(*arguments):
        raise KeyboardInterrupt

    pushed = RunLog(np.arange(3.0), np.zeros((3, 3)), None, {"hand": ArmLog(np.ones((3, 3)), np.ones((3, 6)))})
    monkeypatch.setattr(log_inputs, "load_cart", lambda path: None)
    monkeypatch.setattr(log_inputs, "read_log", lambda path, topics: pushed)
    monkeypatch.setattr(estimate, "as_replayed", stop)
    answer = run(capsys, "estimate", "run.csv", "--cart", "cart.yaml", "--json")
    assert answer.status == 130
    assert answer.out == ""
    assert answer.err.strip() in ("", "cartgrasp: interrupted")


def test_one_line_whatever_a_name_holds(capsys, tmp_path):
    for name in ("a\nb.yaml", "a\u2028b.yaml", "a\rb.yaml", "a\x1b[31mb.yaml", "é b.yaml"):
        run(capsys, "plan", tmp_path / name).refused(2, "No such file")
        run(capsys, "estimate", (tmp_path / name).with_suffix(".csv"), "--cart", "c.yaml").refused(2, "c.yaml")
    path = problem_file(tmp_path, PROBLEM + '"a\\nb": 3\n')
    run(capsys, "plan", path).refused(2, f"{path}:15:1", "a\\nb", "unknown key")


@pytest.mark.parametrize("name", ['"a\\0b"', '"\\ud800"', f"{'x' * 5000}", "''", "."])
def test_a_cart_that_no_file_can_be(capsys, tmp_path, name):
    path = problem_file(tmp_path, PROBLEM.replace("cart.yaml", name))
    run(capsys, "plan", path).refused(2)


def test_json_is_ascii_where_stdout_is(capsys, tmp_path):
    log = tmp_path / "run.csv"
    arm = [f"left.{c}" for c in ("px", "py", "pz", "fx", "fy", "fz", "tx", "ty", "tz")]
    lines = [",".join(["t", "x", "y", "theta", *arm])]
    lines += [",".join([str(0.01 * i), *["0"] * 6, *["1"] * 6]) for i in range(20)]
    log.write_text("\n".join(lines))
    problem_file(tmp_path)
    arguments = ["estimate", log, "--cart", tmp_path / "cart.yaml", "--json"]
    plain, unicode = run_apart(*arguments, PYTHONIOENCODING="ascii"), run(capsys, *arguments)
    assert plain.status == unicode.status == 0
    assert plain.err == unicode.err == ""
    assert plain.out.isascii()
    assert plain.json == unicode.json
    assert plain.json["parameters"]["inertia"]["unit"] == "kg·m²"


def test_a_reader_that_goes_away(capsys, monkeypatch):
    def broken(*arguments):
        raise BrokenPipeError

    monkeypatch.setattr(plan, "run", broken)
    monkeypatch.setattr("cartgrasp.cli.app.sys.stderr", SimpleNamespace(close=lambda: None), raising=False)
    assert main(["plan", "p.yaml"]) == 1


def test_strict_json(capsys):
    output.print_json({"a": float("nan"), "b": [float("inf"), 1.0, (2, None)], 3: "µ"})
    text = capsys.readouterr().out
    assert json.loads(text) == {"a": None, "b": [None, 1.0, [2, None]], "3": "µ"}
    assert text.endswith("\n")


# --- slow commands, with what is slow taken out -------------------------------------------------------------


class Figures:
    parameters: ClassVar = {
        name: {"truth": 1.0, "value": 1.0, "std": 0.1, "unit": "kg", "identifiable": True}
        for name in ("mass", "com_x", "com_y", "inertia", "viscous_drag.linear")
    }
    duration = largest_error = error_after_5 = rms_error = largest_force = 1.0
    optimal = plans = regrasps = 1
    health = "ok"

    @classmethod
    def of(cls, record):
        return cls()

    def as_dict(self):
        return {"parameters": self.parameters}


@pytest.mark.parametrize("as_json", [True, False])
def test_demo_is_wired(capsys, monkeypatch, tmp_path, as_json):
    asked = []

    def scenario(*arguments):
        asked.append(arguments)
        return SimpleNamespace(run=lambda tell: tell(1.0))

    monkeypatch.setattr(demo, "scenario", scenario)
    monkeypatch.setattr(demo, "save_run", lambda *a, **k: None)
    monkeypatch.setattr(demo, "RunFigures", Figures)
    out = tmp_path / "deep" / "er"
    answer = run(capsys, "demo", "--quick", "--seed", "4", "--out", out, *(["--json"] if as_json else []))
    assert answer.status == 0
    assert asked == [(True, True, 4), (False, True, 4)]
    assert sorted(p.name for p in out.iterdir()) == ["first_guess.yaml", "true_cart.yaml"]
    assert str(out) in answer.err
    if as_json:
        assert set(answer.json) == {"run", "left_out", "out", "seed"}


@pytest.mark.parametrize(("holds", "status"), [(True, 0), (False, 1)])
@pytest.mark.parametrize("as_json", [True, False])
def test_table1_is_wired(capsys, monkeypatch, tmp_path, holds, status, as_json):
    from cartgrasp.studies.findings import Claim

    claim = Claim("test 5", "mass within 5 %", "3 %", holds)
    asked = {}

    def run_rows(rows, seed, workers, tell):
        asked.update(rows=[r.test for r in rows], seed=seed)
        return [SimpleNamespace(row=row) for row in rows]

    monkeypatch.setattr(table1, "run_rows", run_rows)
    monkeypatch.setattr(table1, "gain_curve", lambda *a: [])
    monkeypatch.setattr(table1, "row_claims", lambda result: [claim])
    monkeypatch.setattr(table1, "paper_claims", lambda results, curve: [claim])
    monkeypatch.setattr(table1, "comparison", lambda result: ("1 cm", "2 cm", "3 cm"))
    monkeypatch.setattr(table1, "save_plots", lambda *a: None)
    flags = ["--json"] if as_json else []
    answer = run(capsys, "study", "table1", "--rows", "5, 1", "--seed", "7", "--out", tmp_path / "t", *flags)
    assert answer.status == status
    assert asked == {"rows": [5, 1], "seed": 7}
    assert (tmp_path / "t" / "table1.md").read_text().startswith("# Table I")
    if as_json:
        assert answer.json["kept"] is holds
        assert [row["test"] for row in answer.json["tracking_error"]] == ["5", "1"]


def test_out_that_is_a_file(capsys, tmp_path):
    (tmp_path / "cart.yaml").write_text(CART)
    for command in (
        ["demo"],
        ["simulate", "--cart", tmp_path / "cart.yaml"],
        *STUDIES,
    ):
        run(capsys, *command, "--out", tmp_path / "cart.yaml").refused(2, "--out", "name another folder")


def test_simulate_refuses(capsys, tmp_path):
    cart, rail = tmp_path / "cart.yaml", tmp_path / "rail.yaml"
    cart.write_text(CART)
    rail.write_text(RAIL)
    for arguments, parts in (
        (["--path", "zigzag"], ["--path", "zigzag", "'straight', 'curves', 'push-pull'"]),
        (["--plant", "gazebo"], ["--plant", "gazebo", "'model', 'mujoco'"]),
        (["--speed", "0"], ["--speed 0", "0.05 to 3"]),
        (["--speed", "nan"], ["--speed nan"]),
        (["--force-noise", "-1"], ["--force-noise -1"]),
        (["--force-noise", "nan"], ["--force-noise nan"]),
        (["--force-noise", "inf"], ["--force-noise inf"]),
        (["--force-noise", "1e300"], ["--force-noise 1e+300", "0 to 10000 N"]),
        (["--confidence", "0.99"], ["--confidence", "--skid or --tip-over"]),
        (["--tip-over", "5", "--confidence", "1.5"], ["--confidence 1.5", "0.5 to below 1"]),
        (["--skid", "-1"], ["--skid", "friction"]),
        (["--guess", str(rail)], ["--guess", "constraints"]),
        (["--guess", str(tmp_path / "no.yaml")], ["no.yaml"]),
    ):
        run(capsys, "simulate", "--cart", cart, "--out", tmp_path / "o", *arguments).refused(2, *parts)
    run(capsys, "simulate", "--cart", rail, "--out", tmp_path / "o").refused(2, "--path curves", "rail")
    assert not (tmp_path / "o").exists()


def test_simulate_leaves_a_log_that_estimate_reads(capsys, monkeypatch, tmp_path):
    from planning.references import chain, pause, straight

    (tmp_path / "cart.yaml").write_text(CART)
    monkeypatch.setattr(simulate, "named_path", lambda *a: chain(straight(0.6, 0.6, 0.6), pause(0.2)))
    out = tmp_path / "run"
    answer = run(capsys, "simulate", "--cart", tmp_path / "cart.yaml", "--arms", "2", "--out", out, "--json")
    assert answer.status == 0
    assert answer.json["run"]["plans"] == answer.json["run"]["optimal"]
    assert {"run.csv", "truth.csv", "player.html", "overview.png"} <= {p.name for p in out.iterdir()}
    answer = run(capsys, "estimate", out / "run.csv", "--cart", tmp_path / "cart.yaml", "--json")
    assert answer.status == 0
    assert answer.json["parameters"]["mass"]["value"] == pytest.approx(24, rel=0.2)


def test_simulate_keeps_limits_of_the_cart(capsys, monkeypatch, tmp_path):
    """Less load on the wheel that bears least, where nothing keeps it; and what pushes beside is looked for."""
    from planning.references import chain, pause, straight

    (tmp_path / "cart.yaml").write_text(CART)
    monkeypatch.setattr(simulate, "named_path", lambda *a: chain(straight(1.0, 0.8, 1.2), pause(0.2)))
    told = []
    for more in ([], ["--skid", "0.6", "--tip-over", "30", "--confidence", "0.9", "--caution", "--disturbances"]):
        out = tmp_path / f"run{len(told)}"
        answer = run(capsys, "simulate", "--cart", tmp_path / "cart.yaml", "--out", out, "--json", *more)
        assert answer.status == 0
        log = read_log(out / "run.csv")
        told.append(min(sum(arm.wrench[:, 0] for arm in log.arms.values())))
    assert told[1] > 0.9 * told[0]  # pulls back less


@pytest.mark.some(2)
@pytest.mark.parametrize("way", ["periodic", "least-effort", "teach", "schedule"])
def test_simulate_chooses_contacts(capsys, monkeypatch, tmp_path, way):
    """Each way says what it does and why; a hand that goes round is logged on its way, with a wrench of zero."""
    from planning.references import chain, pause, straight

    (tmp_path / "cart.yaml").write_text(CART)
    monkeypatch.setattr(simulate, "named_path", lambda *a: chain(straight(2.0, 0.6, 0.6), pause(0.2)))
    out = tmp_path / "run"
    answer = run(
        capsys, "simulate", "--cart", tmp_path / "cart.yaml", "--contacts", way, "--no-learn", "--out", out, "--json"
    )
    assert answer.status == 0
    told = {"periodic": "goes round", "least-effort": "least effort", "teach": "", "schedule": "of the schedule"}
    assert all(told[way] in hands["words"] for hands in answer.json["hands"])
    log = read_log(out / "run.csv")
    for arm in log.arms.values():
        moving = np.abs(np.diff(arm.contact, axis=0)).max(axis=1) > 0
        speed = np.linalg.norm(np.diff(arm.contact, axis=0), axis=1) / np.diff(log.time)
        assert speed.max() <= 0.5 * (1 + 1e-3)
        assert (arm.wrench[1:][moving] == 0).all()
        if way == "periodic":
            assert moving.any()
