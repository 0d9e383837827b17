"""`cartgrasp study robust`."""

from __future__ import annotations

import os
from pathlib import Path

from ..studies.claims import CLAIM_COLUMNS, all_kept, markdown_table
from ..studies.robust_margins import run_seeds
from ..studies.robust_margins_figures_of_merit import COLUMNS, as_dict, claims, rows
from ..studies.robust_margins_plots import save_plots
from ..yaml_file import write_atomically
from .output import make_folder, print_json, print_table, progress, say

TITLE = "Margins while the load is learned (at hard ticks; effort in N²)"


def run(out: Path, as_json: bool, seed: int, seeds: int) -> int:
    make_folder(out)
    workers = max(1, min(os.cpu_count() or 1, 8))
    with progress("robust margins") as tell:
        runs = run_seeds(range(seed, seed + seeds), workers, tell)
    promised, table = claims(runs), rows(runs)
    save_plots(runs, out)
    parts = [
        "# Robust margins",
        f"Made by `cartgrasp study robust --seed {seed} --seeds {seeds}`.",
        f"## {TITLE}",
        markdown_table(COLUMNS, table),
        "## Claims",
        markdown_table(CLAIM_COLUMNS, [claim.cells for claim in promised]),
    ]
    write_atomically(out / "robust.md", "\n\n".join(parts))
    kept = all_kept(promised)
    if as_json:
        document = {"seed": seed, "seeds": seeds, "runs": [as_dict(one) for one in runs]}
        print_json({**document, "promises": [claim.as_dict() for claim in promised], "kept": kept, "out": str(out)})
    else:
        print_table(TITLE, COLUMNS, table)
        print_table("Claims", CLAIM_COLUMNS, [claim.cells for claim in promised], left=3)
    say(f"tables and plot are in {out}")
    return 0 if kept else 1
