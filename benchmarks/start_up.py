"""From a shell to a running program: wall clock of whole subprocesses."""

from __future__ import annotations

import subprocess
import sys

from .measuring import Competitor, interleave
from .report import Result, timed_table

BARE = "python -c pass"
COMMANDS = {
    BARE: ("-c", "pass"),
    "import numpy": ("-c", "import numpy"),
    "import cartgrasp": ("-c", "import cartgrasp"),
    "cartgrasp --help": ("-m", "cartgrasp", "--help"),
}
NOTE = """Wall clock of a new interpreter each, with warm file caches."""


def run(rounds: int) -> Result:
    competitors = {name: _process(arguments) for name, arguments in COMMANDS.items()}
    table = timed_table("A new process", interleave(competitors, rounds), BARE, "ms", {})
    return Result("Start-up", NOTE, (table,))


def _process(arguments: tuple[str, ...]) -> Competitor:
    return lambda _: subprocess.run([sys.executable, *arguments], check=True, capture_output=True)
