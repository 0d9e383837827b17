"""`python -m benchmarks.sealed generate --out DIR`, then `… score DIR`; `… baselines DIR` for another method."""

from __future__ import annotations

import argparse
from pathlib import Path

from .baselines import METHODS, STOP, regress_all
from .cases import CASES, MUJOCO_CASES
from .effects import VOCABULARY
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
    every = ", ".join((*CASES, *MUJOCO_CASES))
    making.add_argument("--cases", default="all", help=f"all, single, mujoco, or some, with commas between, of {every}")
    making.add_argument("--motion", choices=list(DURATIONS), default="rich")
    making.add_argument(
        "--shares", type=shares, default=(1.0,), metavar="SHARE,…", help="of effects' sizes, for detection floors"
    )
    making.add_argument(
        "--rough", action="store_true", help="by worse sensors: noise that remembers, poses that are off, lost rows"
    )
    scoring = commands.add_parser("score", help="compare DIR/logs/*/out/report.json with DIR/truth")
    scoring.add_argument("folder", type=Path, metavar="DIR")
    scoring.add_argument("--reports", default="out", metavar="NAME", help="folder beside each log; out by default")
    scoring.add_argument("--reliability", type=Path, metavar="FILE", help="draw said against true probabilities there")
    regressing = commands.add_parser("baselines", help="general methods on DIR/logs/*, to be scored too")
    regressing.add_argument("folder", type=Path, metavar="DIR")
    regressing.add_argument("--method", choices=list(METHODS), default="err")
    regressing.add_argument("--reports", metavar="NAME", help="folder beside each log; out-METHOD by default")
    regressing.add_argument(
        "--stop", type=float, default=STOP, help=f"least share of the residual that a term takes; {STOP:g} by default"
    )
    options = parser.parse_args()
    if options.command == "baselines":
        reports = options.reports or f"out-{options.method}"
        count = regress_all(options.folder, reports, options.stop, options.method)
        print(f"{count} reports; judge them with: score {options.folder} --reports {reports}")
        return
    if options.command == "score":
        from .score import judged, score

        print(score(options.folder, options.reports))
        if options.reliability:
            from .reliability_plot import save_reliability

            save_reliability(judged(options.folder, options.reports), options.reliability)
        return
    cases = {"all": CASES, "single": tuple(VOCABULARY), "mujoco": MUJOCO_CASES}.get(
        options.cases
    ) or options.cases.split(",")
    unknown = [case for case in cases if case not in (*CASES, *MUJOCO_CASES)]
    if unknown:
        parser.error(f"no case {unknown[0]!r}; there are all, single, mujoco, {every}")
    names = generate(options.out, cases, options.seeds, options.motion, options.shares, options.rough)
    print(f"{len(names)} logs in {options.out / 'logs'}, truth in {options.out / 'truth'}")


def seeds(text: str) -> range:
    first, _, end = text.partition(":")
    return range(int(first), int(end)) if end else range(int(first), int(first) + 1)


def shares(text: str) -> tuple[float, ...]:
    return tuple(float(one) for one in text.split(","))


if __name__ == "__main__":
    main()
