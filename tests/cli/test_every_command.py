"""Every command sits the same exam: help, what is likely meant, completion, colours."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys

import pytest

from cartgrasp.cli.output import progress

from .commands import ROOT, command_tree, run

TREE = dict(command_tree())
WORDS = list(TREE)
GROUPS = [words for words, command in TREE.items() if hasattr(command, "commands")]
HEAVY = ("numpy", "scipy", "ruamel", "numba", "matplotlib", "mujoco", "cvxpy", "joblib", "rosbags", "pinocchio")
EVERY_HELP = f"""
import sys
from cartgrasp.cli import main
for words in {[list(words) for words in WORDS]!r}:
    assert main([*words, "--help"]) == 0
print(*(name for name in {HEAVY!r} if name in sys.modules), file=sys.stderr)
"""
COLOUR = re.compile(r"\x1b\[[\d;]*\b[349]\d")


def long_names(words):
    return [name for param in TREE[words].params for name in param.opts if name.startswith("--")]


def test_the_tree_is_whole():
    assert {(), ("plan",), ("study",), ("campaign",), ("study", "table1"), ("study", "hardware")} <= set(WORDS)
    assert len(WORDS) > 19


@pytest.mark.parametrize("words", WORDS, ids=" ".join)
def test_help_fits_80_columns(capsys, monkeypatch, words):
    monkeypatch.setenv("COLUMNS", "80")
    answer = run(capsys, *words, "--help")
    assert answer.status == 0
    assert answer.err == ""
    assert answer.out == run(capsys, *words, "-h").out
    assert " ".join(["Usage: cartgrasp", *words]) in answer.out
    assert max(map(len, answer.out.splitlines())) <= 80
    for name in long_names(words):
        assert f"{name} " in answer.out


@pytest.mark.parametrize(
    ("environment", "has_codes", "has_colours"),
    [({}, False, False), ({"FORCE_COLOR": "1"}, True, True), ({"FORCE_COLOR": "1", "NO_COLOR": "1"}, True, False)],
)
def test_every_help_in_a_pipe(environment, has_codes, has_colours):
    """And none of them needs a heavy import: each stays well under a second, and so does completion."""
    done = run_python(EVERY_HELP, **environment)
    assert done.returncode == 0, done.stderr
    assert done.stderr.split() == []
    assert done.stdout.count("Usage:") == len(WORDS)
    assert ("\x1b" in done.stdout) is has_codes
    assert bool(COLOUR.search(done.stdout)) is has_colours


def test_tables_in_a_pipe():
    program = "from cartgrasp.cli.output import print_table; print_table('t', ['a'], [['b']])"
    assert "\x1b" not in run_python(program).stdout
    assert "\x1b[1m" in run_python(program, FORCE_COLOR="1").stdout


def test_no_bar_in_a_pipe_even_if_colours_are_forced():
    program = (
        "from cartgrasp.cli.output import *\nwith progress('p') as tell, stages('s') as say:\n tell(0.5), say('x')"
    )
    done = run_python(program, FORCE_COLOR="1")
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")


def test_lines_of_progress_in_a_pipe(capsys, monkeypatch):
    """What takes long says so there, too: after 4 s, and the more seldom the longer it takes."""
    now = iter((0.0, 5.0, 8.0, 30.0, 35.0, 60.0, 600.0))
    monkeypatch.setattr("time.monotonic", lambda: next(now))
    with progress("disturbances") as tell:
        for share in (0.1, 0.2, 0.3, 0.4, 0.5, 1.0):
            tell(share)
    told = ("10 %, 45 s", "30 %, 70 s", "50 %, 60 s")
    assert capsys.readouterr().err.splitlines() == [f"disturbances: {words} left" for words in told]


@pytest.mark.parametrize("words", [words for words in WORDS if words], ids=" ".join)
def test_a_command_is_guessed(capsys, words):
    *above, name = words
    run(capsys, *above, name[:1] + name[2:]).refused(2, "Did you mean", repr(name), "--help")


@pytest.mark.parametrize("words", WORDS, ids=" ".join)
def test_an_option_is_guessed(capsys, words):
    for name in long_names(words):
        error = run(capsys, *words, f"{name}z").refused(2, "Did you mean", " ".join(["cartgrasp", *words]))
        assert re.search(rf"{name}\b", error)


@pytest.mark.parametrize("words", WORDS, ids=" ".join)
def test_completion(capsys, monkeypatch, words):
    assert set(completed(capsys, monkeypatch, [*words, "--"])) >= set(long_names(words))
    if words:
        assert words[-1] in completed(capsys, monkeypatch, [*words[:-1], words[-1][:2]])
    if words in GROUPS:
        assert completed(capsys, monkeypatch, [*words, ""]) == list(TREE[words].commands)


def test_values_are_completed(capsys, monkeypatch):
    assert completed(capsys, monkeypatch, ["estimate", "--method", "r"]) == ["regressor"]
    assert completed(capsys, monkeypatch, ["simulate", "--path", ""]) == ["straight", "curves", "push-pull"]


@pytest.mark.skipif(shutil.which("bash") is None, reason="bash is not installed")
def test_completion_in_bash(tmp_path):
    program = tmp_path / "cartgrasp"
    program.write_text(f'#!/bin/sh\nexec {sys.executable} -m cartgrasp "$@"\n')
    program.chmod(0o755)
    asked = (
        'eval "$(cartgrasp --show-completion)"; COMP_WORDS=(cartgrasp study tab); COMP_CWORD=2;'
        '_cartgrasp_completion cartgrasp; echo "${COMPREPLY[@]}"; complete -p cartgrasp'
    )
    environment = {"PATH": f"{tmp_path}:/usr/bin:/bin", "PYTHONPATH": str(ROOT)}
    done = subprocess.run(["bash", "-c", asked], env=environment, capture_output=True, text=True, timeout=60)
    assert done.stdout.splitlines()[0] == "table1", done.stderr
    assert "-F _cartgrasp_completion cartgrasp" in done.stdout


def completed(capsys, monkeypatch, words):
    """What a shell is told for the last of the words."""
    monkeypatch.setenv("_CARTGRASP_COMPLETE", "complete_bash")
    monkeypatch.setenv("COMP_WORDS", " ".join(["cartgrasp", *words]))
    monkeypatch.setenv("COMP_CWORD", str(len(words)))
    with pytest.raises(SystemExit) as done:
        run(capsys)
    assert done.value.code == 0
    return capsys.readouterr().out.split()


def run_python(program, **environment):
    env = {"PATH": "/usr/bin:/bin", "PYTHONPATH": str(ROOT), "PYTHONIOENCODING": "utf-8", **environment}
    command = [sys.executable, "-W", "error", "-c", program]
    return subprocess.run(command, env=env, capture_output=True, text=True, encoding="utf-8", timeout=120)
