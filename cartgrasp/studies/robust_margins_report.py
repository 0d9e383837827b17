"""The study of robust margins in numbers, claims and a figure: margins that shrink as the load is learned."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..frames import Array
from ..view.plots import OKABE_ITO, house_style
from .findings import Claim, Findings, Section
from .robust_margins import CONFIDENCE, LAP_TIMES, LIMIT_TOLERANCE, WAYS, Run

COLUMNS = ("lap", "sd of CoM x cm", "largest margin N", *(f"broken, {way} %" for way in WAYS[:2]), "effort", "paid")
STYLES = ("--", "-", ":")


@dataclass(frozen=True, eq=False)
class Lap:
    """From standstill to standstill, over all runs: deviation of the CoM (m) at the end, the largest margin (N), the
    share of hard ticks at which each way breaks a true limit, and efforts (N²), mean over the whole lap."""

    com_x_std: float
    reserve: float
    broken: Array
    efforts: Array

    @property
    def paid(self) -> float:
        """For margins, as a share of the effort with the cart known."""
        return float(self.efforts[1] / self.efforts[2] - 1.0)


def laps(runs: Sequence[Run]) -> list[Lap]:
    """What each lap was like."""
    return [_lap(runs, begin, end) for begin, end in pairwise(LAP_TIMES)]


def rows(runs: Sequence[Run]) -> list[tuple[str, ...]]:
    """By lap; effort is that of the plans with margins (N²), `paid` what is more than with the cart known."""
    return [
        (
            f"{i} {'straight' if i <= 2 else 'curved'}",
            f"{100 * lap.com_x_std:.2f}",
            f"{lap.reserve:.1f}",
            *(f"{100 * share:.1f}" for share in lap.broken[:2]),
            f"{lap.efforts[1]:.0f}",
            f"{100 * lap.paid:+.0f} %",
        )
        for i, lap in enumerate(laps(runs), start=1)
    ]


def claims(runs: Sequence[Run]) -> list[Claim]:
    found = laps(runs)
    hard = np.concatenate([run.is_hard for run in runs])
    broken = np.concatenate([run.room < -LIMIT_TOLERANCE for run in runs])[hard]
    share, plain = float(broken[:, 1].mean()), float(broken[:, 0].mean())
    shrunk = found[-1].reserve / found[0].reserve
    unproven = sum(status not in ("optimal", "relaxed") for run in runs for status in run.statuses[:, 1])
    return [
        Claim(
            WAYS[1],
            f"break a true limit at {100 * (1 - CONFIDENCE):g} % of hard ticks at most",
            f"{100 * share:.2f} %",
            bool(share <= 1 - CONFIDENCE),
        ),
        Claim(WAYS[0], "break one at 20 % or more", f"{100 * plain:.0f} %", bool(plain >= 0.2)),
        Claim("learning", "margins shrink to a quarter or less", f"{shrunk:.2f}", bool(shrunk <= 0.25)),
        Claim(
            "effort",
            "what is paid for margins falls from lap 1 to lap 4 to a fifth or less",
            f"{100 * found[0].paid:.0f} to {100 * found[-1].paid:.0f} %",
            bool(found[-1].paid <= 0.2 * found[0].paid),
        ),
        Claim("proof", "every plan with margins is proven", f"{unproven} are not", unproven == 0),
    ]


def findings(runs: Sequence[Run]) -> Findings:
    promised = claims(runs)
    title = "Margins while the load is learned (at hard ticks; effort in N²)"
    sections = [Section(title, COLUMNS, rows(runs)), Section.of_claims("Claims", promised)]
    return Findings("Robust margins", sections, {"runs": [as_dict(one) for one in runs]}, promised)


def as_dict(run: Run) -> dict[str, object]:
    """For `--json`."""
    return {
        "seed": run.seed,
        "laps": [
            {
                "com_x_std": lap.com_x_std,
                "margin": lap.reserve,
                "broken": dict(zip(WAYS, lap.broken.tolist(), strict=True)),
                "effort": dict(zip(WAYS, lap.efforts.tolist(), strict=True)),
            }
            for lap in laps([run])
        ],
    }


def _lap(runs: Sequence[Run], begin: float, end: float) -> Lap:
    chosen = [(run, (run.time >= begin - 1e-9) & (run.time < end - 1e-9)) for run in runs]
    broken = np.concatenate([run.room[now & run.is_hard] < -LIMIT_TOLERANCE for run, now in chosen])
    return Lap(
        com_x_std=float(np.sqrt(np.mean([run.com_x_std[now][-1] ** 2 for run, now in chosen]))),
        reserve=float(np.mean([run.reserve[now & run.is_hard].max(initial=0.0) for run, now in chosen])),
        broken=broken.mean(axis=0) if len(broken) else np.zeros(len(WAYS)),
        efforts=np.mean(np.concatenate([run.efforts[now] for run, now in chosen]), axis=0),
    )


def draw_reserve(axes: Axes, runs: Sequence[Run]) -> None:
    """The largest margin of the plans against time: each run, and the mean."""
    for run in runs:
        axes.plot(run.time, run.reserve, color=OKABE_ITO[1], linewidth=0.5, alpha=0.4)
    mean = np.mean([run.reserve for run in runs], axis=0)
    axes.plot(runs[0].time, mean, color=OKABE_ITO[1], label=WAYS[1])
    axes.set(xlabel="Time (s)", ylabel="Largest margin (N)")


def draw_room(axes: Axes, runs: Sequence[Run]) -> None:
    """How far the true carts are inside their limits: of each way the mean, and the range over runs."""
    axes.axhline(0.0, color="0.3", linewidth=0.8)
    time, room = runs[0].time, np.array([run.room for run in runs])
    for i, way in enumerate(WAYS[:2]):
        low, high = room[..., i].min(axis=0), room[..., i].max(axis=0)
        axes.fill_between(time, low, high, color=OKABE_ITO[i], alpha=0.25, linewidth=0.0)
        axes.plot(time, room[..., i].mean(axis=0), STYLES[i], color=OKABE_ITO[i], label=way)
    axes.set(xlabel="Time (s)", ylabel="True load above its limit (N)")


def draw_effort(axes: Axes, runs: Sequence[Run]) -> None:
    """Effort of each way against time, mean over runs."""
    efforts = np.mean([run.efforts for run in runs], axis=0)
    for i, way in enumerate(WAYS):
        axes.plot(runs[0].time, efforts[:, i], STYLES[i], color=OKABE_ITO[i], label=way)
    axes.set(xlabel="Time (s)", ylabel="Effort (N²)")


def figure(runs: Sequence[Run]) -> Figure:
    """A page: margins, what is left to the true limits, effort; grey where the path curves."""
    with house_style():
        page = Figure(figsize=(7.2, 5.6), layout="constrained")
        axes = page.subplots(3, 1, sharex=True)
        for panel, draw in zip(axes, (draw_reserve, draw_room, draw_effort), strict=True):
            panel.axvspan(LAP_TIMES[2], LAP_TIMES[-1], color="0.94", zorder=0)
            draw(panel, runs)
            panel.label_outer()
        for start, stop, path in ((0.0, LAP_TIMES[2], "straight"), (LAP_TIMES[2], LAP_TIMES[-1], "curved")):
            axes[0].text((start + stop) / 2, 0.97, path, transform=axes[0].get_xaxis_transform(), ha="center", va="top")
        page.legend(*axes[2].get_legend_handles_labels(), loc="outside upper center", ncols=3)
    return page
