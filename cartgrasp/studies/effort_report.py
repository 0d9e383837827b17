"""The study of effort in tables, claims and a figure."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from itertools import product
from math import isfinite
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from ..view.plots import OKABE_ITO, house_style, legend_above
from .effort import (
    BEST_PLACE,
    CHOSEN_PLACE,
    GAIN_RANGE,
    GRIP_CHOICES,
    HANDS,
    KNOWLEDGE,
    LEARNED,
    MIDDLE_PLACE,
    MOMENT_WEIGHT,
    USUAL_LOAD_KEPT,
    WRONG_GUESS_KEPT,
    Comparison,
    RunCost,
    best_by_statics,
)
from .findings import Claim, Findings, Section

STATIC_COM_OFFSETS, FORCE_ONLY_MOMENT_WEIGHT = (0.0, 0.05, 0.1, 0.15, 0.2), 1e4
BASELINE, MAX_FORCE_RATIO = (LEARNED, MIDDLE_PLACE), 0.8
SHARE_FIGURES = ("force", "moment", "largest_force", "largest_moment", "effort")
WAY_TITLE = (
    "By what is known and where it is held: medians of shares of what the learned cart pays, held in the middle, over "
    "the trucks that have its rms position error at some gains (interpolated; else the error that comes nearest)"
)
WAY_COLUMNS = (
    *("way", "reach it", "gains", "force", "moment", "largest force", "largest moment", "effort"),
    *("error of others", "fell"),
)
TRUCK_TITLE = (
    "By truck: rms force N, moment N·m (largest of each) at the same error; in brackets the error, where it is not"
)
TRUCK_WAYS = (
    (WRONG_GUESS_KEPT, MIDDLE_PLACE),
    (USUAL_LOAD_KEPT, MIDDLE_PLACE),
    BASELINE,
    (LEARNED, BEST_PLACE),
    (LEARNED, CHOSEN_PLACE),
)
STATIC_TITLE = "What the best place leaves of the middle's rms force; effort, by statics, CoM aside by"


def findings(found: Sequence[Comparison]) -> Findings:
    promised = claims(found)
    truck_columns = ("truck", "error mm", *(", ".join(way) for way in TRUCK_WAYS))
    static_columns = ("hands", *(f"{100 * aside:g} cm" for aside in STATIC_COM_OFFSETS))
    static_rows = [_static_row(hands, alone) for hands in HANDS for alone in (False, True)]
    sections = [
        Section(WAY_TITLE, WAY_COLUMNS, [_way_row(found, way) for way in product(KNOWLEDGE, GRIP_CHOICES)]),
        Section(TRUCK_TITLE, truck_columns, [_truck_row(one) for one in found]),
        Section(STATIC_TITLE, static_columns, static_rows),
        Section.of_claims("Claims", promised),
    ]
    return Findings(
        "What hands pay at equal tracking error", sections, {"runs": [as_dict(one) for one in found]}, promised
    )


def shares(found: Sequence[Comparison], figure: str, way: tuple[str, str]) -> list[float]:
    """A figure as shares of what the learned cart pays in the middle. Only trucks that reach its error count."""
    every = [one.share(figure, way, BASELINE) for one in found]
    return [share for share in every if isfinite(share)]


def claims(found: Sequence[Comparison]) -> list[Claim]:
    offset = [one for one in found if one.job.aside >= 0.1]
    off = [(one, way) for one in found for way in (WRONG_GUESS_KEPT, USUAL_LOAD_KEPT) if _is_off(one, way)]
    missed = sum(not one.paid[way, MIDDLE_PLACE].is_equal(one.error) for one, way in off)
    forces = [one.paid[way, MIDDLE_PLACE].force / one.paid[BASELINE].force for one, way in off]
    dearer = [force for force in forces if isfinite(force)]
    kept = [1 / s for way in (WRONG_GUESS_KEPT, USUAL_LOAD_KEPT) for s in shares(found, "force", (way, MIDDLE_PLACE))]
    chosen, best = (shares(offset, "force", (LEARNED, place)) for place in (CHOSEN_PLACE, BEST_PLACE))
    effort = shares(offset, "effort", (LEARNED, BEST_PLACE))
    wished = partial(_at_most, most=MAX_FORCE_RATIO, promised=False)
    both = [s for one in offset if one.job.hands == 2 for s in shares([one], "effort", (LEARNED, CHOSEN_PLACE))]
    return [
        Claim(
            "guesses kept",
            f"off by twice the mass or more: most do not reach the error at gains up to {GAIN_RANGE[1]:g} times "
            "the usual",
            f"{len(off) - missed} of {len(off)} reach it",
            missed > len(off) / 2,
        ),
        Claim(
            "guesses kept",
            "these pay 10 % more rms force than the learned cart at its error",
            f"{np.median(dearer):.2f} times in the median of {len(dearer)} that do not fall",
            bool(np.median(dearer) >= 1.1),
            promised=False,
        ),
        wished("learned", "20 % less rms force than a guess kept that has its error", kept),
        wished("offset CoM", "chosen places: 20 % less rms force than the middle", chosen),
        wished("offset CoM", "the best place by the truth: 20 % less rms force", best),
        _at_most("offset CoM", "the best place by the truth: 10 % less effort", effort, 0.9),
        _at_most("offset CoM, two hands", "chosen places: less effort than the middle", both, 1.0),
    ]


def as_dict(one: Comparison) -> dict[str, Any]:
    """The comparison as `--json` has it."""
    paid = {", ".join(way): vars(figures) for way, figures in one.paid.items()}
    return {**vars(one.job), "error": one.error, "paid": paid}


def figure(found: Sequence[Comparison]) -> Figure:
    """Shares of rms force and effort by place against the CoM's offset, and of error against force by knowledge."""
    with house_style():
        page = Figure(figsize=(7.2, 4.6), layout="constrained")
        panels = page.subplots(2, 2)
        for row, hands in zip(panels, HANDS, strict=True):
            ours = [one for one in found if one.job.hands == hands]
            _draw_places(row[0], ours)
            _draw_knowledge(row[1], ours)
            row[0].set_ylabel(f"Share of the middle's\n({hands} hand{'s' * (hands > 1)})")
        for axes in panels[1]:
            axes.set_xlabel("CoM aside (m)" if axes is panels[1][0] else "Position error (share of the learned cart's)")
        for axes in panels[0]:
            legend_above(axes)
    return page


# --- rows and panels ------------------------------------------------------------------------------------------


def _at_most(where: str, words: str, found: Sequence[float], most: float, promised: bool = True) -> Claim:
    if not found:
        return Claim(where, words, "no truck has the error", False, promised)
    middle = float(np.median(found))
    told = f"{middle:.2f} in the median of {len(found)} ({min(found):.2f} to {max(found):.2f})"
    return Claim(where, words, told, middle <= most, promised)


def _is_off(one: Comparison, knowledge: str) -> bool:
    believed = 15.0 if knowledge == WRONG_GUESS_KEPT else 40.0
    return max(believed / one.job.mass, one.job.mass / believed) >= 2.0


def _way_row(found: Sequence[Comparison], way: tuple[str, str]) -> tuple[str, ...]:
    paid = [(one.paid[way], one.error) for one in found]
    gains = [one.gain for one, error in paid if one.is_equal(error)]
    others = [one.error / error for one, error in paid if not one.is_equal(error) and isfinite(one.error)]
    return (
        ", ".join(way),
        f"{len(gains)} of {len(found)}",
        _median(gains),
        *(_median(shares(found, name, way)) for name in SHARE_FIGURES),
        _median(others, "×"),
        str(sum(not isfinite(one.error) for one, _ in paid)),
    )


def _median(values: Sequence[float], unit: str = "") -> str:
    return f"{np.median(values):.2f}{unit}" if len(values) else "-"


def _truck_row(one: Comparison) -> tuple[str, ...]:
    job = one.job
    name = f"{job.hands} hand{'s' * (job.hands > 1)}, {job.mass:g} kg, {100 * job.aside:g} cm"
    return name, f"{1000 * one.error:.1f}", *(_cell(one.paid[way], one.error) for way in TRUCK_WAYS)


def _cell(paid: RunCost, error: float) -> str:
    if not isfinite(paid.error):
        return "falls"
    if not paid.is_equal(error):
        return f"[{1000 * paid.error:.1f} mm]"
    return f"{paid.force:.1f}, {paid.moment:.2f} ({paid.largest_force:.0f}, {paid.largest_moment:.1f})"


def _static_row(hands: int, alone: bool) -> tuple[str, ...]:
    weight = FORCE_ONLY_MOMENT_WEIGHT if alone else MOMENT_WEIGHT
    found = [best_by_statics(aside, hands, weight) for aside in STATIC_COM_OFFSETS]
    name = f"{hands}, that give {'forces alone' if alone else 'moments, too'}"
    return name, *(f"{force:.2f}; {effort:.2f}" for force, effort in found)


def _draw_places(axes: Any, found: Sequence[Comparison]) -> None:
    for k, place in enumerate((BEST_PLACE, CHOSEN_PLACE)):
        for name, style in (("force", "o-"), ("effort", "s--")):
            offsets = sorted({one.job.aside for one in found})
            every = [shares([one for one in found if one.job.aside == x], name, (LEARNED, place)) for x in offsets]
            middle = [np.median(each) if each else np.nan for each in every]
            axes.plot(offsets, middle, style, color=OKABE_ITO[k], label=f"{place}: {'rms ' * (name == 'force')}{name}")
    axes.axhline(1.0, color="0.6", linewidth=0.8)


def _draw_knowledge(axes: Any, found: Sequence[Comparison]) -> None:
    for k, knowledge in enumerate((WRONG_GUESS_KEPT, USUAL_LOAD_KEPT)):
        stood = [one for one in found if isfinite(one.paid[knowledge, MIDDLE_PLACE].error)]
        paid = [one.paid[knowledge, MIDDLE_PLACE] for one in stood]
        error = [way.error / one.error for way, one in zip(paid, stood, strict=True)]
        force = [way.force / one.paid[BASELINE].force for way, one in zip(paid, stood, strict=True)]
        axes.semilogx(error, force, "ox"[k], color=OKABE_ITO[2 + k], label=knowledge)
    axes.axhline(1.0, color="0.6", linewidth=0.8)
    axes.axvline(1.0, color="0.6", linewidth=0.8)
    axes.set_ylabel("Share of the learned\ncart's rms force")
