"""`python -m benchmarks.sealed generate --out DIR` and `python -m benchmarks.sealed score DIR`."""

from __future__ import annotations

import argparse
from pathlib import Path

from .cases import CASES
from .generate import generate
from .references import DURATIONS


def main() -> None:
    parser = argparse.ArgumentParser(
        "python -m benchmarks.sealed", description="Logs with hidden effects, and a score."
    )
    commands = parser.add_subparsers(dest="command", required=True)
    making = commands.add_parser("generate", help="write logs, cart files and truth")
    making.add_argument("--out", type=Path, required=True, metavar="DIR")
    making.add_argument("--seeds", type=seeds, default=range(4), metavar="FROM:TO", help="0:4 by default")
    making.add_argument("--cases", default="all", help=f"all, or some of {', '.join(CASES)}, with commas between")
    making.add_argument("--motion", choices=list(DURATIONS), default="rich")
    scoring = commands.add_parser("score", help="compare DIR/logs/*/out/report.json with DIR/truth")
    scoring.add_argument("folder", type=Path, metavar="DIR")
    options = parser.parse_args()
    if options.command == "score":
        from .score import score

        print(score(options.folder))
        return
    cases = list(CASES) if options.cases == "all" else options.cases.split(",")
    unknown = [case for case in cases if case not in CASES]
    if unknown:
        parser.error(f"no case {unknown[0]!r}; there are {', '.join(CASES)}")
    names = generate(options.out, cases, options.seeds, options.motion)
    print(f"{len(names)} logs in {options.out / 'logs'}, truth in {options.out / 'truth'}")


def seeds(text: str) -> range:
    first, _, end = text.partition(":")
    return range(int(first), int(end)) if end else range(int(first), int(first) + 1)


if __name__ == "__main__":
    main()
