"""`python -m benchmarks.filter_hidden DIR [--workers 1]`: what the online filter says where its cart lacks something.

DIR is what `python -m benchmarks.sealed generate --out DIR` writes: logs, carts' files, and what is hidden from these.
A tick counts from 5 s on. It is sure and wrong where health is `ok`, the mass `identifiable`, and its error more than 3
or 5 deviations. What scales a wrench scales a mass, too, and can't be told by any motion.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from itertools import groupby
from pathlib import Path

import numpy as np

from cartgrasp.cart_file import load_cart
from cartgrasp.cli.output import progress
from cartgrasp.logs import read_log
from cartgrasp.studies.parallel import run_all
from estimation import CartFilter
from estimation.whole_log.replay import replay

SETTLED = 5.0
LOADING = 2.0
"""s after a load within which its mass is no number."""


@dataclass(frozen=True)
class Said:
    """Of a log: the share of ticks with an `ok` health, of those that say that the mass is taught, and of those in
    which that is off by more than three and by more than five deviations; the error at the end, as a share, and
    whether it was sure of that."""

    case: str
    ok: float
    taught: float
    off_by_three: float
    off_by_five: float
    off: float
    is_sure: bool


def said(name: str, folder: Path) -> Said:
    truth = json.loads((folder / "truth" / f"{name}.json").read_text(encoding="utf-8"))
    log, cart = read_log(folder / "logs" / name / "run.csv"), load_cart(folder / "logs" / name / "cart.yaml")
    told = replay(log, CartFilter(cart, list(log.arms))).estimates
    time = np.array([one.time for one in told])
    mass, counts = np.full(len(time), float(truth["cart"]["mass"])), time > SETTLED
    for effect in truth["effects"]:
        if effect["name"] == "payload_change":
            since = float(effect["parameters"]["time"])
            mass[time >= since] += float(effect["parameters"]["mass"])
            counts &= (time < since) | (time > since + LOADING)
    masses = [one.parameters["mass"] for one in told]
    off = np.array([one.value for one in masses]) - mass
    deviations = np.abs(off) / np.array([one.std for one in masses])
    ok = np.array([one.health == "ok" for one in told])
    taught = ok & np.array([one.identifiable for one in masses])
    shares = (ok, taught, taught & (deviations > 3.0), taught & (deviations > 5.0))
    means = [float(share[counts].mean()) for share in shares]
    return Said(str(truth["case"]), *means, float(off[-1] / mass[-1]), bool(taught[-1]))


def table(found: Sequence[Said]) -> str:
    heads = [
        "hidden",
        "logs",
        "ticks `ok`",
        "taught",
        "off by 3 sd",
        "by 5 sd",
        "sure at the end",
        "mass off then, rms",
    ]
    rows = [heads, ["---"] * len(heads)]
    by_case = [list(group) for _, group in groupby(sorted(found, key=lambda one: one.case), lambda one: one.case)]
    for name, group in [*((group[0].case, group) for group in by_case), ("all", list(found))]:
        shares = np.array([[one.ok, one.taught, one.off_by_three, one.off_by_five] for one in group]).mean(axis=0)
        sure = np.array([one.off for one in group if one.is_sure])
        rms = f"{100 * np.sqrt(np.mean(sure**2)):.1f} %" if len(sure) else ""
        cells = [f"{100 * share:.0f} %" for share in shares[:2]] + [f"{100 * share:.1f} %" for share in shares[2:]]
        rows.append([name, str(len(group)), *cells, str(len(sure)), rms])
    return "\n".join(f"| {' | '.join(row)} |" for row in rows)


def main() -> None:
    parser = argparse.ArgumentParser("python -m benchmarks.filter_hidden", description=__doc__)
    parser.add_argument("folder", type=Path, metavar="DIR")
    parser.add_argument("--workers", type=int, default=1, metavar="N")
    options = parser.parse_args()
    names = sorted(file.stem for file in (options.folder / "truth").glob("*.json"))
    with progress("filter") as share:
        print(table(run_all(partial(said, folder=options.folder), names, options.workers, share)))


if __name__ == "__main__":
    main()
