"""`cartgrasp topics FILE [--out MAP]`: of a bag, or of a table (`table_topics.py`)."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from ..errors import UsageError, printable
from ..logs import TABLES
from ..logs.bags.contents import contents_of, proposed_map
from ..logs.bags.opening import open_bag
from ..writing import write_atomically
from .output import check_writable, print_json, print_table, say


def run(path: Path, out: Path | None, salvage: bool, as_json: bool, ask: bool, beside: Sequence[Path]) -> int:
    if out is not None:
        check_writable(out)
        if out.exists():
            raise UsageError(f"--out {out}: is there already, perhaps filled in; remove it, or name another place")
    if path.suffix.lower() in TABLES and not path.is_dir():
        if salvage:
            raise UsageError(f"--salvage: is for bags; {path} is none")
        from . import table_topics

        return table_topics.run(path, beside, out, ask, as_json)
    if ask or beside:
        raise UsageError(f"{'--ask' if ask else '--with'}: is for tables ({', '.join(TABLES)}); {path} is none")
    bag = open_bag(path, salvage)
    contents = contents_of(bag)
    start = min((c.first for c in contents if c.count), default=0)
    proposal = proposed_map(contents, path.name)
    if as_json:
        print_json({"topics": [c.as_dict(start) for c in contents], "proposal": proposal, "lost": bag.lost})
    else:
        rows = []
        for c in contents:
            times = [f"{(t - start) / 1e9:.3f}" if c.count else "" for t in (c.first, c.last)]
            rate, kind = f"{c.rate:.1f}" if c.rate else "", c.kind.rpartition("/")[2]
            rows.append([printable(c.name), printable(kind), str(c.count), rate, *times])
        print_table(path.name, ["topic", "type", "messages", "Hz", "first, s", "last, s"], rows, left=2)
    for lost in bag.lost:
        say(printable(f"lost: {lost}"))
    if proposal is None:
        say("no map is proposed: a topic with poses (Odometry, PoseStamped, TF) is needed")
    elif out is None:
        say(f"a map is proposed with --out {path.name}.topics.yaml")
    else:
        write_atomically(out, proposal)
        say(f"fill in what is blank in {out}; then `cartgrasp convert {path} --topics {out} --out run.csv`")
    return 0
