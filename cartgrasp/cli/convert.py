"""`cartgrasp convert IN [--topics topics.yaml] [--salvage] --out run.csv`."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..errors import UsageError, printable
from ..logs import WRITERS, RunLog, is_bag_name, read_log, read_mapped, write_log
from ..logs.provenance import provenance
from ..strict_json import finite
from ..writing import write_atomically
from .output import check_writable, print_json, say

MAX_LOSSES_SHOWN = 20


@dataclass(frozen=True)
class Choice:
    """The options of the command."""

    source: Path
    out: Path
    topics: Path | None
    salvage: bool


def run(choice: Choice, as_json: bool) -> int:
    _check(choice)
    log, steps, lost, topic_map = _read(choice)
    write_log(log, choice.out)
    document = finite(provenance(choice.source, choice.out, steps, lost, topic_map))
    beside = choice.out.with_name(f"{choice.out.stem}.provenance.json")
    write_atomically(beside, json.dumps(document, indent=2, ensure_ascii=False, allow_nan=False) + "\n")
    if as_json:
        print_json({"log": str(choice.out), "provenance": str(beside), "rows": len(log), "steps": steps, "lost": lost})
    else:
        for step in log.notes.values():
            print(printable(step))
        print(f"{choice.out}: {len(log)} rows over {log.duration:.2f} s, {_arms(log)}")
    for what in lost[:MAX_LOSSES_SHOWN]:
        say(printable(f"lost: {what}"))
    if len(lost) > MAX_LOSSES_SHOWN:
        say(f"lost: and {len(lost) - MAX_LOSSES_SHOWN} more; all are in {beside}")
    return 0


def _arms(log: RunLog) -> str:
    return f"arms {', '.join(log.arms)}" if log.arms else "no arm: the cart coasts"


def _check(choice: Choice) -> None:
    check_writable(choice.out, choice.source, choice.topics)
    if choice.out.suffix.lower() not in WRITERS:
        raise UsageError(f"--out {choice.out}: name a file that ends in {', '.join(WRITERS)}")
    if choice.salvage and not is_bag_name(choice.source):
        raise UsageError(f"--salvage: is for bags; {choice.source} is none")


def _read(choice: Choice) -> tuple[RunLog, list[dict[str, Any]], list[str], dict[str, Any] | None]:
    """The log, the steps that made it, what was lost, and the map."""
    reading = read_mapped(choice.source, choice.topics, choice.salvage)
    if reading is None:
        return read_log(choice.source), [], [], None
    steps = [{"of": step.of, "what": step.what, **step.figures} for step in reading.steps]
    return reading.log, steps, list(reading.lost), reading.map.model_dump()
