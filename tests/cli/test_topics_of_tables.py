"""`topics` of tables, and tables where logs are asked for."""

from __future__ import annotations

import json

import numpy as np
import pytest

from cartgrasp.logs import read_log

from .commands import CART, run
from .pushed_cart import HEADER, as_csv, pushed_cart

NAMES = ["time [ms]", "x [mm]", "y [mm]", "yaw [deg]"]
HAND = {"fx": "N", "fy": "N", "tz": "N·m"}


@pytest.fixture(scope="module")
def push():
    """Of two hands, in the columns of a run log."""
    return pushed_cart()


@pytest.fixture
def table(tmp_path, push):
    """The same as a stranger has it: ms, mm, wrapped degrees, planar sensors."""
    return table_of(tmp_path, push)


@pytest.fixture
def short_table(tmp_path, push):
    """Eight seconds of it."""
    return table_of(tmp_path, push[600:1400])


def table_of(tmp_path, push):
    columns = dict(zip(HEADER, push.T, strict=True))
    degrees = (np.degrees(columns["theta"]) + 180) % 360 - 180
    kept = [1e3 * columns["t"], 1e3 * columns["x"], 1e3 * columns["y"], degrees]
    names = list(NAMES)
    for hand in ("left", "right"):
        for part, unit in HAND.items():
            kept.append(columns[f"{hand}.{part}"])
            names.append(f"{hand} {part} [{unit}]")
    path = tmp_path / "mine.csv"
    path.write_text(as_csv(np.column_stack(kept), names), encoding="utf-8")
    (tmp_path / "cart.yaml").write_text(CART)
    return path


def filled(text):
    contacts = iter(("[-0.25, 0.2, 1.0]", "[-0.25, -0.2, 1.0]"))
    lines = [
        line.replace("contact:", f"contact: {next(contacts)}") if "contact:" in line else line
        for line in text.splitlines()
    ]
    return "\n".join(lines) + "\n"


def own_map(table):
    return table.with_name("mine.csv.topics.yaml")


def test_from_a_table_to_a_map_to_a_log(capsys, table, push):
    answer = run(capsys, "topics", table, "--json").json
    taken = {one["column"]: (one["taken_for"], one["unit"]) for one in answer["columns"]}
    assert taken["yaw [deg]"] == ("theta", "deg")
    assert taken["left fx [N]"] == ("fx", "N")
    assert {q["where"] for q in answer["questions"]} == {"arms.left.contact", "arms.right.contact"}
    assert run(capsys, "topics", table, "--out", own_map(table)).status == 0
    assert own_map(table).read_text(encoding="utf-8") == answer["proposal"]
    run(capsys, "topics", table, "--out", own_map(table)).refused(2, "is there already")
    told = run(capsys, "convert", table, "--out", table.with_name("run.csv"))
    told.refused(2, f"{own_map(table)}:", "arms.left.contact: is not stated", "arms.right.contact", "docs/tables.md")
    own_map(table).write_text(filled(answer["proposal"]), encoding="utf-8")
    assert run(capsys, "convert", table, "--out", table.with_name("run.csv")).status == 0
    log = read_log(table.with_name("run.csv"))
    columns = dict(zip(HEADER, push.T, strict=True))
    assert np.allclose(log.pose, np.column_stack([columns[k] for k in ("x", "y", "theta")]), atol=1e-9)
    assert np.allclose(log.arms["left"].wrench[:, [0, 1, 5]], push[:, [10, 11, 15]], atol=1e-9)
    document = json.loads(table.with_name("run.csv.provenance.json").read_text())
    assert document["topics"]["pose"]["x"]["unit"] == "mm"
    assert any("x [mm] mm" in str(step.values()) for step in document["steps"])


def test_every_command_takes_it_as_it_takes_a_run_log(capsys, short_table, tmp_path):
    table = short_table
    proposal = run(capsys, "topics", table, "--json").json["proposal"]
    (tmp_path / "a map.yaml").write_text(filled(proposal), encoding="utf-8")
    given = ("--topics", tmp_path / "a map.yaml")
    assert run(capsys, "convert", table, *given, "--out", tmp_path / "run.csv").status == 0
    for command in (["estimate"], ["identify"], ["check"]):
        ours = run(capsys, *command, table, *given, "--cart", tmp_path / "cart.yaml", "--json")
        theirs = run(capsys, *command, tmp_path / "run.csv", "--cart", tmp_path / "cart.yaml", "--json")
        assert ours.status == theirs.status == 0
        assert _numbers(ours.json) == pytest.approx(_numbers(theirs.json), rel=1e-6, abs=1e-9)
    assert run(capsys, "view", table, *given, "--out", tmp_path / "page.html").status == 0


def test_a_map_leaves_run_logs_beside_its_tables_alone(capsys, short_table, tmp_path):
    """Such as `simulate` writes them; alone, a log that a map does not fit is refused."""
    table = short_table
    own_map(table).write_text(filled(run(capsys, "topics", table, "--json").json["proposal"]), encoding="utf-8")
    (tmp_path / "run.csv").write_text(as_csv(pushed_cart(seed=1)[600:1400]), encoding="utf-8")
    options = "--topics", own_map(table), "--cart", tmp_path / "cart.yaml"
    answer = run(capsys, "identify", table, tmp_path / "run.csv", *options, "--json")
    assert answer.status == 0, answer.err
    assert f"run.csv: is read without {own_map(table)}, as a run log" in answer.err
    assert [one["words"] for one in answer.json["logs"]] == [[], []]
    run(capsys, "identify", tmp_path / "run.csv", *options).refused(3, "there is no such column")
    (tmp_path / "other.csv").write_text("a,b\n1,2\n", encoding="utf-8")
    run(capsys, "identify", table, tmp_path / "other.csv", *options).refused(3, "other.csv", "there is no such column")


def _numbers(document):
    """All that are in a document, in order."""
    if isinstance(document, dict):
        return [n for value in document.values() for n in _numbers(value)]
    if isinstance(document, list):
        return [n for value in document for n in _numbers(value)]
    return [document] if isinstance(document, float) else []


@pytest.mark.some(1)
@pytest.mark.parametrize(
    ("change", "kind"),
    [
        (("force: on_cart", "force: on_sensor"), "sign"),
        (("unit: mm", "unit: m"), "unit"),
        (("unit: N}", "unit: kN}"), "unit"),
        (("unit: deg", "unit: rad"), "unit"),
    ],
)
def test_a_map_that_is_confirmed_wrongly_is_told_by_the_check(capsys, table, change, kind):
    text = filled(run(capsys, "topics", table, "--json").json["proposal"])
    assert change[0] in text
    own_map(table).write_text(text.replace(*change), encoding="utf-8")
    for command in ("check", "identify"):
        answer = run(capsys, command, table, "--cart", table.with_name("cart.yaml"))
        assert answer.status == 3, answer
        assert f"--accept {kind}" in answer.err
    own_map(table).write_text(text, encoding="utf-8")
    answer = run(capsys, "check", table, "--cart", table.with_name("cart.yaml"), "--json")
    assert (answer.status, answer.json["suspicions"]) == (0, [])


def test_a_guess_stops_every_command_until_it_is_confirmed(capsys, table):
    text = filled(run(capsys, "topics", table, "--json").json["proposal"])
    own_map(table).write_text(text.replace("unit: deg}", "unit: deg?}"), encoding="utf-8")
    cart = ("--cart", table.with_name("cart.yaml"))
    for words in (["check", table], ["view", table], ["estimate", table, *cart], ["discrepancy", table, *cart]):
        run(capsys, *words).refused(
            2, "pose.theta.unit: deg? is a guess: take its question mark away", "docs/tables.md"
        )


def test_asked_on_a_terminal(capsys, table, monkeypatch):
    table.write_text(table.read_text(encoding="utf-8").replace("x [mm]", "x").replace("y [mm]", "y"), encoding="utf-8")
    run(capsys, "topics", table, "--ask").refused(2, "--ask: asks on a terminal")
    asked = []
    answers = {"contact": iter(("[-0.25, 0.2, 1.0]", "[-0.25, -0.2, 1.0]")), "unit": iter(("",))}

    def answer(prompt):
        asked.append(prompt.strip())
        return next(answers[prompt.split()[0].strip(":")])

    monkeypatch.setattr("sys.stdin.isatty", lambda: True, raising=False)
    monkeypatch.setattr("builtins.input", answer)
    assert run(capsys, "topics", table, "--ask").status == 0
    assert asked == ["unit [mm]:", "contact:", "contact:"]  # one question for x and y
    assert len(read_log(table)) == 2000


def test_what_cannot_be_used_is_asked_again(capsys, table, monkeypatch):
    """And a hand that no column names is asked for its word; a list needs no brackets."""
    text = table.read_text(encoding="utf-8").splitlines()
    rows = [",".join(line.split(",")[:7]) for line in text]
    table.write_text("\n".join([rows[0].replace("left ", ""), *rows[1:]]) + "\n", encoding="utf-8")
    asked, answers = [], iter(("a.b", "gripper", "on the handle", "-0.25, 0.2 1.0", "on_cart"))
    monkeypatch.setattr("sys.stdin.isatty", lambda: True, raising=False)
    monkeypatch.setattr("builtins.input", lambda prompt: asked.append(prompt.strip()) or next(answers))
    answer = run(capsys, "topics", table, "--ask")
    assert answer.status == 0
    assert asked == ["name [arm]:", "name [arm]:", "contact:", "contact:", "force:"]
    assert "arms.gripper.contact: 'on the handle' is not a list `[a, b]`; once more" in answer.err
    log = read_log(table)
    assert list(log.arms) == ["gripper"]
    assert log.arms["gripper"].contact[0].tolist() == [-0.25, 0.2, 1.0]


def test_a_run_log_needs_no_map(capsys, tmp_path, push):
    (tmp_path / "run.csv").write_text(as_csv(push[:100]))
    answer = run(capsys, "topics", tmp_path / "run.csv", "--json")
    assert (answer.status, answer.json["proposal"]) == (0, None)
    assert "has the columns of a run log" in answer.err


def test_what_is_for_bags_and_what_for_tables(capsys, table):
    run(capsys, "topics", table, "--salvage").refused(2, "--salvage: is for bags")
    run(capsys, "topics", table.with_name("run.mcap"), "--ask").refused(2, "--ask: is for tables")
    run(capsys, "topics", table.with_name("other.csv")).refused(3, "there is no such file")
    run(capsys, "topics", table, "--with", table.parent.parent / "a.csv").refused(2, "the table's own folder")


@pytest.mark.parametrize("first", ["", "\n", "1;1;55795;223.86\n"])
def test_a_table_without_names_is_shown_all_the_same(first, tmp_path, capsys):
    """Its columns have numbers, and all is open."""
    path = tmp_path / "mine.csv"
    path.write_text(first + "".join(f"{k};{k};5579{k};{0.1 * k}\n" for k in range(1, 60)))
    status, out, err = run(capsys, "topics", path)
    assert status == 0
    assert "column 4" in out
    assert "open: time" in err
