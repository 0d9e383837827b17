"""Worse first guesses beside the same logs, logs that are kept for proof, and what the command says of either."""

from __future__ import annotations

import json
import sys

import numpy as np
import pytest

from benchmarks.sealed import __main__ as command
from benchmarks.sealed.generate import generate
from benchmarks.sealed.roughness import PROOF_CASES, ROUGH_CASES
from cartgrasp import load_cart, read_log

SOME = ("force_scale@two_arms", "payload_change", "rolling_resistance@rail@leaning_load")


def truths(out):
    return {path.stem: json.loads(path.read_text()) for path in sorted((out / "truth").glob("*.json"))}


def by_case(out):
    return {true["case"]: (out / "logs" / name, true) for name, true in truths(out).items()}


def run(monkeypatch, *arguments):
    monkeypatch.setattr(sys, "argv", ["sealed", *map(str, arguments)])
    command.main()


@pytest.fixture(scope="module")
def folders(tmp_path_factory):
    """With good guesses, and with a third of the mass."""
    good, bad = tmp_path_factory.mktemp("good"), tmp_path_factory.mktemp("bad")
    generate(good, SOME, [5], "straight")
    generate(bad, SOME, [5], "straight", guess=(1 / 3, 1 / 3))
    return good, bad


@pytest.mark.parametrize("case", SOME)
def test_a_worse_guess_changes_the_cart_file_alone(folders, case):
    (good, _), (bad, true) = (by_case(folder)[case] for folder in folders)
    assert (good / "run.csv").read_bytes() == (bad / "run.csv").read_bytes()
    assert good.name != bad.name
    cart, other = load_cart(bad / "cart.yaml"), load_cart(good / "cart.yaml")
    assert cart.inertia.mass == pytest.approx(true["cart"]["mass"] / 3, abs=1e-3)
    assert cart.inertia.about_com == pytest.approx(true["cart"]["inertia"] / 3, abs=1e-3)
    off = np.abs(np.subtract(cart.inertia.com, (true["cart"]["com_x"], true["cart"]["com_y"])))
    assert off.max() <= 0.15 + 1e-4
    assert [e.values.tolist() for e in cart.effects] == [e.values.tolist() for e in other.effects]
    assert true["guess"] == [1 / 3, 1 / 3]
    assert true["cart_file"]["mass"] == pytest.approx(cart.inertia.mass, abs=1e-3)


def test_any_guess_is_between_a_third_and_three_times_the_truth(tmp_path):
    generate(tmp_path, ("nothing",), range(12), "straight", guess=command.guess("any"))
    factors = [true["cart_file"]["mass"] / true["cart"]["mass"] for true in truths(tmp_path).values()]
    assert 1 / 3 <= min(factors) < 0.7
    assert 1.4 < max(factors) <= 3.0
    assert len(set(factors)) == 12


def test_a_rail_has_two_rows_and_its_log_can_be_read(folders):
    folder, true = by_case(folders[0])["rolling_resistance@rail@leaning_load"]
    assert load_cart(folder / "cart.yaml").constraints.n_free == 1
    assert len(read_log(folder / "run.csv")) > 1000
    assert true["kind"] == "rough"
    assert [one["name"] for one in true["roughness"]] == ["rail", "leaning_load"]
    assert [one["name"] for one in true["effects"]] == ["rolling_resistance"]


def test_nothing_beside_a_log_tells_how_rough_it_is(folders):
    words = ("rail", "lean", "burst", "proof", "guess", "rough", "arms")
    for folder in folders:
        for path in (folder / "logs").rglob("*"):
            text = path.name + (path.read_text() if path.is_file() else "")
            assert not [word for word in words if word in text.replace("trail", "")]


def test_a_coasting_log_has_no_arm_and_its_truth_is_per_mass(tmp_path):
    generate(tmp_path, ("quadratic_drag@coasting",), [1], "rich", guess=(2.0, 2.0))
    ((folder, true),) = by_case(tmp_path).values()
    header = (folder / "run.csv").read_text().splitlines()[0].split(",")
    assert set(header) <= {"t", "x", "y", "theta", "vx", "vy", "omega"}
    (effect,) = true["effects"]
    assert effect["per_mass"] == {"coefficient": effect["roughly"]["coefficient"] / true["cart"]["mass"]}
    assert true["settings"]["arms"] == []
    assert true["strength"] == {}


def test_proof_is_drawn_from_other_numbers(tmp_path):
    for is_proof in (False, True):
        generate(tmp_path, ("nothing@bursts",), [2], "straight", is_proof=is_proof)
    open_, kept = sorted(truths(tmp_path).values(), key=lambda true: true["proof"])
    assert kept["proof"] is True
    assert open_["proof"] is False
    assert open_["cart"]["mass"] != kept["cart"]["mass"]


def test_frozen_kinds_come_for_proof_alone(tmp_path, monkeypatch, capsys):
    assert command.chosen("rough", False) == list(ROUGH_CASES)
    assert command.chosen("rough", True) == list(PROOF_CASES)
    with pytest.raises(SystemExit):
        run(monkeypatch, "generate", "--out", tmp_path, "--cases", PROOF_CASES[0])
    assert "is kept for proof" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())
    run(monkeypatch, "generate", "--out", tmp_path, "--cases", PROOF_CASES[0], "--seeds", "0", "--proof")
    assert "1 logs" in capsys.readouterr().out
    assert [true["case"] for true in truths(tmp_path).values()] == [PROOF_CASES[0]]


def test_without_the_shared_folder_its_track_is_left_out_and_that_is_said(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(command, "TRACK", tmp_path / "none.csv")
    cases = "nothing@sensor_track,nothing@rail"
    run(monkeypatch, "generate", "--out", tmp_path, "--cases", cases, "--seeds", "0", "--motion", "straight")
    said = capsys.readouterr()
    assert "nothing@sensor_track is left out: there is no none.csv" in said.err
    assert "1 logs" in said.out


@pytest.mark.parametrize(
    ("arguments", "why"),
    [
        (["--cases", "nothing@rail", "--rough"], "has its own"),
        (["--cases", "force_bias@coasting"], "makes no sense beside coasting"),
        (["--cases", "nothing", "--guess", "-1"], "is no factor of a mass"),
    ],
)
def test_what_can_not_be_generated_is_refused(tmp_path, monkeypatch, capsys, arguments, why):
    with pytest.raises(SystemExit):
        run(monkeypatch, "generate", "--out", tmp_path, *arguments)
    assert why in capsys.readouterr().err
