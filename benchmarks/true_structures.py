"""`python -m benchmarks.true_structures DIR`: what could be reached at most on the sealed logs of DIR.

The nominal cart gets the effects that the truth names, and is fitted by the library as the workflow fits its own;
DIR/logs/NAME/refit.json tells the gap of its rollouts on held-out stretches, to which `sealed score` compares reports.
What the truth has in another form begins at its nearest values in ours. An effect without a name has no refit. This
stands beside the folder `sealed`, in which nothing is of the library.

With `--reports out-METHOD`, what the names of that method's reports reach, into DIR/logs/NAME/out-METHOD/refit.json: a
method that tells no gap is scored by that. Where it names what the workflow does, the workflow's own gap is taken.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from cartgrasp.cart_file import load_cart
from cartgrasp.effects import KNOWN_EFFECTS, Effect, SensorEffect
from cartgrasp.logs import read_log
from cartgrasp.writing import write_atomically

from .known_structure import refit
from .sealed.locality import named
from .sealed.score import contents, names

FILE = "refit.json"


def refit_all(folder: Path) -> int:
    """How many there are then; what is there already stays."""
    count = 0
    for path in sorted((folder / "truth").glob("*.json")):
        truth = json.loads(path.read_text(encoding="utf-8"))
        if not any(effect["outside"] for effect in truth["effects"]):
            count += 1
            put(folder / "logs" / path.stem, "", truth["effects"])
    return count


def refit_told(folder: Path, reports: str) -> int:
    """As `refit_all`, of names that a method tells, where the workflow tells others."""
    count = 0
    for log in sorted(path.parents[1] for path in folder.glob("logs/*/out/report.json")):
        ours, told = (contents(log / out / "report.json") for out in ("out", reports))
        if told and told["effects"] and names(told) != names(ours):
            count += 1
            put(log, reports, named(told))
    return count


def put(log: Path, out: str, effects: Sequence[Mapping[str, Any]]) -> None:
    path = log / out / FILE
    if not path.is_file():
        write_atomically(path, json.dumps(refitted(log, effects), indent=1) + "\n")


def refitted(folder: Path, effects: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    log, cart = read_log(folder / "run.csv"), load_cart(folder / "cart.yaml")
    found = refit([log], cart, [effect_of(one, tuple(log.arms)) for one in effects])
    values = {
        e.key: dict(zip((p.name for p in e.parameters), e.values.tolist(), strict=True)) for e in found.cart.effects
    }
    return {"gap": found.gap, "effects": values}


def main() -> None:
    parser = argparse.ArgumentParser(
        "python -m benchmarks.true_structures", description="The true structures, refitted."
    )
    parser.add_argument("folder", type=Path, metavar="DIR")
    parser.add_argument("--reports", metavar="NAME", help="folder beside each log; what its reports name, instead")
    options = parser.parse_args()
    folder, reports = options.folder, options.reports
    count = refit_told(folder, reports) if reports else refit_all(folder)
    more = f" --reports {reports}" if reports else ""
    print(f"{count} structures are refitted; beside them: python -m benchmarks.sealed score {folder}{more}")


def effect_of(true: Mapping[str, Any], arms: tuple[str, ...]) -> Effect:
    """A value that no such effect can have, as a regression may tell, becomes the nearest that it can."""
    kind = KNOWN_EFFECTS[true["name"]]
    by_arm = issubclass(kind, SensorEffect) and kind.by_arm and len(arms) > 1
    limits = {p.name: (p.lower, p.upper) for p in kind().parameters}
    values = {
        name: float(np.clip(value, *limits[name])) for name, value in (true["parameters"] | true["roughly"]).items()
    }
    return kind(**values, label=true["arm"] if by_arm else "")


if __name__ == "__main__":
    main()
