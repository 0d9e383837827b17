"""The short tables of a run."""

from __future__ import annotations

from ..studies.run_figures import RunFigures
from .identifiability_text import identifiable_word, print_health
from .output import print_table


def print_run(figures: RunFigures, title: str) -> None:
    """Tracking and forces, then the parameters beside their truth."""
    f = figures
    rows = [
        ["duration", f"{f.duration:.1f} s"],
        ["tracking error, largest", f"{100 * f.largest_error:.2f} cm"],
        ["tracking error, largest from 5 s on", f"{100 * f.error_after_5:.2f} cm"],
        ["tracking error, rms", f"{100 * f.rms_error:.2f} cm"],
        ["plans, optimal", f"{f.optimal} of {f.plans}"],
        ["regrasps", str(f.regrasps)],
        ["largest force of a hand", f"{f.largest_force:.1f} N"],
    ]
    print_table(title, ["what was achieved", "figure"], rows)
    learned = [
        [
            name,
            "" if p["truth"] is None else f"{p['truth']:.4g}",
            f"{p['value']:.4g}",
            f"{p['std']:.2g}",
            p["unit"],
            identifiable_word(p["identifiable"], f.health),
        ]
        for name, p in f.parameters.items()
        if p["std"] > 0
    ]
    if learned:
        title = f"what was learned, health: {f.health}"
        print_table(title, ["parameter", "truth", "estimate", "sd", "unit", "taught"], learned)
        print_health(f.health)
