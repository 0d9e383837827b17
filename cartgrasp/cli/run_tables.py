"""The short tables of a run, and of what was learned, under the estimate's last health."""

from __future__ import annotations

from collections.abc import Mapping

from estimation.health import Health

from ..checks import unrounded
from ..motion import ParameterEstimate
from ..studies.run_figures import RunFigures
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


def print_parameters(
    title: str, parameters: Mapping[str, ParameterEstimate], taught: str, health: str = Health.OK
) -> None:
    """A table, without what stands as the cart's file has it; `taught` heads its last column."""
    rows = [
        [
            name,
            f"{unrounded(p.value, p.std):.5g}",
            f"{p.std:.2g}",
            p.unit,
            identifiable_word(p.identifiable, health),
        ]
        for name, p in parameters.items()
        if p.std > 0
    ]
    print_table(title, ["parameter", "value", "sd", "unit", taught], rows)


def identifiable_word(is_identifiable: bool, health: str = Health.OK) -> str:
    """`yes` only under a health that is ok."""
    return "yes" if is_identifiable and health == Health.OK else "no"


def print_health(health: str, model: str = "the model") -> None:
    """What follows of one that is not ok, of the model that is so called."""
    if health == Health.INCONSISTENT:
        print(f"- {model} does not fit this log, so it taught nothing: `cartgrasp discrepancy` tells what is missing")
    elif health != Health.OK:
        print(f"- health: {health}, so nothing counts as taught")
