"""`python -m benchmarks.true_structures DIR`: what could be reached at most on the sealed logs of DIR.

The nominal cart gets the effects that the truth names, and is fitted by the library as the workflow fits its own;
DIR/logs/NAME/refit.json tells the gap of its rollouts on held-out stretches, to which `sealed score` compares reports.
What the truth has in another form begins at its nearest values in ours. An effect without a name has no refit. This
stands beside the folder `sealed`, in which nothing is of the library.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from cartgrasp.cart_file import load_cart
from cartgrasp.effects import KNOWN_EFFECTS, Effect, SensorEffect
from cartgrasp.logs import read_log
from cartgrasp.writing import write_atomically

from .known_structure import refit

FILE = "refit.json"


def refit_all(folder: Path) -> int:
    """How many there are then; what is there already stays."""
    count = 0
    for path in sorted((folder / "truth").glob("*.json")):
        truth = json.loads(path.read_text(encoding="utf-8"))
        if any(effect["outside"] for effect in truth["effects"]):
            continue
        count += 1
        log = folder / "logs" / path.stem
        if not (log / FILE).is_file():
            write_atomically(log / FILE, json.dumps(refitted(log, truth), indent=1) + "\n")
    return count


def refitted(folder: Path, truth: Mapping[str, Any]) -> dict[str, Any]:
    log, cart = read_log(folder / "run.csv"), load_cart(folder / "cart.yaml")
    found = refit([log], cart, [effect_of(one, tuple(log.arms)) for one in truth["effects"]])
    names = {e.key: [p.name for p in e.parameters] for e in found.cart.effects}
    effects = {e.key: dict(zip(names[e.key], e.values.tolist(), strict=True)) for e in found.cart.effects}
    return {"gap": found.gap, "effects": effects}


def main() -> None:
    parser = argparse.ArgumentParser(
        "python -m benchmarks.true_structures", description="The true structures, refitted."
    )
    parser.add_argument("folder", type=Path, metavar="DIR")
    folder = parser.parse_args().folder
    print(f"{refit_all(folder)} true structures are refitted; beside them: python -m benchmarks.sealed score {folder}")


def effect_of(true: Mapping[str, Any], arms: tuple[str, ...]) -> Effect:
    kind = KNOWN_EFFECTS[true["name"]]
    by_arm = issubclass(kind, SensorEffect) and kind.by_arm and len(arms) > 1
    return kind(**{**true["parameters"], **true["roughly"]}, label=true["arm"] if by_arm else "")


if __name__ == "__main__":
    main()
