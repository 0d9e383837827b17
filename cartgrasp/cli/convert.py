"""`cartgrasp convert IN [--topics topics.yaml] [--salvage] --out run.csv`."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from ..errors import UsageError, printable
from ..logs import WRITERS, files_of, is_bag_name, read_log, read_mapped, write_log
from ..logs.provenance import provenance
from ..strict_json import finite
from ..writing import write_atomically
from .output import check_writable, print_json, say

MAX_LOSSES_SHOWN = 20


def run(source: Path, out: Path, topics: Path | None, salvage: bool, as_json: bool) -> int:
    files = files_of(source, topics)
    check_writable(out, topics, *files)
    if out.suffix.lower() not in WRITERS:
        raise UsageError(f"--out {out}: name a file that ends in {', '.join(WRITERS)}")
    if salvage and not is_bag_name(source):
        raise UsageError(f"--salvage: is for bags; {source} is none")
    steps: list[dict[str, Any]] = []
    lost: list[str] = []
    topic_map = None
    reading = read_mapped(source, topics, salvage)
    if reading is None:
        log = read_log(source)
    else:
        log, lost, topic_map = reading.log, list(reading.lost), reading.map.model_dump()
        steps = [{"of": step.of, "what": step.what, **step.figures} for step in reading.steps]
    write_log(log, out)
    document = finite(provenance(files, out, steps, lost, topic_map))
    beside = out.with_name(f"{out.name}.provenance.json")
    write_atomically(beside, json.dumps(document, indent=2, ensure_ascii=False, allow_nan=False) + "\n")
    if as_json:
        print_json({"log": str(out), "provenance": str(beside), "rows": len(log), "steps": steps, "lost": lost})
    else:
        for step in log.notes.values():
            print(printable(step))
        arms = f"arms {', '.join(log.arms)}" if log.arms else "no arm: the cart coasts"
        print(f"{out}: {len(log)} rows over {log.duration:.2f} s, {arms}")
    for what in lost[:MAX_LOSSES_SHOWN]:
        say(printable(f"lost: {what}"))
    if len(lost) > MAX_LOSSES_SHOWN:
        say(f"lost: and {len(lost) - MAX_LOSSES_SHOWN} more; all are in {beside}")
    return 0
