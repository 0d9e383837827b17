"""Figures 4-6 of the paper redone, with the CoM and inertia that it lacks, and tracking error against gains: functions
that draw into the `Axes` they are given, a page of all tests, and a figure for each."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from ..simulation.record import RunRecord
from ..view.figures import save_figure
from ..view.plots import BLACK, OKABE_ITO, YELLOW, house_style
from .scenario import FIRST_GUESS, LEARNING
from .table1 import RowResult

LINES = ("-", "--", ":")
TRUTH_STYLE: dict[str, Any] = {"color": "black", "linewidth": 0.8, "linestyle": (0, (1, 1))}
LOW_NOISE, CURVED_TRAJECTORY = 0.005, 2
LOG_SCALE_OFFSET = 1e-3
"""cm or %, added so that a logarithm can show none."""


def save_plots(results: Sequence[RowResult], curve: Sequence[tuple[float, float]], out: Path) -> None:
    """Writes the figures into a folder."""
    save_figure(figure_table1(results), out / "table1.png")
    with house_style():
        save_figure(_tracking(results), out / "tracking_error.png")
        for name, label in (
            ("mass", "Mass (kg)"),
            ("com_x", "CoM x (m)"),
            ("com_y", "CoM y (m)"),
            ("inertia", "Inertia (kg·m²)"),
        ):
            save_figure(_parameter(results, name, label), out / f"{name}.png")
        if curve:
            save_figure(_gains(curve), out / "gains.png")


def figure_table1(results: Sequence[RowResult]) -> Figure:
    """A page: tracking as in Fig. 4, mass as in Fig. 5 and 6, and CoM and inertia where the path has curves."""
    low_noise = [result for result in results if _is_calm(result)]
    others = [result for result in results if not _is_calm(result)]
    curves = [result for result in results if result.row.trajectory == CURVED_TRAJECTORY]
    with house_style():
        figure = Figure(figsize=(7.2, 6.6), layout="constrained")
        (learning, kept), (mass, rough), (com, inertia) = figure.subplots(3, 2, sharex=True)
        draw_tracking(learning, results, LEARNING)
        draw_tracking(kept, results, FIRST_GUESS)
        kept.sharey(learning)
        draw_mass_error(mass, low_noise)
        draw_parameter_of_tests(rough, others, "mass", deviations=True)
        draw_com_error(com, curves)
        draw_parameter_of_tests(inertia, curves, "inertia")
        learning.set(title="Estimating", ylabel="Tracking error (cm)")
        kept.set(title="First guess kept", ylabel="Tracking error (cm)")
        mass.set(title="0.005 m of noise", ylabel="Mass error (%)", ylim=(1e-2, 1e2))
        rough.set(
            title="More noise (9, 10), load changes (11); ± one sd",
            ylabel="Mass (kg)",
            ylim=(8.0, 32.0),
        )
        com.set(title="Tests with curves", ylabel="CoM's distance from truth (cm)", xlabel="Time (s)", ylim=(1e-2, 1e2))
        inertia.set(title="Tests with curves", ylabel="Inertia (kg·m²)", xlabel="Time (s)", ylim=(0.0, 5.0))
        handles = [Line2D([], [], **_style(result), label=str(result.row.test)) for result in results]
        handles.append(Line2D([], [], **TRUTH_STYLE, label="truth"))
        figure.legend(handles=handles, title="Test of Table I", loc="outside upper center", ncols=6)
    return figure


def draw_tracking(axes: Axes, results: Sequence[RowResult], mode: str) -> None:
    """Tracking error in cm, with the 3 cm that the paper reaches."""
    for result in results:
        record = result.runs[mode]
        axes.semilogy(record.time, 100 * record.tracking_error + LOG_SCALE_OFFSET, **_style(result))
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
        if series.truth is not None:
            axes.plot(record.time, series.truth, **TRUTH_STYLE)


def draw_mass_error(axes: Axes, results: Sequence[RowResult]) -> None:
    """Draws the relative error of the mass in %, with the 5 % that count as converged."""
    for result in results:
        record = result.runs[LEARNING]
        mass = record.parameters["mass"]
        if mass.truth is not None:
            error = np.abs(mass.value / mass.truth - 1)
            axes.semilogy(record.time, 100 * error + LOG_SCALE_OFFSET, **_style(result))
    axes.axhline(5.0, color="0.5", linewidth=0.8)


def draw_com_error(axes: Axes, results: Sequence[RowResult]) -> None:
    """Distance between the estimated and the true centre of mass in cm."""
    for result in results:
        record = result.runs[LEARNING]
        x, y = record.parameters["com_x"], record.parameters["com_y"]
        if x.truth is not None and y.truth is not None:
            distance = np.hypot(x.value - x.truth, y.value - y.truth)
            axes.semilogy(record.time, 100 * distance + LOG_SCALE_OFFSET, **_style(result))


def _figure(rows: int = 1) -> Figure:
    return Figure(figsize=(7.0, 2.9 * rows), layout="constrained")


def _tracking(results: Sequence[RowResult]) -> Figure:
    figure = _figure(2)
    for axes, mode, title in zip(
        figure.subplots(2, 1, sharex=True),
        (LEARNING, FIRST_GUESS),
        ("With estimation", "First guess kept"),
        strict=True,
    ):
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
        record: RunRecord = result.runs[LEARNING]
        series = record.parameters[name]
        style = _style(result)
        axes.plot(record.time, series.value, **style, label=str(result.row.test))
        if series.truth is not None:
            axes.plot(record.time, series.truth, color=style["color"], linewidth=0.6, alpha=0.6)
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


def _is_calm(result: RowResult) -> bool:
    return result.row.noise <= LOW_NOISE and not result.row.mass_steps


def _style(result: RowResult) -> dict[str, Any]:
    """A test's colour and dash: without yellow, and without black, which is the truth."""
    colours = [c for c in OKABE_ITO if c not in (YELLOW, BLACK)]
    i = result.row.test - 1
    return {"color": colours[i % len(colours)], "linestyle": LINES[i // len(colours)], "linewidth": 1.0}
