"""`python -m benchmarks.tables [--seeds 0:60] [--faults 0:10] [--sound 0:100] [--out FILE]`: made tables of strangers'
kinds, each asked about as `cartgrasp topics` does, and its map judged; and tables whose labels, axes or signs are
wrong."""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path

from .faults import sound, table_of_faults, told
from .judging import Judged, judge
from .strangers import write


def table_of(judged: list[tuple[int, Judged]]) -> str:
    right, silent = sum(one.is_right for _, one in judged), sum(one.is_silently_wrong for _, one in judged)
    lines = [
        f"{right} of {len(judged)} proposed maps are right, {silent} wrong in silence.",
        "",
        "| seed | table | right | wrong in silence | guesses | blanks | what was wrong |",
        "| --- | --- | --- | --- | --- | --- | --- |",
    ]
    for seed, one in judged:
        cells = [str(seed), one.kind, "yes" if one.is_right else "no", "**yes**" if one.is_silently_wrong else "no"]
        lines.append("| " + " | ".join([*cells, str(one.guesses), str(one.blanks), one.why.replace("|", "/")]) + " |")
    return "\n".join(lines) + "\n"


def main() -> None:
    parser = argparse.ArgumentParser("python -m benchmarks.tables", description=__doc__)
    parser.add_argument("--seeds", default="0:60", help="FROM:TO")
    parser.add_argument("--faults", default="0:0", help="FROM:TO, of pushes into whose table each fault is put")
    parser.add_argument("--sound", default="0:0", help="FROM:TO, of pushes that are asked about as they are")
    parser.add_argument("--span", type=float, default=float("inf"), help="s, of which those are recorded at most")
    parser.add_argument("--keep", type=Path, help="folder in which the tables stay")
    parser.add_argument("--out", type=Path, help="write the table there instead of printing it")
    options = parser.parse_args()
    asked = options.seeds, options.faults, options.sound
    seeds, faulty, whole = (range(*map(int, said.split(":"))) for said in asked)
    with tempfile.TemporaryDirectory() as temporary:
        root = options.keep or Path(temporary)
        judged = [(seed, judge(write(root / str(seed) / "run", seed), root / str(seed))) for seed in seeds]
        faults = [one for seed in whole for one in sound(root / "faults", seed, options.span)]
        faults += [one for seed in faulty for one in told(root / "faults", seed, span=options.span)]
    text = table_of(judged) + ("\n" + table_of_faults(faults) if faults else "")
    if options.out is None:
        print(text, end="")
    else:
        options.out.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
