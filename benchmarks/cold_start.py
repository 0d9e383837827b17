"""`python -m benchmarks.start_up [--against TREE]`: CPU seconds until kernels are there, with no cache of any; how fast
calls are then; and what imports cost. Beside those of another tree, such as `git worktree add --detach TREE COMMIT`
makes: each runs its own packages, cold starts side by side and warm processes in turns."""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

HERE = Path(__file__).parents[1]
ROUNDS = 5
WORK = """
import json, resource, time
import numpy as np

def spent():
    used = resource.getrusage(resource.RUSAGE_SELF)
    return used.ru_utime + used.ru_stime

begin = spent()
from cartgrasp import Arm, CartModel, Inertia, Measurement
from cartgrasp.effects import ViscousDrag
from estimation import CartFilter
from planning import WrenchPlanner

cart = CartModel(Inertia(24.0, (0.3, 0.0), 2.0), effects=(ViscousDrag(5.0, 2.0),))
random = np.random.default_rng(1)

def sample(i):
    time, (noise, off) = 0.01 * i, random.normal(size=(2, 6))
    speed, x = 0.3 + 0.2 * np.sin(time), 0.3 * time + 0.2 * (1.0 - np.cos(time))
    felt = np.array([24.0 * 0.2 * np.cos(time) + 5.0 * speed, 0, 0, 0, 0, 0]) + 0.5 * noise
    seen = np.array([x, 0, 0]) + 0.001 * off[:3], np.array([speed, 0, 0]) + 0.001 * off[3:]
    return Measurement(time, *seen, {"hand": felt}, {"hand": np.array([-0.25, 0.0, 1.0])})

def timed(call, given):
    took = []
    for one in given:
        start = time.perf_counter()
        call(one)
        took.append(time.perf_counter() - start)
    return took

imported = spent()
planner = WrenchPlanner(cart, [Arm("left", [(-0.25, 0.2, 1.0)]), Arm("right", [(-0.25, -0.2, 1.0)])])
planner.warm_up()
planned = spent()
state = cart.state()
cart.rate(state, np.zeros(3))
cart.inverse(state, np.zeros(cart.constraints.n_free))
moved = spent()
log = [sample(i) for i in range(1, 1001)]
online = CartFilter(cart, ["hand"])
first = timed(online.update, log[:200])
learned = spent()
online = CartFilter(cart, ["hand"])
updates = timed(online.update, log)
plans = timed(planner.plan, random.uniform((10.0, 0.0, -3.0), (40.0, 0.0, 3.0), (3000, 3)))
rates = timed(lambda state: cart.rate(state, np.zeros(3)), [state] * 1000)
print(json.dumps({
    "imports": imported - begin, "planner": planned - imported, "model": moved - planned, "filter": learned - moved,
    "all": learned - begin, "first update": first[0],
    **{name: float(np.median(took)) for name, took in (("update", updates), ("plan", plans), ("rate", rates))},
}))
"""
IMPORT = """
import resource
{}
used = resource.getrusage(resource.RUSAGE_SELF)
print(used.ru_utime + used.ru_stime)
"""
IMPORTS = ("numpy", "cartgrasp", "planning", "estimation")
Took = dict[str, float]
COLD = ("imports", "planner", "model", "filter", "all")
WARM = ("update", "plan", "rate")


def main() -> None:
    parser = argparse.ArgumentParser("python -m benchmarks.start_up", description=__doc__)
    parser.add_argument("--against", type=Path, metavar="TREE", help="another tree, to be the measure")
    parser.add_argument("--rounds", type=int, default=ROUNDS, help="of warm calls and of imports")
    options = parser.parse_args()
    trees = [HERE] if options.against is None else [HERE, options.against.resolve()]
    with TemporaryDirectory() as folder:
        caches = [Path(folder) / str(i) for i in range(len(trees))]
        print("\n".join(table(*measured(trees, caches, options.rounds))))


def measured(
    trees: list[Path], caches: list[Path], rounds: int
) -> tuple[list[dict[str, float]], list[dict[str, float]]]:
    """Of each tree what a cold start takes, and then the least of what warm processes do."""
    with ThreadPoolExecutor() as pool:
        cold = [json.loads(said) for said in pool.map(partial(_ran, WORK), trees, caches)]
    warm: list[list[dict[str, Any]]] = [[] for _ in trees]
    for _ in range(rounds):
        for found, tree, cache in zip(warm, trees, caches, strict=True):
            took = json.loads(_ran(WORK, tree, cache))
            nothing = float(_ran(IMPORT.format(""), tree, cache))
            own = {name: float(_ran(IMPORT.format(f"import {name}"), tree, cache)) - nothing for name in IMPORTS}
            found.append({name: took[name] for name in (*WARM, "all", "first update")} | own)
    least = [{name: min(one[name] for one in found) for name in found[0]} for found in warm]
    return cold, least


def table(cold: list[Took], warm: list[Took]) -> list[str]:
    """Markdown; the last column is the ratio of the first tree to the second."""
    lines = ["| | here | there | ratio |", "| --- | --- | --- | --- |"]
    rows = [(f"cold: {name}, s of CPU", 1.0, [one[name] for one in cold]) for name in COLD]
    rows += [("warm: all, s of CPU", 1.0, [one["all"] for one in warm])]
    rows += [("warm: first update, ms", 1e3, [one["first update"] for one in warm])]
    rows += [(f"{name}, median, µs", 1e6, [one[name] for one in warm]) for name in WARM]
    rows += [(f"import {name}, ms of CPU", 1e3, [one[name] for one in warm]) for name in IMPORTS]
    for name, unit, values in rows:
        shown = [f"{unit * value:.3g}" for value in values] + [""] * (2 - len(values))
        ratio = f"{values[0] / values[1]:.2f}" if len(values) == 2 and values[1] > 0 else ""
        lines.append(f"| {name} | {' | '.join(shown)} | {ratio} |")
    return lines


def _ran(code: str, tree: Path, cache: Path) -> str:
    """What it prints, with a tree's packages."""
    return run_python(["-c", code], tree, cache)


def run_python(arguments: Sequence[str], tree: Path, cache: Path) -> str:
    """What a process of one thread prints, with a tree's packages and a cache of kernels of its own."""
    own = {"PYTHONPATH": str(tree), "NUMBA_CACHE_DIR": str(cache), "MPLBACKEND": "Agg"}
    single = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
    command, env = [sys.executable, "-P", *arguments], os.environ | single | own
    return subprocess.run(command, check=True, capture_output=True, text=True, env=env, cwd=cache.parent).stdout


if __name__ == "__main__":
    main()
