"""Which constants of the discrepancy engine decide, and what each buys.

    python -m benchmarks.ablation DIR [DIR …]         sealed logs (`python -m benchmarks.sealed generate --out DIR`)
                                                      and measured ones, with each constant off, × 0.7 and × 1.3
    python -m benchmarks.ablation DIR --affected      on how many logs each value might change anything at all: one
                                                      run for each log, whatever the number of constants
    python -m benchmarks.ablation --list              all constants and their groups

Group a decides, b is assumed, r are whole rules (`rules.py`), which can be taken away alone; c (numerics and words) is
not ablated. Each log takes some ten seconds for each value that may change something, which one run finds out for all
values (`watching.py`): `--logs 20` is where to begin. What was worked out is kept, so what was interrupted goes on; a
change of the code begins anew.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from cartgrasp.writing import write_atomically

from ..measured.running import ROOT
from .cases import Case, measured_cases, sealed_cases, spread
from .constants import MOVES, OFF, Constant, Group
from .every import CONSTANTS
from .rules import RULES
from .running import WATCHED, Answers, Job, Watch, run_all, unnoticed, wanted
from .table import affected, listed, rows, section

DATA = ROOT.parent / "shared" / "data"
KEPT = ROOT / "out" / "ablation"


def main() -> None:
    parser = _parser()
    options = parser.parse_args()
    constants = chosen(options.groups, options.only)
    if not constants:
        parser.error(f"--only {' '.join(options.only)}: in the name of no constant of groups {options.groups}")
    if options.list:
        print(listed(CONSTANTS if not options.only else constants), end="")
        return
    cases = [*sealed_cases(options.folders), *measured_cases(options.data)]
    cases = spread(cases, options.logs if options.logs is not None else len(cases))
    if not cases:
        parser.error("no logs: give folders of `python -m benchmarks.sealed generate`, or --data")
    if options.affected:
        text = affected(constants, options.moves, watched(cases, constants, options.moves, options))
    else:
        text = section(rows(cases, constants, options.moves, ablated(cases, constants, options.moves, options)))
    print(text, end="")
    if options.out:
        write_atomically(options.out, text)


def ablated(
    cases: Sequence[Case], constants: Sequence[Constant], moves: Sequence[str], options: argparse.Namespace
) -> Answers:
    """Logs as they are first, then watched, then with each value that may change something."""
    answers: Answers = {}
    _run([Job(case) for case in cases], answers, options)
    answers |= watched(cases, constants, moves, options)
    jobs = list(wanted(cases, constants, moves))
    known = {job.place: same for job in jobs if (same := unnoticed(job, answers)) is not None}
    _run([job for job in jobs if job.place not in known], answers, options)
    return answers | known


def watched(
    cases: Sequence[Case], constants: Sequence[Constant], moves: Sequence[str], options: argparse.Namespace
) -> Answers:
    """All logs as they are, and where constants would have told at other values."""
    answers: Answers = {}
    _run([Watch(case, tuple(constants), tuple(moves)) for case in cases], answers, options)
    return answers


def _run(jobs: Sequence[Job | Watch], answers: Answers, options: argparse.Namespace) -> None:
    for number, (job, answer) in enumerate(run_all(jobs, options.kept, options.processes), 1):
        answers[job.place] = answer
        constant, move, case = job.place
        base = answers.get(Job(job.case).place)
        said = answer.failure or (answer.report or {})["verdict"]
        said += ", nothing changed" if base and constant not in ("", WATCHED) and base.digest == answer.digest else ""
        said += f", {len(answer.noticed)} values may change it" if constant == WATCHED else ""
        what = f"{constant} {move}".strip() + f", {case}" if constant else case
        print(f"[{number}/{len(jobs)}] {what}: {said} ({answer.seconds:.0f} s)", file=sys.stderr, flush=True)


def chosen(groups: str, texts: Sequence[str]) -> list[Constant]:
    """Those of the groups that a diagnosis reads, with one of the texts in their names; all, where there are none."""
    found = [c for c in (*CONSTANTS, *RULES) if c.group.value in groups.split(",") and c.is_diagnosed]
    return [c for c in found if not texts or any(text in c.full_name for text in texts)]


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        "python -m benchmarks.ablation", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("folders", type=Path, nargs="*", metavar="DIR", help="logs, carts and truth")
    parser.add_argument("--data", type=Path, default=DATA, metavar="DIR", help="measured logs; ../shared/data")
    parser.add_argument("--logs", type=int, metavar="N", help="so many alone, of all kinds in turn")
    parser.add_argument(
        "--only", nargs="+", default=[], metavar="NAME", help="constants with one of these in MODULE.NAME"
    )
    parser.add_argument("--groups", type=_groups, default="a", help="a (by default), b, r, or some of them")
    parser.add_argument("--moves", type=_moves, default=MOVES, metavar="MOVE,…", help=f"{','.join(MOVES)} by default")
    parser.add_argument("--kept", type=Path, default=KEPT, metavar="DIR", help="answers; out/ablation by default")
    parser.add_argument("--out", type=Path, metavar="FILE", help="write the markdown there, too")
    parser.add_argument("--processes", type=int, default=2, metavar="N")
    parser.add_argument("--affected", action="store_true", help="count the logs on which values might change anything")
    parser.add_argument("--list", action="store_true", help="list all constants, and run nothing")
    return parser


def _groups(text: str) -> str:
    ablated_ones = [group.value for group in Group if group is not Group.WORKS_OUT]
    if not set(text.split(",")) <= set(ablated_ones):
        raise argparse.ArgumentTypeError(f"{text}: only {', '.join(ablated_ones)} are ablated")
    return text


def _moves(text: str) -> tuple[str, ...]:
    for move in text.split(","):
        if move != OFF and not float(move) > 0.0:
            raise argparse.ArgumentTypeError(f"{move} is no factor; give a number above 0, or {OFF}")
    return tuple(text.split(","))


if __name__ == "__main__":
    main()
