"""Good files for the commands, and how their answers are read."""

from __future__ import annotations

import contextlib
import io
import json
import os
import re
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

from cartgrasp.cli import main
from cartgrasp.cli.app import whole_command

ROOT = Path(__file__).parents[2]
PROGRESS = re.compile(r"^.*: (\d+ %, \d+ (s|min) left|\d+ s)\n", re.MULTILINE)
"""Lines that come where a machine is slow, and on no other."""
CART = """\
name: shopping cart
mass: 24.0                # kg, loaded
com: [0.30, 0.00]
inertia: 2.0
com_height: 0.45
constraints:
  - no_lateral_slip: {x: 0.0}
wheels:
  - {kind: fixed,  x: 0.00, y:  0.27}
  - {kind: fixed,  x: 0.00, y: -0.27}
  - {kind: caster, x: 0.72, y:  0.20, trail: 0.045}
  - {kind: caster, x: 0.72, y: -0.20, trail: 0.045}
effects:
  viscous_drag: {linear: 3.0, angular: 1.2}
"""
RAIL = CART.replace("{x: 0.0}\n", "{x: 0.0}\n  - no_rotation: {}\n")
CASTERS_ALONE = CART.replace("constraints:\n  - no_lateral_slip: {x: 0.0}\n", "constraints: []\n").replace(
    "fixed, ", "caster,"
)
PROBLEM = """\
cart: cart.yaml
wrench: [40.0, 0.0, 3.0]
arms:
  - name: left
    contacts: [[-0.25, 0.20, 1.0]]
    yaw: 0.0
    limits: {force: [60, 60, 40], moment: [8, 8, 6]}
    friction: {mu: 0.6, sides: 4}
    weights: [1, 1, 1, 10, 10, 10]
  - name: right
    contacts: [[-0.25, -0.20, 1.0], [-0.25, -0.10, 1.0]]
    limits: {force: [60, 60, 40], moment: [8, 8, 6]}
    friction: {mu: 0.6, sides: 4}
min_hand_distance: 0.1
"""
MORE = """\
cart: cart.yaml
wrench: [40.0, 0.0, 3.0]
arms:
  - name: left
    contacts: [[-0.25, 0.20, 1.0], [-0.25, 0.3, 1.0]]
    limits: {force: [60, 60, 40], moment: [8, 8, 6]}
    friction: {mu: 0.6, sides: 8}
    payload: 5
    rate: {force: [2.0e4, 2.0e4, 9.0e4], moment: [3000, 3000, 3000], last: [10, 0, 0, 0, 0, 0]}
    joints:
      jacobian: [[0.1, 0.2], [0.6, 0.3], [0, 0], [0, 0], [0, 0], [1, 1]]
      gravity_torque: [2, 1]
      torque_limit: [30, 20]
    reach: {low: [-0.5, -0.3, 0], high: [0, 0.3, 2]}
    held: [-0.25, 0.3, 1.0]
  - name: right
    contacts: [[-0.25, -0.20, 1.0]]
    limits: {force: [60, 60, 40], moment: [8, 8, 6]}
    push_only: true
cart_limits:
  skid: {friction: 0.6}
  tip_over: {least_load: 5}
  internal_force: {bound: 20, axis: [0, 1, 0]}
relax: 50
period: 0.01
switching_cost: 30
objective:
  smoothness: {rate: 1.0}
  load_share: {shares: {left: 0.7, right: 0.3}, weight: 1.0}
  least_joint_torque: {weight: 1.0}
  least_internal_force: {weight: 1.0, axis: [0, 1, 0]}
  worst_arm: {weight: 100.0}
motion: {velocity: [0.8, 0.3], pose: [0, 0, 0]}
confidence: {probability: 0.95, std: {mass: 1.0, com_x: 0.02}}
"""


class Answer(NamedTuple):
    status: int
    out: str
    err: str

    @property
    def json(self):
        """The one document on stdout; NaN and Infinity are refused, as JSON does."""
        assert self.out.count("\n") == 1
        assert self.out.endswith("\n")

        def refuse(word):
            raise AssertionError(f"{word} is not JSON")

        return json.loads(self.out, parse_constant=refuse)

    def refused(self, status, *parts):
        """One line on stderr that says each of `parts`, and nothing on stdout."""
        assert self.status == status, self
        assert self.out == ""
        told = [line for line in self.err.splitlines() if not line.startswith("preparing kernels")]
        assert len(told) == 1, self.err
        assert told[0].startswith("cartgrasp: ")
        assert told[0].isprintable()
        for part in parts:
            assert str(part) in self.err
        return self.err


def run(capsys, *arguments):
    capsys.readouterr()
    status = main([str(a) for a in arguments])
    captured = capsys.readouterr()
    return Answer(status, captured.out, PROGRESS.sub("", captured.err))


def run_quietly(*arguments):
    """Where no `capsys` is, as in fixtures of a module."""
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        status = main([str(a) for a in arguments])
    return Answer(status, out.getvalue(), PROGRESS.sub("", err.getvalue()))


def run_apart(*arguments, **environment):
    """In a process of its own, as a script would."""
    env = {**os.environ, "PYTHONPATH": str(ROOT), "OMP_NUM_THREADS": "1", "PYTHONWARNINGS": "error", **environment}
    command = [sys.executable, "-m", "cartgrasp", *map(str, arguments)]
    done = subprocess.run(command, capture_output=True, text=True, encoding="utf-8", env=env, timeout=60)
    return Answer(done.returncode, done.stdout, PROGRESS.sub("", done.stderr))


def command_tree(command=None, path=()):
    """Every command and group, the whole first: its words and what typer makes of it."""
    command = command or whole_command()
    yield path, command
    for name, inner in getattr(command, "commands", {}).items():
        yield from command_tree(inner, (*path, name))


def problem_file(folder, problem=PROBLEM, cart=CART):
    (folder / "cart.yaml").write_text(cart, encoding="utf-8")
    path = folder / "problem.yaml"
    path.write_text(problem, encoding="utf-8")
    return path
