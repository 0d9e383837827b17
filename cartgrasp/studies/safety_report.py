"""The study of carts driven hard in tables, claims and a figure."""

from __future__ import annotations

from collections.abc import Sequence
from math import isfinite
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from ..view.plots import OKABE_ITO, house_style
from .findings import Claim, Findings, Section
from .robust_margins import CONFIDENCE, LIMIT_TOLERANCE
from .safety import BLIND, CONFIDENT, ESTIMATED, MIN_WHEEL_LOAD, TRUTH_KNOWN, WAYS, Run

TITLE = (
    f"Drawn carts that break a true limit ({MIN_WHEEL_LOAD:g} N on each wheel, or skid) "
    f"by more than {LIMIT_TOLERANCE:g} N "
    "in any tick; effort and arrival by those of the cart known are medians"
)
COLUMNS = ("way", "carts", "broken", "fell", "by at most N", "wheel off", "effort", "of known", "arrived", "later s")


def findings(runs: Sequence[Run]) -> Findings:
    promised = claims(runs)
    table = Section(TITLE, COLUMNS, [_row(runs, way) for way in WAYS])
    sections = [table, Section.of_claims("Claims", promised)]
    return Findings(
        "Carts that are not known yet, driven hard", sections, {"runs": [as_dict(one) for one in runs]}, promised
    )


def claims(runs: Sequence[Run]) -> list[Claim]:
    broken = {way: [run.violates for run in _of(runs, way)] for way in WAYS}
    told = {way: f"{sum(each)} of {len(each)}" for way, each in broken.items()}
    asked = f"{100 * (1 - CONFIDENCE):g} %"
    late, effort = _later(runs, CONFIDENT), _effort(runs, CONFIDENT)
    within = sum(broken[CONFIDENT]) <= (1 - CONFIDENCE) * len(broken[CONFIDENT])
    more = sum(broken[ESTIMATED]) > sum(broken[CONFIDENT])
    return [
        Claim(CONFIDENT, f"at most {asked} of carts break a true limit", told[CONFIDENT], within),
        Claim(BLIND, "20 % or more of carts break one", told[BLIND], sum(broken[BLIND]) >= 0.2 * len(broken[BLIND])),
        Claim(ESTIMATED, "without margins more carts break one", told[ESTIMATED], more),
        Claim(CONFIDENT, "effort at most twice that of the cart known", f"{effort:.2f} times", effort <= 2.0),
        Claim(CONFIDENT, "arrives, in the median, within 1 s of the cart known", f"{late:.2f} s later", late <= 1.0),
    ]


def as_dict(run: Run) -> dict[str, Any]:
    """For `--json`."""
    figures = {"seed": run.seed, "way": run.way, "room": float(run.room.min()), "least_load": float(run.loads.min())}
    return {**figures, "effort": run.effort, "arrived": run.arrived, "fell": run.fell, "violates": run.violates}


def figure(runs: Sequence[Run]) -> Figure:
    """The least room of each cart, from the worst on, and mean efforts against those of the cart known, by way."""
    with house_style():
        page = Figure(figsize=(7.2, 3.0), layout="constrained")
        worst, paid = page.subplots(1, 2)
        known = {run.seed: run.effort for run in _of(runs, TRUTH_KNOWN)}
        for k, way in enumerate(WAYS):
            ours = _of(runs, way)
            worst.plot(sorted(float(run.room.min()) for run in ours), color=OKABE_ITO[k], label=way)
            if way != TRUTH_KNOWN:
                paid.loglog([known[run.seed] for run in ours], [run.effort for run in ours], ".", color=OKABE_ITO[k])
        ends = np.array([min(known.values()), max(known.values())])
        paid.plot(ends, ends, color="0.6", linewidth=0.8)
        worst.axhline(0.0, color="0.6", linewidth=0.8)
        worst.set(xlabel="Carts, from the worst on", ylabel="Least room to a true limit (N)", ylim=(-60.0, 60.0))
        paid.set(xlabel="Effort with the cart known (N²)", ylabel="Effort (N²)")
        page.legend(*worst.get_legend_handles_labels(), loc="outside upper center", ncols=3)
    return page


def _of(runs: Sequence[Run], way: str) -> list[Run]:
    return [run for run in runs if run.way == way]


def _row(runs: Sequence[Run], way: str) -> tuple[str, ...]:
    ours = _of(runs, way)
    efforts = [run.effort for run in ours]
    return (
        way,
        str(len(ours)),
        str(sum(run.violates for run in ours)),
        str(sum(run.fell for run in ours)),
        f"{max(0.0, *(-float(run.room.min()) for run in ours)):.1f}",
        str(sum(bool(run.loads.min() <= 0.0) for run in ours)),
        f"{np.mean(efforts):.0f}",
        f"{_effort(runs, way):.2f}",
        str(sum(isfinite(run.arrived) for run in ours)),
        f"{_later(runs, way):+.2f}",
    )


def _effort(runs: Sequence[Run], way: str) -> float:
    """By that of the cart known, the median over carts that did not fall."""
    pairs = zip(_of(runs, way), _of(runs, TRUTH_KNOWN), strict=True)
    return float(np.median([run.effort / known.effort for run, known in pairs if not run.fell]))


def _later(runs: Sequence[Run], way: str) -> float:
    """s after the cart known, the median over carts that arrive both times."""
    pairs = zip(_of(runs, way), _of(runs, TRUTH_KNOWN), strict=True)
    late = [run.arrived - known.arrived for run, known in pairs if isfinite(run.arrived) and isfinite(known.arrived)]
    return float(np.median(late)) if late else np.nan
