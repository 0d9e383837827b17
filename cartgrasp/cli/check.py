"""`cartgrasp check LOG [--cart cart.yaml]`: what a log's sensors seem to do, before anything is learned from it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from estimation.sensor_check import REFUSED, SURE, Suspicion, travelled

from ..cart_file import load_cart
from ..errors import printable
from ..logs import RunLog, read_log
from ..logs.coasting import without_idle_arms
from .output import print_json, print_table, say
from .sensors import check_accepted, refuse, suspected


def run(path: Path, cart_path: Path | None, accepted: Sequence[str], topics: Path | None, as_json: bool) -> int:
    """Raises DataError where something makes every estimate worthless, and isn't accepted."""
    check_accepted(accepted)
    cart = None if cart_path is None else load_cart(cart_path)
    log = read_log(path, topics)
    suspicions = suspected(log, cart)
    document = _document(log, travelled(without_idle_arms(log)), suspicions)
    if as_json:
        print_json(document)
    else:
        _print(document, cart is not None)
    refuse(log, suspicions, accepted)
    return 0


def _document(log: RunLog, way: float, suspicions: Sequence[Suspicion]) -> dict[str, Any]:
    fields = ("kind", "where", "probability", "factor", "words")
    return {
        "rows": len(log),
        "span": log.duration,
        "rate": float(1 / np.median(np.diff(log.time))),
        "arms": list(log.arms),
        "travelled": way,
        "suspicions": [{name: getattr(one, name) for name in fields} for one in suspicions],
    }


def _print(document: dict[str, Any], has_cart: bool) -> None:
    arms = ", ".join(printable(arm) for arm in document["arms"]) or "none"
    say(
        f"{document['rows']} rows over {document['span']:.1f} s at {document['rate']:.0f} Hz, "
        f"{document['travelled']:.1f} m; arms: {arms}"
    )
    if not document["suspicions"]:
        say("nothing is suspected of its sensors")
        if document["arms"] and not has_cart:
            say("wrenches and headings were not judged: say --cart cart.yaml")
        return
    rows = [[one["kind"], one["where"], f"{one['probability']:.2f}"] for one in document["suspicions"]]
    print_table(f"suspicions (from {SURE:g} on {', '.join(REFUSED)} stop)", ["kind", "where", "probability"], rows)
    for one in document["suspicions"]:
        say(one["words"])
