"""`python -m benchmarks.measured`: truth beside what the commands say of measured logs, and of variants of them."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterable
from pathlib import Path

from cartgrasp.writing import write_atomically

from .judging import Judgement
from .logs import LOGS, undeclared
from .running import ROOT, Job, Outcome, jobs_of, run_all
from .table import progress, section
from .variants import AS_IT_IS

DATA = ROOT.parent / "shared" / "data"
KEPT = ROOT / "out" / "measured"


def main() -> None:
    options = _options()
    if not options.data.is_dir():
        sys.exit(f"{options.data}: there is no such folder; the measured logs are no part of the project (see --data)")
    jobs = jobs_of(LOGS, options.data, options.kept, not options.no_variants)
    jobs = [job for job in jobs if _is_wanted(job, options.only)]
    if not jobs:
        sys.exit(
            f"--only {' '.join(options.only)}: is in the name of no log and variant; they are named as in the table"
        )
    outcomes = []
    for outcome in run_all(jobs, options.processes):
        outcomes.append(outcome)
        print(progress(len(outcomes), len(jobs), outcome), file=sys.stderr, flush=True)
    text = section(judged(jobs, outcomes), undeclared(options.data))
    print(text)
    if options.out:
        options.out.parent.mkdir(parents=True, exist_ok=True)
        write_atomically(options.out, text)


def judged(jobs: Iterable[Job], outcomes: Iterable[Outcome]) -> list[Judgement]:
    """In the order of the jobs; variants beside their log as it is."""
    found = {(one.log, one.variant): one for one in outcomes}
    told = []
    for job in jobs:
        base = None if job.variant is AS_IT_IS else found.get((job.log.name, AS_IT_IS.name))
        told.append(Judgement(job.log, found[job.log.name, job.variant.name], base))
    return told


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        "python -m benchmarks.measured", description="Measured logs, and variants of them."
    )
    parser.add_argument("--data", type=Path, default=DATA, metavar="DIR", help="the data; ../shared/data by default")
    parser.add_argument("--kept", type=Path, default=KEPT, metavar="DIR", help="answers; out/measured by default")
    parser.add_argument("--out", type=Path, metavar="FILE", help="write the section of markdown there, too")
    parser.add_argument(
        "--only", nargs="+", default=[], metavar="TEXT", help="logs and variants with one of these in `LOG, VARIANT`"
    )
    parser.add_argument("--no-variants", action="store_true", help="logs as they are, alone")
    parser.add_argument("--processes", type=int, default=2, metavar="N")
    return parser.parse_args()


def _is_wanted(job: Job, texts: list[str]) -> bool:
    return not texts or any(text in f"{job.log.name}, {job.variant.name}" for text in texts)


if __name__ == "__main__":
    main()
