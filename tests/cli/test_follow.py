"""`discrepancy --next`, `simulate --reference` and `discrepancy --follow`: one round of asking a cart what it lacks."""

from __future__ import annotations

import json
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from benchmarks.active import FIRST, recorded
from benchmarks.sealed.carts import cart_file
from benchmarks.sealed.cases import draw_case
from cartgrasp.cli import discrepancy
from cartgrasp.logs import write_log
from cartgrasp.reference_file import read_reference
from planning.references import PathReference

from .commands import run

HIDDEN = "rolling_resistance"


@pytest.fixture(scope="module")
def first(tmp_path_factory):
    """A cart that resists, pushed straight on, slowly: its log, its file, and what comes out of it."""
    folder = tmp_path_factory.mktemp("first")
    scene, random = draw_case(HIDDEN, 1, "straight", "try "), np.random.default_rng(1)
    write_log(recorded(scene, FIRST, random), folder / "one.csv")
    (folder / "cart.yaml").write_text(cart_file(scene.world, scene.believed, True), encoding="utf-8")
    return SimpleNamespace(folder=folder, scene=scene, random=random)


@pytest.fixture
def asked(capsys, first):
    """The first report, made once."""
    folder = first.folder
    if not (folder / "out").exists():
        options = "--cart", folder / "cart.yaml", "--out", folder / "out", "--next", folder / "next.yaml"
        answer = run(capsys, "discrepancy", folder / "one.csv", *options, "--duration", "8", "--json")
        assert answer.status == 0, answer.err
        assert "reference to run next" in answer.err
    return json.loads((folder / "out" / "report.json").read_text(encoding="utf-8"))


@pytest.mark.prove
def test_what_is_run_next_tells_rivals_apart(capsys, first, asked):
    """By equations that share no code with the model's."""
    (effect,) = asked["effects"]
    names = {effect["name"], *effect["confusable_with"]}
    assert HIDDEN in names
    assert len(names) > 2
    reference = read_reference(first.folder / "next.yaml")
    assert reference.duration <= 8.0
    told = asked["next_reference"]
    assert reference.says == told["says"]
    assert reference.says in asked["next_experiment"][0]
    write_log(recorded(first.scene, reference.stretches, first.random), first.folder / "two.csv")
    options = "--follow", first.folder / "out", "--out", first.folder / "again", "--json"
    answer = run(capsys, "discrepancy", first.folder / "two.csv", *options)
    assert answer.status == 0, answer.err
    (effect,) = answer.json["effects"]
    assert effect["name"] == HIDDEN
    assert names.isdisjoint(effect["confusable_with"])
    assert [Path(one["name"]).name for one in answer.json["logs"]] == ["one.csv", "two.csv"]
    inputs = json.loads((first.folder / "again" / "inputs.json").read_text(encoding="utf-8"))
    assert [one["path"] for one in inputs["logs"]] == ["../one.csv", "../two.csv"]
    assert inputs["cart"]["path"] == "../cart.yaml"


def test_simulate_runs_the_reference(capsys, first, asked):
    reference, out = read_reference(first.folder / "next.yaml"), first.folder / "run"
    options = "--reference", first.folder / "next.yaml", "--no-learn", "--force-noise", "0.5", "--out", out, "--json"
    answer = run(capsys, "simulate", "--cart", first.folder / "cart.yaml", *options)
    assert answer.status == 0, answer.err
    assert answer.json["run"]["duration"] == pytest.approx(reference.duration, abs=0.02)
    last = np.loadtxt(out / "truth.csv", delimiter=",", skiprows=1)[-1]
    path = PathReference(reference.stretches, start_pose=reference.start)
    assert last[4:7] == pytest.approx(path.at(path.duration).pose_sb, abs=0.01)
    assert np.hypot(*(last[1:3] - last[4:6])) < 0.05


def test_what_an_earlier_report_was_made_of_is_checked(capsys, tmp_path, first, asked):
    log, old = first.folder / "one.csv", first.folder / "out"
    new = tmp_path / "two.csv"
    new.write_bytes(log.read_bytes())
    text, inputs = log.read_bytes(), (old / "inputs.json").read_text(encoding="utf-8")

    def follow():
        return run(capsys, "discrepancy", new, "--follow", old)

    try:
        follow().refused(2, "holds the rows of")  # so the old one was read
        log.write_bytes(text + b"\n")
        follow().refused(3, "one.csv", "has changed since", "make the report anew")
        log.unlink()
        follow().refused(3, "one.csv", "is gone")
        log.write_bytes(text)
        (old / "inputs.json").write_text('{"logs": [3]}', encoding="utf-8")
        follow().refused(3, "inputs.json", "make the report anew")
        (old / "inputs.json").unlink()
        follow().refused(2, "--follow", "inputs.json can't be read")
    finally:
        log.write_bytes(text)
        (old / "inputs.json").write_text(inputs, encoding="utf-8")


def test_nothing_is_written_where_nothing_is_open(capsys, monkeypatch, tmp_path, first):
    found = SimpleNamespace(
        next_reference=None,
        next_experiment=SimpleNamespace(why_none="nothing is undecided"),
        report=SimpleNamespace(as_dict=dict),
    )
    monkeypatch.setattr(discrepancy, "diagnose", lambda *_, **__: found)
    options = "--cart", first.folder / "cart.yaml", "--next", tmp_path / "next.yaml", "--json"
    answer = run(capsys, "discrepancy", first.folder / "one.csv", *options)
    assert answer.status == 0
    assert "next.yaml: not written: nothing is undecided" in answer.err
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(("option", "value"), [("--speed", "0"), ("--duration", "2"), ("--duration", "nan")])
def test_limits_that_make_no_sense(capsys, tmp_path, first, option, value):
    options = "--cart", first.folder / "cart.yaml", "--next", tmp_path / "next.yaml", option, value
    run(capsys, "discrepancy", first.folder / "one.csv", *options).refused(2, "limits", option.strip("-"))


def test_what_is_read_is_not_written_over(capsys, first):
    log, cart = first.folder / "one.csv", first.folder / "cart.yaml"
    run(capsys, "discrepancy", log, "--cart", cart, "--next", cart).refused(2, f"--next {cart}", "is read by this")
