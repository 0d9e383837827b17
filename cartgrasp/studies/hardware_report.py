"""The hardware study in numbers, claims and a figure like Fig. 9: scatter beside the bound, honesty, reversals."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..frames import Array
from ..view.plots import OKABE_ITO, house_style
from .findings import Claim, Findings, Section
from .hardware import HEAVY_EXPERIMENTS, REVERSAL_EXPERIMENTS, STRAIGHT_EXPERIMENTS, WITH_CASTERS, Experiment, Outcome

COLUMNS = (
    *("experiment", "model", "mass kg", "bias kg", "sd kg", "told sd kg", "bound kg", "in 95 % interval"),
    *("CoM x cm", "CoM y cm", "inertia %"),
)
REVERSAL_COLUMNS = ("model", "reversal s", "largest mean error kg", "largest rms error kg", "told sd kg")
REVERSAL_WINDOW = 4.0
"""s that a reversal is looked at: casters need 0.3 m, 7 trails, to swing round."""
MAX_SCATTER_RATIO, MAX_MASS_BIAS, COVERAGE_RANGE, PAPER_MASS_ERROR = 1.15, 0.1, (0.93, 0.97), 0.5
COVERAGE_95_SIGMAS = 1.96
MASS_MARGIN_FRACTION = 0.4
"""Share of the mass that is shown above and below it."""


def inside(outcome: Outcome) -> np.ndarray:
    """Whether the last 95 % interval of each run holds the true mass, (runs,)."""
    return np.asarray(np.abs(outcome.errors[:, 0]) <= COVERAGE_95_SIGMAS * outcome.std[:, -1])


def scatter(outcome: Outcome) -> float:
    """Standard deviation of the last mass over the runs, kg."""
    return float(outcome.errors[:, 0].std(ddof=1))


def rows(outcomes: Sequence[Outcome]) -> list[tuple[str, ...]]:
    """By COLUMNS; CoM and inertia are rms errors."""
    told: list[tuple[str, ...]] = []
    for outcome in outcomes:
        what, bias = outcome.experiment, outcome.errors[:, 0].mean()
        _, com_x, com_y, inertia = 100 * np.sqrt((outcome.errors**2).mean(axis=0))
        sizes = scatter(outcome), outcome.std[:, -1].mean(), outcome.bound
        mass = f"{bias:+.2f}", *(f"{size:.2f}" for size in sizes), f"{inside(outcome).mean():.0%}"
        rest = f"{com_x:.1f}", f"{com_y:.1f}", f"{inertia / what.cart.inertia.about_com:.0f}"
        told.append((what.name, what.casters, f"{what.mass:g}", *mass, *rest))
    return told


def reversal_errors(outcome: Outcome) -> Array:
    """(reversals, 3): of the mass within REVERSAL_WINDOW of each, the largest mean error by size, the largest rms
    error, and what the filter says, kg."""
    error = outcome.mass - outcome.experiment.mass
    told = []
    for begin in outcome.reversals:
        during = (outcome.time >= begin) & (outcome.time < begin + REVERSAL_WINDOW)
        mean = error[:, during].mean(axis=0)
        rms = np.sqrt((error[:, during] ** 2).mean(axis=0))
        told.append([mean[np.abs(mean).argmax()], rms.max(), outcome.std[:, during].mean()])
    return np.array(told).reshape(-1, 3)


def reversal_rows(outcomes: Sequence[Outcome]) -> list[tuple[str, ...]]:
    """By REVERSAL_COLUMNS."""
    told: list[tuple[str, ...]] = []
    for outcome in _of(outcomes, REVERSAL_EXPERIMENTS):
        for begin, (mean, rms, std) in zip(outcome.reversals, reversal_errors(outcome), strict=True):
            told.append((outcome.experiment.casters, f"{begin:.1f}", f"{mean:+.2f}", f"{rms:.2f}", f"{std:.2f}"))
    return told


def claims(outcomes: Sequence[Outcome]) -> list[Claim]:
    """This project's: of straight runs, of reversals with the casters in the model, and of heavy loads."""
    straight = _of(outcomes, STRAIGHT_EXPERIMENTS)
    ratios = [scatter(outcome) / outcome.bound for outcome in straight]
    biases = [float(outcome.errors[:, 0].mean()) for outcome in straight]
    covered = float(np.mean([inside(outcome) for outcome in straight]))
    swinging = [one for one in _of(outcomes, REVERSAL_EXPERIMENTS) if one.experiment.casters == WITH_CASTERS]
    reversed_by = float(np.abs(np.concatenate([reversal_errors(one) for one in swinging])[:, 0]).max())
    heavy = _of(outcomes, HEAVY_EXPERIMENTS)
    com = [float(np.sqrt((outcome.errors[:, 1:3] ** 2).mean(axis=0)).max()) for outcome in heavy]
    low, high = COVERAGE_RANGE
    return [
        Claim(
            "E1 to E4",
            f"scatter of the mass within {MAX_SCATTER_RATIO} times the Cramér-Rao bound",
            ", ".join(f"{ratio:.2f}" for ratio in ratios),
            max(ratios) <= MAX_SCATTER_RATIO,
        ),
        Claim(
            "E1 to E4",
            f"bias of the mass under {MAX_MASS_BIAS} kg",
            ", ".join(f"{bias:+.2f}" for bias in biases),
            max(map(abs, biases)) < MAX_MASS_BIAS,
        ),
        Claim(
            "E1 to E4",
            f"95 % intervals hold the mass in {low:.0%} to {high:.0%}",
            f"{covered:.1%}",
            low <= covered <= high,
        ),
        Claim(
            "E5, casters swing",
            f"mean mass within {PAPER_MASS_ERROR} kg within {REVERSAL_WINDOW:g} s of each reversal",
            f"{reversed_by:.2f} kg",
            reversed_by <= PAPER_MASS_ERROR,
        ),
        Claim("60 and 80 kg", "CoM within 2 cm (rms)", ", ".join(f"{100 * c:.1f} cm" for c in com), max(com) <= 0.02),
    ]


def paper_claims(outcomes: Sequence[Outcome]) -> list[Claim]:
    """The paper's, of its Fig. 9."""
    straight = _of(outcomes, STRAIGHT_EXPERIMENTS)
    errors = [float(np.abs(outcome.errors[:, 0]).mean()) for outcome in straight]
    without = [one for one in _of(outcomes, REVERSAL_EXPERIMENTS) if one.experiment.casters != WITH_CASTERS]
    over = [float(reversal_errors(one)[:, 0].max()) for one in without]
    return [
        Claim(
            "E1 to E4",
            f"mass within {PAPER_MASS_ERROR} kg (mean size of the error)",
            ", ".join(f"{error:.2f}" for error in errors),
            max(errors) <= PAPER_MASS_ERROR,
            promised=False,
        ),
        Claim(
            "E5, casters left out",
            "mass too large after a reversal",
            ", ".join(f"{value:+.2f} kg" for value in over),
            all(value > 0 for value in over),
            promised=False,
        ),
    ]


def _of(outcomes: Sequence[Outcome], experiments: Sequence[Experiment]) -> list[Outcome]:
    return [outcome for outcome in outcomes if outcome.experiment in experiments]


def findings(outcomes: Sequence[Outcome]) -> Findings:
    promised, papers = claims(outcomes), paper_claims(outcomes)
    sections = [
        Section("Mass, and rms errors of the rest", COLUMNS, rows(outcomes), left=2),
        Section("E5: the mass after each reversal", REVERSAL_COLUMNS, reversal_rows(outcomes)),
        Section.of_claims("The paper's claims", papers),
        Section.of_claims("This project's promises", promised),
    ]
    experiments = [as_dict(outcome) for outcome in outcomes]
    return Findings(
        "The hardware experiments",
        sections,
        {"paper": [claim.as_dict() for claim in papers], "experiments": experiments},
        promised,
    )


def as_dict(outcome: Outcome) -> dict[str, object]:
    """For `--json`."""
    return {
        "experiment": outcome.experiment.name,
        "model": outcome.experiment.casters,
        "mass": outcome.experiment.mass,
        "bias": float(outcome.errors[:, 0].mean()),
        "sd": scatter(outcome),
        "told_sd": float(outcome.std[:, -1].mean()),
        "bound": outcome.bound,
        "inside": float(inside(outcome).mean()),
        "reversals": [
            {"time": float(time), "mean_error": float(mean), "rms_error": float(rms)}
            for time, (mean, rms, _) in zip(outcome.reversals, reversal_errors(outcome), strict=True)
        ],
    }


def draw_mass(axes: Axes, outcome: Outcome) -> None:
    """Each run, what 95 % of the filter's own intervals say around their mean, the truth, and the reversals."""
    mass = outcome.experiment.mass
    runs = axes.plot(outcome.time, outcome.mass[:10].T, color=OKABE_ITO[0], linewidth=0.4, alpha=0.6)
    runs[0].set_label("runs")
    mean, std = outcome.mass.mean(axis=0), outcome.std.mean(axis=0)
    low, high = mean - COVERAGE_95_SIGMAS * std, mean + COVERAGE_95_SIGMAS * std
    axes.fill_between(outcome.time, low, high, color=OKABE_ITO[1], alpha=0.2, linewidth=0, label="95 % intervals, mean")
    axes.axhline(mass, color="black", linewidth=0.8, label="truth")
    for i, time in enumerate(outcome.reversals):
        axes.axvline(time, color=OKABE_ITO[2], linewidth=0.6, linestyle=":", label="" if i else "reversals")
    axes.set(
        ylim=(mass * (1 - MASS_MARGIN_FRACTION), mass * (1 + MASS_MARGIN_FRACTION)), xlim=(0.0, float(outcome.time[-1]))
    )
    axes.set_title(", ".join(dict.fromkeys((outcome.experiment.name, f"{mass:g} kg", outcome.experiment.casters))))


def figure(outcomes: Sequence[Outcome]) -> Figure:
    """A page, two experiments a row."""
    with house_style():
        n_rows = (len(outcomes) + 1) // 2
        page = Figure(figsize=(7.2, 1.9 * n_rows), layout="constrained")
        panels = page.subplots(n_rows, 2).ravel()
        for axes, outcome in zip(panels, outcomes, strict=False):
            draw_mass(axes, outcome)
            axes.set(xlabel="Time (s)", ylabel="Mass (kg)")
        for axes in panels[len(outcomes) :]:
            axes.set_axis_off()
        labelled = {
            label: line for axes in panels for line, label in zip(*axes.get_legend_handles_labels(), strict=True)
        }
        page.legend(labelled.values(), labelled.keys(), loc="outside upper center", ncols=len(labelled))
    return page
