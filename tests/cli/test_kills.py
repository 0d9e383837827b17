"""kill -9 leaves the old file or the new one; `python -m tests.cli.kills` counts."""

from __future__ import annotations

import subprocess
import sys

import pytest

from .commands import ROOT, command_tree
from .kills import TRIALS


@pytest.mark.parametrize(
    "arguments",
    [
        ["--trials", "2", "topics", "export-c", "convert"],
        pytest.param(["--trials", "10"], marks=pytest.mark.prove),
    ],
    ids=" ".join,
)
def test_old_or_new(arguments):
    command = [sys.executable, "-m", "tests.cli.kills", *arguments]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    assert len(done.stdout.splitlines()) >= 5


def test_every_command_that_writes_is_killed():
    writes = {" ".join(words) for words, command in command_tree() if "out" in (param.name for param in command.params)}
    assert writes == {trial.name for trial in TRIALS}
