"""Table I in numbers and claims; and Figures 4-6 of the paper redone, with the CoM and inertia that it lacks, and
tracking error against gains."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from ..first_guess import PHYSICAL_NAMES
from ..frames import Array
from ..simulation.record import RunRecord
from ..view.figures import save_figure
from ..view.plots import BLACK, OKABE_ITO, YELLOW, house_style
from .findings import Claim
from .scenario import FIRST_GUESS, LEARNING, PAPER
from .table1 import ESTIMATION_MODES, MASS_STEPS, Row, RowResult

SETTLED_ERROR, MIN_ACCELERATION = 0.03, 0.1
CURVED_TRAJECTORY, LOW_NOISE, HIGH_NOISE = 2, 0.005, 0.05
LINES = ("-", "--", ":")
TRUTH_STYLE: dict[str, Any] = {"color": "black", "linewidth": 0.8, "linestyle": (0, (1, 1))}
LOG_SCALE_OFFSET = 1e-3
"""cm or %, added so that a logarithm can show none."""


@dataclass(frozen=True)
class Merit:
    """Figures of one run. Errors in m, or shares; z are errors in own standard deviations; `recovery` is the time
    (s) of acceleration after each mass step until the mass stays within 5 %."""

    mass_error_10: float
    mass_error_30: float
    error_after_5: float
    com_error_30: float
    inertia_error_30: float
    largest_z: float
    identifiable: dict[str, bool]
    recovery: tuple[float, ...]


def merit(record: RunRecord, row: Row) -> Merit:
    """The figures of a run with estimation."""
    time, error = record.time, record.tracking_error
    relative = _share_off(record, "mass")
    last = [(record.parameters[n], _truth(record, n)[-1]) for n in PHYSICAL_NAMES]
    return Merit(
        mass_error_10=float(relative[np.searchsorted(time, 10.0 - 1e-6)]),
        mass_error_30=float(relative[-1]),
        error_after_5=float(error[time >= 5.0].max()),
        com_error_30=float(_com_off(record)[-1]),
        inertia_error_30=float(_share_off(record, "inertia")[-1]),
        largest_z=float(max(abs(one.value[-1] - true) / one.std[-1] for one, true in last)),
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


def comparison(result: RowResult) -> tuple[str, ...]:
    """Largest tracking error from 5 s on: with estimation, with the first guess kept, with the literal filter."""
    records = [result.runs[mode] for mode in ESTIMATION_MODES]
    return tuple(_length(float(record.tracking_error[record.time >= 5.0].max())) for record in records)


def _literal_claim(result: RowResult) -> Claim:
    record = result.runs[PAPER]
    mass, com = record.parameters["mass"].value[-1], record.parameters["com_x"].value[-1]
    right = bool(_share_off(record, "mass")[-1] <= 0.05 and abs(com - _truth(record, "com_x")[-1]) <= 0.02)
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
    assert truth is not None, "a simulated cart's parameters are known"
    return truth


def _share_off(record: RunRecord, name: str) -> Array:
    """Errors of a parameter over time, by the true value."""
    return np.asarray(np.abs(record.parameters[name].value / _truth(record, name) - 1))


def _com_off(record: RunRecord) -> Array:
    """Distance of the estimated CoM from the true one over time, m."""
    x, y = (record.parameters[name].value - _truth(record, name) for name in ("com_x", "com_y"))
    return np.hypot(x, y)


def _below(name: str, what: str, figure: float, limit: float, unit: str, promised: bool = True) -> Claim:
    text = f"{100 * figure:.2f} %" if unit == "%" else _length(figure)
    return Claim(name, what, text, bool(figure <= limit), promised)


def _length(metres: float) -> str:
    return f"{100 * metres:.1f} cm" if metres < 1 else f"{metres:.3g} m"


def save_plots(results: Sequence[RowResult], curve: Sequence[tuple[float, float]], out: Path) -> None:
    """Writes the figures into a folder."""
    save_figure(figure_table1(results), out / "table1.png")
    with house_style():
        save_figure(_tracking(results), out / "tracking_error.png")
        labels = ("Mass (kg)", "CoM x (m)", "CoM y (m)", "Inertia (kg·m²)")
        for name, label in zip(PHYSICAL_NAMES, labels, strict=True):
            save_figure(_parameter(results, name, label), out / f"{name}.png")
        if curve:
            save_figure(_gains(curve), out / "gains.png")


def figure_table1(results: Sequence[RowResult]) -> Figure:
    """A page: tracking as in Fig. 4, mass as in Fig. 5 and 6, and CoM and inertia where the path has curves."""
    calm = {r.row.test for r in results if r.row.noise <= LOW_NOISE and not r.row.mass_steps}
    low_noise = [result for result in results if result.row.test in calm]
    others = [result for result in results if result.row.test not in calm]
    curves = [result for result in results if result.row.trajectory == CURVED_TRAJECTORY]
    with house_style():
        figure = Figure(figsize=(7.2, 6.6), layout="constrained")
        (learning, kept), (mass, rough), (com, inertia) = figure.subplots(3, 2, sharex=True)
        draw_tracking(learning, results, LEARNING)
        draw_tracking(kept, results, FIRST_GUESS)
        kept.sharey(learning)
        _draw_error(mass, low_noise, lambda record: _share_off(record, "mass"))
        mass.axhline(5.0, color="0.5", linewidth=0.8)
        draw_parameter_of_tests(rough, others, "mass", deviations=True)
        _draw_error(com, curves, _com_off)
        draw_parameter_of_tests(inertia, curves, "inertia")
        learning.set(title="Estimating", ylabel="Tracking error (cm)")
        kept.set(title="First guess kept", ylabel="Tracking error (cm)")
        mass.set(title="0.005 m of noise", ylabel="Mass error (%)", ylim=(1e-2, 1e2))
        rough.set(title="More noise (9, 10), load changes (11); ± one sd", ylabel="Mass (kg)", ylim=(8.0, 32.0))
        com.set(title="Tests with curves", ylabel="CoM's distance from truth (cm)", xlabel="Time (s)", ylim=(1e-2, 1e2))
        inertia.set(title="Tests with curves", ylabel="Inertia (kg·m²)", xlabel="Time (s)", ylim=(0.0, 5.0))
        handles = [Line2D([], [], **_style(result), label=str(result.row.test)) for result in results]
        handles.append(Line2D([], [], **TRUTH_STYLE, label="truth"))
        figure.legend(handles=handles, title="Test of Table I", loc="outside upper center", ncols=6)
    return figure


def draw_tracking(axes: Axes, results: Sequence[RowResult], mode: str) -> None:
    """Tracking error in cm, with the 3 cm that the paper reaches."""
    _draw_error(axes, results, lambda record: record.tracking_error, mode)
    axes.axhline(3.0, color="0.5", linewidth=0.8)
    axes.set_ylim(1e-2, 3e2)


def draw_parameter_of_tests(axes: Axes, results: Sequence[RowResult], name: str, deviations: bool = False) -> None:
    """Estimates over time, and what is true."""
    for result in results:
        record, style = result.runs[LEARNING], _style(result)
        series = record.parameters[name]
        axes.plot(record.time, series.value, **style)
        if deviations:
            low, high = series.value - series.std, series.value + series.std
            axes.fill_between(record.time, low, high, color=style["color"], alpha=0.15, linewidth=0)
        axes.plot(record.time, _truth(record, name), **TRUTH_STYLE)


def _draw_error(
    axes: Axes, results: Sequence[RowResult], error: Callable[[RunRecord], Array], mode: str = LEARNING
) -> None:
    """An error in hundredths (cm or %), in decades."""
    for result in results:
        record = result.runs[mode]
        axes.semilogy(record.time, 100 * error(record) + LOG_SCALE_OFFSET, **_style(result))


def _figure(rows: int = 1) -> Figure:
    return Figure(figsize=(7.0, 2.9 * rows), layout="constrained")


def _tracking(results: Sequence[RowResult]) -> Figure:
    figure = _figure(2)
    titles = {LEARNING: "With estimation", FIRST_GUESS: "First guess kept"}
    for axes, (mode, title) in zip(figure.subplots(2, 1, sharex=True), titles.items(), strict=True):
        draw_tracking(axes, results, mode)
        axes.set(ylabel="Tracking error (cm)", title=title)
    axes.set_xlabel("Time (s)")
    names = [str(result.row.test) for result in results]
    figure.legend(axes.get_lines()[: len(names)], names, title="test", loc="outside right upper")
    return figure


def _parameter(results: Sequence[RowResult], name: str, label: str) -> Figure:
    figure = _figure()
    axes = figure.subplots()
    for result in results:
        record, style = result.runs[LEARNING], _style(result)
        series = record.parameters[name]
        axes.plot(record.time, series.value, **style, label=str(result.row.test))
        axes.plot(record.time, _truth(record, name), color=style["color"], linewidth=0.6, alpha=0.6)
    values = [result.runs[LEARNING].parameters[name] for result in results]
    low = min(float(s.value[100:].min()) for s in values)
    high = max(float(s.value[100:].max()) for s in values)
    margin = 0.1 * (high - low) + 1e-3
    axes.set(xlabel="Time (s)", ylabel=label, ylim=(low - margin, high + margin))
    figure.legend(*axes.get_legend_handles_labels(), title="test", loc="outside right upper")
    return figure


def _gains(curve: Sequence[tuple[float, float]]) -> Figure:
    figure = _figure()
    axes = figure.subplots()
    axes.loglog([s for s, _ in curve], [100 * e for _, e in curve], "o-", color=OKABE_ITO[0])
    axes.axhline(20.0, color="0.5", linewidth=0.8)
    axes.set(xlabel="Scale of all gains (1)", ylabel="Largest tracking error (cm)")
    axes.set_title("Test 1 without estimation: 4 kg of error")
    return figure


def _style(result: RowResult) -> dict[str, Any]:
    """A test's colour and dash: without yellow, and without black, which is the truth."""
    colours = [c for c in OKABE_ITO if c not in (YELLOW, BLACK)]
    i = result.row.test - 1
    return {"color": colours[i % len(colours)], "linestyle": LINES[i // len(colours)], "linewidth": 1.0}
