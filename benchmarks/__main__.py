"""`python -m benchmarks [--quick] [--out FILE] [NAME ...]`."""

from __future__ import annotations

import argparse
import sys
from importlib.util import find_spec
from pathlib import Path

from . import (
    allocation,
    bags,
    campaign,
    contact_choice,
    contact_relaxation,
    dynamics,
    estimators,
    filter_step,
    plants,
    postures,
    schedule,
    solvers,
    start_up,
    ticks,
)
from .report import document
from .sysid_peer import installed

BENCHMARKS = {
    "allocation": (allocation.run, 200),
    "bags": (bags.run, 5),
    "campaign": (campaign.run, 1000),
    "contact_choice": (contact_choice.run, 100),
    "contact_relaxation": (contact_relaxation.run, 60),
    "dynamics": (dynamics.run, 200),
    "estimators": (estimators.run, 200),
    "filter_step": (filter_step.run, 200),
    "plants": (plants.run, 20),
    "postures": (postures.run, 60),
    "schedule": (schedule.run, 20),
    "solvers": (solvers.run, 200),
    "start_up": (start_up.run, 20),
    "ticks": (ticks.run, 200),
}
QUICK = 3
PEERS = ("quadprog", "piqp", "proxsuite", "filterpy")


def main() -> None:
    parser = argparse.ArgumentParser("python -m benchmarks", description="Speed beside other programs.")
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"of {', '.join(BENCHMARKS)}; all by default")
    parser.add_argument("--quick", action="store_true", help=f"{QUICK} rounds each: only to see that all run")
    parser.add_argument("--out", type=Path, metavar="FILE", help="write markdown there instead of printing it")
    options = parser.parse_args()
    unknown = [name for name in options.names if name not in BENCHMARKS]
    if unknown:
        parser.error(f"no benchmark {unknown[0]!r}; there are {', '.join(BENCHMARKS)}")
    results = []
    for name in options.names or BENCHMARKS:
        run, rounds = BENCHMARKS[name]
        print(f"{name} ...", file=sys.stderr)
        results.append(run(QUICK if options.quick else rounds))
    missing = [name for name in PEERS if find_spec(name) is None] + ["mujoco.sysid"] * (not installed())
    text = document(results, f"python -m benchmarks {' '.join(sys.argv[1:])}".strip(), missing)
    if options.out is None:
        print(text)
    else:
        options.out.parent.mkdir(parents=True, exist_ok=True)
        options.out.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
