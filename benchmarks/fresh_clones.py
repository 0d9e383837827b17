"""`python -m benchmarks.fresh_clones --against COMMIT [--target demo] [--rounds 1]`: how long `make demo` (`test`,
`test-quick`) takes in a fresh clone without environment or caches, when its first line comes, and for how long it is
silent; beside those of another commit, turn by turn."""

from __future__ import annotations

import argparse
import os
import statistics
import subprocess
import time
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

from .cold_start import HERE

CACHES = ("PIP_CACHE_DIR", "UV_CACHE_DIR", "NUMBA_CACHE_DIR", "MPLCONFIGDIR")


class Run(NamedTuple):
    """Seconds."""

    whole: float
    first_line: float
    longest_silence: float


def main() -> None:
    parser = argparse.ArgumentParser("python -m benchmarks.fresh_clones", description=__doc__)
    parser.add_argument("--against", default="0a348c7", metavar="COMMIT")
    parser.add_argument("--target", default="demo")
    parser.add_argument("--rounds", type=int, default=1)
    options = parser.parse_args()
    taken: tuple[list[Run], list[Run]] = [], []
    for _ in range(options.rounds):
        for runs, commit in zip(taken, ("HEAD", options.against), strict=True):
            runs.append(made(commit, options.target))
    print("\n".join(table(f"make {options.target}", *taken)))


def made(commit: str, target: str) -> Run:
    with TemporaryDirectory() as name:
        folder = Path(name)
        for command in (
            ("clone", "-q", str(HERE), str(folder / "clone")),
            ("-C", str(folder / "clone"), "checkout", "-q", commit),
        ):
            subprocess.run(["git", *command], check=True)
        caches = {variable: str(folder / variable) for variable in CACHES}
        return timed(["make", target], folder / "clone", {**os.environ, **caches})


def timed(command: list[str], folder: Path, environment: dict[str, str]) -> Run:
    """A command's time, as its lines come through a pipe."""
    begin = time.monotonic()
    with subprocess.Popen(
        command, cwd=folder, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT
    ) as process:
        moments = [begin, *_moments(process), time.monotonic()]
    if process.returncode:
        raise SystemExit(f"{' '.join(command)}: exit status {process.returncode}")
    return Run(moments[-1] - begin, moments[1] - begin, max(later - one for one, later in pairwise(moments)))


def _moments(process: subprocess.Popen[bytes]) -> Iterator[float]:
    """When there was output."""
    assert process.stdout is not None
    while os.read(process.stdout.fileno(), 1 << 16):
        yield time.monotonic()


def table(name: str, here: list[Run], there: list[Run]) -> list[str]:
    """Markdown of medians."""
    lines = [f"| {name}, s | here | there | ratio |", "| --- | --- | --- | --- |"]
    for field, words in zip(Run._fields, ("whole", "first line", "longest silence"), strict=True):
        one, other = (statistics.median(getattr(run, field) for run in runs) for runs in (here, there))
        lines.append(f"| {words} | {one:.1f} | {other:.1f} | {one / other:.2f} |")
    return lines


if __name__ == "__main__":
    main()
