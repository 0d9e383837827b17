"""Logs with hidden effects, and how well reports name them.

    python -m benchmarks.sealed generate --out DIR [--cases … --seeds … --guess … --proof]
    python -m benchmarks.sealed score DIR             what DIR/logs/*/out/report.json say, beside DIR/truth
    python -m benchmarks.sealed compare DIR1 DIR2     the same logs with two guesses: whether verdicts are the same
    python -m benchmarks.sealed baselines DIR         another method's reports, to be scored too

A case is effects, then what makes the log rough: `rolling_resistance+floor_slope@rail@bursts`, `nothing@coasting`.
Kinds behind an @ are rail, coasting, bursts, leaning_load, quantised_poses, force_lag, late_velocities,
large_velocities and sensor_track (of the shared folder beside the repository, where it is), two_arms and mujoco.
`--cases rough` is a list of such, but for the quarter of its kinds that is frozen: those come with `--proof` alone,
from numbers of their own, and their reports are only counted in totals. `--guess 0.33` writes cart files with a third
of the true mass and inertia and a CoM that is up to 0.15 m off, beside logs that stay the same to the last digit;
`--guess any` draws a factor from a third to three.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from .baselines import METHODS, STOP, regress_all
from .cases import CASES, LAW_CASES, MUJOCO_CASES, ROBOT_CASES, objection
from .effects import VOCABULARY
from .generate import generate
from .references import DURATIONS
from .roughness import ARM_CASES, PROOF_CASES, ROUGH_CASES, ROUGHNESS, for_proof, is_rough, parts
from .sensor_track import TRACK
from .sizes import GUESS

GROUPS = {
    "all": CASES,
    "single": tuple(VOCABULARY),
    "mujoco": MUJOCO_CASES,
    "rough": ROUGH_CASES,
    "arms": ARM_CASES,
    "robots": ROBOT_CASES,
    "laws": LAW_CASES,
}


def main() -> None:
    parser = argparse.ArgumentParser(
        "python -m benchmarks.sealed", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    commands = parser.add_subparsers(dest="command", required=True)
    add_generate(commands.add_parser("generate", help="write logs, cart files and truth"))
    scoring = commands.add_parser("score", help="compare DIR/logs/*/out/report.json with DIR/truth")
    scoring.add_argument("folder", type=Path, metavar="DIR")
    scoring.add_argument("--reports", default="out", metavar="NAME", help="folder beside each log; out by default")
    scoring.add_argument("--reliability", type=Path, metavar="FILE", help="draw said against true probabilities there")
    comparing = commands.add_parser("compare", help="the same logs with two first guesses: the same verdicts?")
    comparing.add_argument("folders", type=Path, nargs=2, metavar="DIR")
    comparing.add_argument("--reports", default="out", metavar="NAME", help="folder beside each log; out by default")
    regressing = commands.add_parser("baselines", help="general methods on DIR/logs/*, to be scored too")
    regressing.add_argument("folder", type=Path, metavar="DIR")
    regressing.add_argument("--method", choices=list(METHODS), default="err")
    regressing.add_argument("--reports", metavar="NAME", help="folder beside each log; out-METHOD by default")
    regressing.add_argument(
        "--stop", type=float, default=STOP, help=f"least share of the residual that a term takes; {STOP:g} by default"
    )
    options = parser.parse_args()
    if options.command == "baselines":
        regress_logs(options)
    elif options.command == "score":
        score_reports(options)
    elif options.command == "compare":
        compare_reports(options, parser)
    else:
        generate_logs(options, parser)


def add_generate(making: argparse.ArgumentParser) -> None:
    making.add_argument("--out", type=Path, required=True, metavar="DIR")
    making.add_argument("--seeds", type=seeds, default=range(4), metavar="FROM:TO", help="0:4 by default")
    every = ", ".join((*CASES, *MUJOCO_CASES))
    making.add_argument(
        "--cases",
        default="all",
        help=f"{', '.join(GROUPS)}, or some, with commas between, of {every}; any of them @ {', '.join(ROUGHNESS)}",
    )
    making.add_argument("--motion", choices=list(DURATIONS), default="rich")
    making.add_argument(
        "--shares", type=shares, default=(1.0,), metavar="SHARE,…", help="of effects' sizes, for detection floors"
    )
    making.add_argument(
        "--rough", action="store_true", help="by worse sensors: autocorrelated noise, poses that are off, lost rows"
    )
    making.add_argument(
        "--guess", type=guess, metavar="FACTOR", help="times the true mass that cart files say; any: a third to three"
    )
    making.add_argument(
        "--proof", action="store_true", help="other numbers, and of the kinds that are rough those that are frozen"
    )


def generate_logs(options: argparse.Namespace, parser: argparse.ArgumentParser) -> None:
    cases = chosen(options.cases, options.proof)
    wrong = next(filter(None, (refusal(case, options) for case in cases)), "")
    if wrong:
        parser.error(wrong)
    if not TRACK.is_file():
        left_out = [case for case in cases if "sensor_track" in parts(case)[1]]
        cases = [case for case in cases if case not in left_out]
        for case in left_out:
            print(f"{case} is left out: there is no {TRACK.name} in a shared folder here", file=sys.stderr)
    names = generate(
        options.out,
        cases,
        options.seeds,
        options.motion,
        options.shares,
        is_rough=options.rough,
        guess=options.guess,
        is_proof=options.proof,
    )
    print(f"{len(names)} logs in {options.out / 'logs'}, truth in {options.out / 'truth'}")


def chosen(text: str, is_proof: bool) -> list[str]:
    groups = GROUPS | ({"rough": PROOF_CASES} if is_proof else {})
    return list(groups[text] if text in groups else text.split(","))


def refusal(case: str, options: argparse.Namespace) -> str:
    """Why a case isn't generated; empty where it is."""
    if for_proof(case) and not options.proof:
        return f"{case!r} is kept for proof: generate it with --proof, and look at totals alone"
    if options.rough and is_rough(case):
        return f"--rough is for sensors of other kinds of logs; {case!r} has its own"
    return objection(case)


def score_reports(options: argparse.Namespace) -> None:
    from .calibration import probabilities
    from .score import judged, score

    print(score(options.folder, options.reports))
    if options.reliability:
        from .reliability_plot import save_reliability

        save_reliability(probabilities(judged(options.folder, options.reports)), options.reliability)


def compare_reports(options: argparse.Namespace, parser: argparse.ArgumentParser) -> None:
    from .comparing import compare

    try:
        print(compare(*options.folders, options.reports))
    except ValueError as error:
        parser.error(str(error))


def regress_logs(options: argparse.Namespace) -> None:
    reports = options.reports or f"out-{options.method}"
    count = regress_all(options.folder, reports, options.stop, options.method)
    print(f"{count} reports; judge them with: score {options.folder} --reports {reports}")


def seeds(text: str) -> range:
    first, _, end = text.partition(":")
    return range(int(first), int(end)) if end else range(int(first), int(first) + 1)


def shares(text: str) -> tuple[float, ...]:
    return tuple(float(one) for one in text.split(","))


def guess(text: str) -> tuple[float, float]:
    if text == "any":
        return GUESS["factor"]
    factor = float(text)
    if not 0.0 < factor < float("inf"):
        raise argparse.ArgumentTypeError(f"{text} is no factor of a mass; give a number above 0, or any")
    return factor, factor


if __name__ == "__main__":
    main()
