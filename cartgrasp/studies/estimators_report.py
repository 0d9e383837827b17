"""The study of estimators in numbers, what it claims, and when which of them is better."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from ..first_guess import PHYSICAL_NAMES
from ..frames import Array
from ..inertia import physical_from_phi
from .estimators import FILTER, IDENTIFY, PATHS, REGRESSOR, SENSOR_SETS, WAYS, Trial, truth
from .findings import Claim, Findings, Section

COLUMNS = ("path, sensors", "estimator", "mass kg", "bias kg", "CoM x cm", "CoM y cm", "inertia kg·m²", "z")
MOTION_COLUMNS = ("path, sensors", "estimator", "u mm/s", "r mrad/s", "µs a row")
BETTER_COLUMNS = ("path", "sensors", *PHYSICAL_NAMES, "u", "r", "parameters by", "motion by")
CLEARLY_BETTER_RATIO = 1.15
"""The factor by which one must be better to be called so."""


@dataclass(frozen=True, eq=False)
class Score:
    """Over the seeds of a case: rms errors and means (4,) of mass, CoM and inertia, the mean's
    standard error, rms of z over all, the rms errors (2,) of speed and yaw rate on the way, and the median time of a
    row, s."""

    errors: Array
    bias: Array
    spread: Array
    z: float
    motion: Array
    step_time: float


def score(trials: Sequence[Trial], way: str) -> Score:
    """The score of one estimator in trials of one case."""
    true = physical_from_phi(truth().inertia.phi)
    found = [[trial.answers[way].parameters[name] for name in PHYSICAL_NAMES] for trial in trials]
    errors = np.array([[p.value for p in row] for row in found]) - true
    deviations = np.array([[p.std for p in row] for row in found])
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):  # the paper's filter may be sure of anything
        z = float(np.sqrt(((errors / deviations) ** 2).mean()))
    return Score(
        errors=np.sqrt((errors**2).mean(axis=0)),
        bias=errors.mean(axis=0),
        spread=errors.std(axis=0) / max(len(trials) - 1, 1) ** 0.5,
        z=z,
        motion=np.sqrt(np.mean([np.square(trial.answers[way].motion_errors) for trial in trials], axis=0)),
        step_time=float(np.median([trial.answers[way].step_time for trial in trials])),
    )


def scores(trials: Sequence[Trial]) -> dict[tuple[str, str, str], Score]:
    """By path, sensors and way."""
    cases: dict[tuple[str, str], list[Trial]] = {(path, sensors): [] for path, sensors in product(PATHS, SENSOR_SETS)}
    for trial in trials:
        cases[trial.job.path, trial.job.sensors].append(trial)
    return {(*case, way): score(ours, way) for case, ours in cases.items() for way in WAYS}


def rows(trials: Sequence[Trial]) -> list[tuple[str, ...]]:
    """The rows of a table with COLUMNS."""
    told: list[tuple[str, ...]] = []
    for (path, sensors, way), found in scores(trials).items():
        mass, com_x, com_y, inertia = found.errors
        sizes = f"{mass:.3g}", f"{found.bias[0]:+.2g}", f"{100 * com_x:.2g}", f"{100 * com_y:.2g}", f"{inertia:.2g}"
        told.append((f"{path}, {sensors}", way, *sizes, f"{found.z:.2g}"))
    return told


def motion_rows(trials: Sequence[Trial]) -> list[tuple[str, ...]]:
    """The rows of a table with MOTION_COLUMNS."""
    told: list[tuple[str, ...]] = []
    for (path, sensors, way), found in scores(trials).items():
        motion = ("" if np.isnan(error) else f"{1e3 * error:.3g}" for error in found.motion)
        told.append((f"{path}, {sensors}", way, *motion, f"{1e6 * found.step_time:.0f}"))
    return told


def better_rows(trials: Sequence[Trial]) -> list[tuple[str, ...]]:
    """Ratios of rms errors by case, and which of the two is better at parameters and at motion, in geometric means."""
    told: list[tuple[str, ...]] = []
    found = scores(trials)
    for path, sensors in product(PATHS, SENSOR_SETS):
        filters, regressors = (found[path, sensors, way] for way in (FILTER, REGRESSOR))
        ratios = filters.errors / regressors.errors, filters.motion / regressors.motion
        figures = (f"{value:.2f}" for value in np.concatenate(ratios))
        told.append((path, sensors, *figures, *(better(ratio) for ratio in ratios)))
    return told


def better(ratio: Array) -> str:
    """Which of the two is better, by the geometric mean of ratios of the filter's errors to the regressor's."""
    mean = float(np.exp(np.log(ratio).mean()))
    return REGRESSOR if mean > CLEARLY_BETTER_RATIO else FILTER if mean < 1 / CLEARLY_BETTER_RATIO else "as good"


def claims(trials: Sequence[Trial]) -> list[Claim]:
    found = scores(trials)
    usual = [found[path, "usual", REGRESSOR] for path in ("straight", "curves")]
    mass = float(physical_from_phi(truth().inertia.phi)[0])
    within = all(abs(s.bias[0]) <= max(0.005 * mass, 2 * s.spread[0]) for s in usual)
    cases = list(product(PATHS, SENSOR_SETS))
    z = {way: float(np.sqrt(np.mean([found[*case, way].z ** 2 for case in cases]))) for way in WAYS}
    worst = max(float((found[*case, FILTER].motion / found[*case, REGRESSOR].motion).max()) for case in cases)
    times = {way: np.median([trial.answers[way].step_time for trial in trials]) for way in WAYS}
    return [
        Claim(
            REGRESSOR,
            "usual sensors, not gentle: mass without bias, within 0.5 % or two standard errors",
            ", ".join(f"{s.bias[0]:+.2f} kg" for s in usual),
            within,
        ),
        *(
            Claim(way, "z of 0.5 to 1.5 over all", f"{z[way]:.2f}", 0.5 <= z[way] <= 1.5, promised=way != IDENTIFY)
            for way in (REGRESSOR, FILTER, IDENTIFY)
        ),
        Claim(
            REGRESSOR,
            "takes less time than the filter",
            f"{1e6 * times[REGRESSOR]:.0f} against {1e6 * times[FILTER]:.0f} µs a row",
            bool(times[REGRESSOR] < times[FILTER]),
            promised=False,
        ),
        Claim(
            FILTER,
            "better than the regressor at the motion of every case",
            f"rms errors {worst:.2f} times its or less",
            worst < 1.0,
        ),
    ]


def findings(trials: Sequence[Trial]) -> Findings:
    promised = claims(trials)
    better = "When which is better: errors of the filter over those of the regressor"
    errors = "Rms errors at the end (mean error of the mass beside), and rms errors in standard deviations (z)"
    motion = "Rms errors of the motion on the way, and the time of a row"
    sections = [
        Section(better, BETTER_COLUMNS, better_rows(trials), left=2),
        Section.of_claims("Claims", promised),
        Section(errors, COLUMNS, rows(trials), left=2),
        Section(motion, MOTION_COLUMNS, motion_rows(trials), left=2),
    ]
    return Findings("Estimators", sections, {"trials": [as_dict(trial) for trial in trials]}, promised)


def as_dict(trial: Trial) -> dict[str, object]:
    """The trial as `--json` has it."""
    answers = {
        way: {
            "health": answer.health,
            "motion_rms_error": list(answer.motion_errors),
            "step_time_s": answer.step_time,
            "parameters": {n: {"value": p.value, "std": p.std} for n, p in answer.parameters.items()},
        }
        for way, answer in trial.answers.items()
    }
    return {"path": trial.job.path, "sensors": trial.job.sensors, "seed": trial.job.seed, "answers": answers}
