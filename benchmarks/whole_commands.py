"""`python -m benchmarks.whole_commands --against TREE [--runs 1000]`: CPU seconds of `cartgrasp discrepancy` on a made
log of 60 s, with no cache of kernels and with one, and of a campaign with one; beside those of another tree, such as
`git worktree add --detach TREE COMMIT` makes, turn by turn."""

from __future__ import annotations

import argparse
import resource
import statistics
from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

from .cold_start import HERE, run_python

MADE = ("benchmarks.sealed", "generate", "--cases", "floor_slope", "--seeds", "3:4")


def main() -> None:
    parser = argparse.ArgumentParser("python -m benchmarks.whole_commands", description=__doc__)
    parser.add_argument("--against", type=Path, metavar="TREE", required=True, help="another tree, to be the measure")
    parser.add_argument("--runs", type=int, default=1000, help="of the campaign")
    parser.add_argument("--rounds", type=int, default=3)
    options = parser.parse_args()
    with TemporaryDirectory() as folder:
        print("\n".join(table([HERE, options.against.resolve()], Path(folder), options.runs, options.rounds)))


def table(trees: Sequence[Path], folder: Path, runs: int, rounds: int) -> list[str]:
    """Markdown of medians; ratios are those of the first tree to the second."""
    commands = {"discrepancy": _diagnosis(folder), f"campaign of {runs}": _campaign(folder, runs)}
    took: dict[str, list[list[float]]] = {}
    for k in range(rounds):
        for name, command in commands.items():
            for i, tree in enumerate(trees):
                for start in ("cold", "warm"):
                    cache = folder / f"cache_{i}_{k}"
                    spent = _spent(tree, cache, [*command, "--out", str(folder / f"{name}_{i}_{k}_{start}")])
                    took.setdefault(f"{name}, {start}", [[] for _ in trees])[i].append(spent)
    lines = ["| s of CPU | here | there | ratio |", "| --- | --- | --- | --- |"]
    for name, by_tree in took.items():
        here, there = map(statistics.median, by_tree)
        lines.append(f"| {name} | {here:.1f} | {there:.1f} | {here / there:.2f} |")
    return lines


def _diagnosis(folder: Path) -> list[str]:
    _spent(HERE, folder / "cache", [*MADE, "--out", str(folder / "made")])
    log = next((folder / "made" / "logs").iterdir())
    return ["cartgrasp", "discrepancy", str(log / "run.csv"), "--cart", str(log / "cart.yaml")]


def _campaign(folder: Path, runs: int) -> list[str]:
    """Of the example's study; the caches are those of the diagnosis, so that a cold one compiles what is left."""
    for name in ("cart.yaml", "study.yaml"):
        text = (HERE / "examples" / name).read_text(encoding="utf-8")
        (folder / name).write_text(text.replace("runs: 100", f"runs: {runs}"), encoding="utf-8")
    return ["cartgrasp", "campaign", str(folder / "study.yaml"), "--workers", "1"]


def _spent(tree: Path, cache: Path, command: Sequence[str]) -> float:
    """CPU seconds, of its workers, too."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    run_python(["-m", *command], tree, cache)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


if __name__ == "__main__":
    main()
