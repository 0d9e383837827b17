"""What is read off a run of Table I, and the claims that are checked with it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..frames import Array
from ..simulation.record import RunRecord
from .claims import Claim
from .scenario import FIRST_GUESS, LEARNING, PAPER
from .table1 import MASS_STEPS, TRUE_MASS, Row, RowResult

SETTLED_ERROR = 0.03
CURVED_TRAJECTORY = 2
HIGH_NOISE = 0.05
LOW_NOISE = 0.005
MIN_ACCELERATION = 0.1


@dataclass(frozen=True)
class Merit:
    """Figures of one run. Errors in m, or shares; z are errors in own standard deviations; `recovery` is the time
    (s) of acceleration after each mass step until the mass stays within 5 %."""

    mass_error_10: float
    mass_error_30: float
    settled: float
    error_after_5: float
    com_error_30: float
    inertia_error_30: float
    largest_z: float
    identifiable: dict[str, bool]
    recovery: tuple[float, ...]


def merit(record: RunRecord, row: Row) -> Merit:
    """The figures of a run with estimation."""
    time, error = record.time, record.tracking_error
    late = np.flatnonzero(error > SETTLED_ERROR)
    mass, com_x, com_y = (record.parameters[n] for n in ("mass", "com_x", "com_y"))
    truth = {n: _truth(record, n) for n in ("mass", "com_x", "com_y", "inertia")}
    relative = np.abs(mass.value / truth["mass"] - 1)
    inertia = np.abs(record.parameters["inertia"].value / truth["inertia"] - 1)
    com = np.hypot(com_x.value - truth["com_x"], com_y.value - truth["com_y"])
    z = [abs(record.parameters[n].value[-1] - truth[n][-1]) / record.parameters[n].std[-1] for n in truth]
    return Merit(
        mass_error_10=float(relative[np.searchsorted(time, 10.0 - 1e-6)]),
        mass_error_30=float(relative[-1]),
        settled=float(time[late[-1]]) if len(late) else 0.0,
        error_after_5=float(error[time >= 5.0].max()),
        com_error_30=float(com[-1]),
        inertia_error_30=float(inertia[-1]),
        largest_z=float(max(z)),
        identifiable=dict(record.identifiable),
        recovery=tuple(_recovery(record, relative, i) for i in range(len(MASS_STEPS))) if row.mass_steps else (),
    )


def row_claims(result: RowResult) -> list[Claim]:
    """What this project promises of a row (the paper's own words are in `paper_claims`)."""
    row, m = result.row, merit(result.runs[LEARNING], result.row)
    name = f"test {row.test}"
    claims = []
    if row.noise <= HIGH_NOISE:
        if not row.mass_steps:
            claims.append(_below(name, "mass within 5 % at 10 s", m.mass_error_10, 0.05, "%"))
        claims.append(_below(name, "mass within 1 % at 30 s", m.mass_error_30, 0.01, "%"))
        claims.append(_below(name, "tracking error under 3 cm from 5 s on", m.error_after_5, SETTLED_ERROR, "cm"))
    for i, seconds in enumerate(m.recovery):
        what = f"mass within 5 % after 5 s of acceleration from step {i + 1}"
        claims.append(Claim(name, what, f"{seconds:.1f} s", seconds <= 5.0))
    if row.trajectory == CURVED_TRAJECTORY and row.noise <= LOW_NOISE:
        claims.append(_below(name, "CoM within 1 cm at 30 s", m.com_error_30, 0.01, "cm"))
        claims.append(_below(name, "inertia within 5 % at 30 s", m.inertia_error_30, 0.05, "%"))
    if row.noise >= HIGH_NOISE:
        what = "mass, CoM, inertia within 3 of their own sd at 30 s"
        claims.append(Claim(name, what, f"{m.largest_z:.1f} sd", m.largest_z <= 3.0))
    if row.trajectory != CURVED_TRAJECTORY:
        unknown = not m.identifiable["com_x"] and not m.identifiable["inertia"]
        figure = ", ".join(f"{n}: {'yes' if m.identifiable[n] else 'no'}" for n in ("com_x", "inertia"))
        claims.append(Claim(name, "com_x and inertia called not identifiable", figure, unknown))
    return claims


def paper_claims(results: list[RowResult], curve: list[tuple[float, float]]) -> list[Claim]:
    """The paper's claims on its simulations, with our figures."""
    quiet = [r for r in results if r.row.noise <= HIGH_NOISE]
    merits = {r.row.test: merit(r.runs[LEARNING], r.row) for r in results}
    claims = []
    if curve:
        reached = [scale for scale, error in curve if error > 0.2]
        figure = "; ".join(f"gains x {scale:g}: {100 * error:.0f} cm" for scale, error in curve)
        claims.append(
            Claim("paper", "without estimation 4 kg give over 20 cm of error", figure, bool(reached), promised=False)
        )
    if quiet:
        worst = max(merits[r.row.test].error_after_5 for r in quiet)
        claims.append(_below("paper", "with it, under 3 cm within 5 s", worst, SETTLED_ERROR, "cm", promised=False))
    steady = [r for r in results if not r.row.mass_steps]
    if steady:
        worst = max(merits[r.row.test].mass_error_10 for r in steady)
        claims.append(_below("paper", "mass right (5 %) within 10 s on every test", worst, 0.05, "%", promised=False))
    curved = [r for r in results if r.row.trajectory == CURVED_TRAJECTORY and r.row.noise <= LOW_NOISE]
    if curved:
        worst = max(merits[r.row.test].com_error_30 for r in curved)
        ours = f"converged: {100 * worst:.1f} cm at most"
        claims.append(
            Claim("paper", "CoM error falls but has not converged at 30 s", ours, worst > 0.02, promised=False)
        )
    for r in results:
        claims.append(_literal_claim(r))
    return claims


def comparison(result: RowResult) -> tuple[str, str, str]:
    """Largest tracking error from 5 s on: with estimation, with the first guess kept, with the literal filter."""
    cells = []
    for mode in (LEARNING, FIRST_GUESS, PAPER):
        record = result.runs[mode]
        cells.append(_length(float(record.tracking_error[record.time >= 5.0].max())))
    return cells[0], cells[1], cells[2]


def _literal_claim(result: RowResult) -> Claim:
    record = result.runs[PAPER]
    mass, com = record.parameters["mass"].value[-1], record.parameters["com_x"].value[-1]
    right = abs(mass / _truth(record, "mass")[-1] - 1) <= 0.05
    right = bool(right and abs(com - _truth(record, "com_x")[-1]) <= 0.02)
    figure = f"mass {mass:.3g} kg, com_x {com:.3g} m"
    name = f"test {result.row.test}"
    return Claim(name, "the literal filter finds mass (5 %) and com_x (2 cm)", figure, right, promised=False)


def _recovery(record: RunRecord, relative: Array, step: int) -> float:
    begin = MASS_STEPS[step][0]
    end = MASS_STEPS[step + 1][0] if step + 1 < len(MASS_STEPS) else record.time[-1] + 1
    window = (record.time >= begin) & (record.time < end)
    speed = record.reference_velocity[:, 0]
    step_time = float(np.median(np.diff(record.time)))
    accelerating = np.abs(np.gradient(speed, record.time)) > MIN_ACCELERATION
    wrong = np.flatnonzero(window & (relative > 0.05))
    if not len(wrong):
        return 0.0
    until = wrong[-1] + 1
    if until >= len(window) or not window[until]:
        return float("inf")
    return float(step_time * np.count_nonzero(accelerating[window & (np.arange(len(window)) < until)]))


def _truth(record: RunRecord, name: str) -> Array:
    truth = record.parameters[name].truth
    return np.full(len(record.time), TRUE_MASS) if truth is None else truth


def _below(name: str, what: str, figure: float, limit: float, unit: str, promised: bool = True) -> Claim:
    text = f"{100 * figure:.2f} %" if unit == "%" else _length(figure)
    return Claim(name, what, text, bool(figure <= limit), promised)


def _length(metres: float) -> str:
    return f"{100 * metres:.1f} cm" if metres < 1 else f"{metres:.3g} m"
