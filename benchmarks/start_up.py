"""From a shell to a running program: wall clock of whole subprocesses. As a command, cold_start.py."""

from __future__ import annotations

import subprocess
import sys

from . import cold_start
from .measuring import Competitor, interleave
from .report import Result, timed_table

BARE = "python -c pass"
WARM = """
from cartgrasp import Arm, CartModel, Inertia
from planning import WrenchPlanner
planner = WrenchPlanner(CartModel(Inertia(24.0, (0.3, 0.0), 2.0)), [Arm("hand", [(-0.25, 0.1, 1.0)])])
planner.warm_up()
"""
RATE = """
import numpy as np
from cartgrasp import CartModel, Inertia
from cartgrasp.effects import ViscousDrag
cart = CartModel(Inertia(24.0, (0.3, 0.0), 2.0), effects=(ViscousDrag(5.0, 2.0),))
cart.rate(cart.state(), np.zeros(3))
"""
COMMANDS = {
    BARE: ("-c", "pass"),
    "import numpy": ("-c", "import numpy"),
    "import cartgrasp": ("-c", "import cartgrasp"),
    "import planning": ("-c", "import planning"),
    "a model's first rate": ("-c", RATE),
    "a planner after warm_up": ("-c", WARM),
    "cartgrasp --help": ("-m", "cartgrasp", "--help"),
}
NOTE = """Wall clock of a new interpreter each, with warm file caches and kernels that have been compiled before."""


def run(rounds: int) -> Result:
    competitors = {name: _process(arguments) for name, arguments in COMMANDS.items()}
    table = timed_table("A new process", interleave(competitors, rounds), BARE, "ms", {})
    return Result("Start-up", NOTE, (table,))


def _process(arguments: tuple[str, ...]) -> Competitor:
    return lambda _: subprocess.run([sys.executable, *arguments], check=True, capture_output=True)


if __name__ == "__main__":
    cold_start.main()
