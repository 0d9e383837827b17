"""`cartgrasp export-c`: a folder that builds, and what it says when it can't write one."""

from __future__ import annotations

import subprocess

import pytest

from .commands import PROBLEM, problem_file, run


def check(folder):
    done = subprocess.run(["make", "--silent", "-C", folder, "check"], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout.split()


def test_the_folder_plans_the_problem_as_plan_does(capsys, tmp_path):
    path = problem_file(tmp_path)
    answer = run(capsys, "export-c", path, "--out", tmp_path / "c", "--json")
    assert answer.status == 0
    assert answer.json["folder"] == str(tmp_path / "c")
    assert answer.json["arms"]["left"] == {"contact": [-0.25, 0.2, 1.0], "chosen": False}
    assert answer.json["arms"]["right"]["chosen"]
    assert "right may hold at others too" in answer.err
    plan = run(capsys, "plan", path, "--json").json
    assert answer.json["arms"]["right"]["contact"] == plan["arms"]["right"]["contact"]
    status, *numbers = check(tmp_path / "c")
    assert status == "optimal"
    in_python = [plan["effort"], *plan["arms"]["left"]["wrench"], *plan["arms"]["right"]["wrench"]]
    assert [float(number) for number in numbers] == pytest.approx(in_python, abs=1e-9)


def test_contacts_of_an_infeasible_problem_are_those_of_the_nearest_wrench(capsys, tmp_path):
    path = problem_file(tmp_path, PROBLEM.replace("[40.0, 0.0, 3.0]", "[500.0, 0.0, 3.0]"))
    answer = run(capsys, "export-c", path, "--out", tmp_path / "c")
    assert answer.status == 0
    assert "make -C" in answer.out
    assert check(tmp_path / "c")[0] == "infeasible"


def test_what_can_not_be_exported(capsys, tmp_path):
    path = problem_file(tmp_path, PROBLEM.replace("sides: 4", "sides: exact", 1))
    run(capsys, "export-c", path, "--out", tmp_path / "c").refused(2, "problem.yaml", "left: friction cone")
    run(capsys, "export-c", problem_file(tmp_path), "--out", tmp_path).refused(2, "holds other files")
    far = problem_file(tmp_path, PROBLEM.replace("min_hand_distance: 0.1", "min_hand_distance: 5"))
    run(capsys, "export-c", far, "--out", tmp_path / "c").refused(2, "no contacts can be chosen")
    relaxed = problem_file(tmp_path, PROBLEM + "relax: 5\n")
    run(capsys, "export-c", relaxed, "--out", tmp_path / "c").refused(2, "problem.yaml", "relax")
    for key, value in (
        ("objective", "{smoothness: {}}"),
        ("motion", "{velocity: [1, 0]}"),
        ("confidence", "{probability: 0.9, std: {}}"),
    ):
        other = problem_file(tmp_path, f"{PROBLEM}{key}: {value}\n")
        run(capsys, "export-c", other, "--out", tmp_path / "c").refused(2, "problem.yaml", f"{key}: C plans")
    assert not (tmp_path / "c").exists()
