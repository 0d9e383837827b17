"""`cartgrasp study excitation`."""

from __future__ import annotations

import os
from pathlib import Path

from ..studies.claims import CLAIM_COLUMNS, all_kept, markdown_table
from ..studies.excitation import run_ways
from ..studies.excitation_figures_of_merit import COLUMNS, as_dict, claims, rows
from ..studies.excitation_plots import save_plots
from ..yaml_file import write_atomically
from .output import make_folder, print_json, print_table, progress, say

TITLE = "Standard deviations at the end (kg, m, m, kg·m²)"


def run(out: Path, as_json: bool, seed: int, seeds: int) -> int:
    make_folder(out)
    workers = max(1, min(os.cpu_count() or 1, 8))
    with progress("excitation") as tell:
        drives = run_ways(seeds, seed, workers, tell)
    promised, table = claims(drives), rows(drives)
    save_plots(drives, out)
    parts = [
        "# Excitation",
        f"Made by `cartgrasp study excitation --seed {seed} --seeds {seeds}`.",
        f"## {TITLE}",
        markdown_table(COLUMNS, table),
        "## Claims",
        markdown_table(CLAIM_COLUMNS, [claim.cells for claim in promised]),
    ]
    write_atomically(out / "excitation.md", "\n\n".join(parts))
    kept = all_kept(promised)
    if as_json:
        document = {"seed": seed, "seeds": seeds, "ways": [as_dict(drive) for drive in drives]}
        print_json({**document, "promises": [claim.as_dict() for claim in promised], "kept": kept, "out": str(out)})
    else:
        print_table(TITLE, COLUMNS, table)
        print_table("Claims", CLAIM_COLUMNS, [claim.cells for claim in promised], left=3)
    say(f"tables and plot are in {out}")
    return 0 if kept else 1
