"""Figures 4-6 of the paper redone, with the CoM figure that it lacks, and tracking error against gains."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from ..simulation.record import RunRecord
from ..view.figures import save_figure
from ..view.plots import OKABE_ITO, house_style
from .scenario import FIRST_GUESS, LEARNING
from .table1 import RowResult

LINES = ("-", "--", ":")


def save_plots(results: Sequence[RowResult], curve: Sequence[tuple[float, float]], out: Path) -> None:
    """Writes the figures into a folder."""
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
        for i, result in enumerate(results):
            record = result.runs[mode]
            axes.semilogy(record.time, 100 * record.tracking_error + 1e-3, **_style(i), label=str(result.row.test))
        axes.axhline(3.0, color="0.5", linewidth=0.8)
        axes.set(ylabel="Tracking error (cm)", title=title, ylim=(1e-2, 3e2))
    axes.set_xlabel("Time (s)")
    figure.legend(*axes.get_legend_handles_labels(), title="test", loc="outside right upper")
    return figure


def _parameter(results: Sequence[RowResult], name: str, label: str) -> Figure:
    figure = _figure()
    axes = figure.subplots()
    for i, result in enumerate(results):
        record: RunRecord = result.runs[LEARNING]
        series = record.parameters[name]
        style = _style(i)
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


def _style(i: int) -> dict[str, Any]:
    colours = [c for c in OKABE_ITO if c.upper() not in ("#F0E442",)]
    return {"color": colours[i % len(colours)], "linestyle": LINES[i // len(colours) % len(LINES)]}
