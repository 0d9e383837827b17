"""The page of Table I: what is drawn is what was run, units on every axis, and tests that can be told apart."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from cartgrasp.studies.scenario import FIRST_GUESS, LEARNING
from cartgrasp.studies.table1 import ROWS, RowResult, scenario
from cartgrasp.studies.table1_report import figure_table1, save_plots


@pytest.fixture(scope="module")
def results():
    def runs(row):
        return {mode: replace(scenario(row, mode), duration=1.2).run() for mode in (LEARNING, FIRST_GUESS)}

    return [RowResult(row, runs(row)) for row in ROWS]


def test_lines_are_the_runs(results):
    figure = figure_table1(results)
    learning, kept, mass, rough, com, inertia = figure.axes
    for axes, mode in ((learning, LEARNING), (kept, FIRST_GUESS)):
        for line, result in zip(axes.get_lines(), results, strict=False):
            error = np.linalg.norm(result.runs[mode].pose[:, :2] - result.runs[mode].reference_pose[:, :2], axis=1)
            assert np.asarray(line.get_ydata()) == pytest.approx(100 * error, abs=2e-3)
    eighth = results[7].runs[LEARNING].parameters
    error = 100 * np.abs(eighth["mass"].value / 20.0 - 1)
    assert any(np.asarray(line.get_ydata()) == pytest.approx(error, abs=2e-3) for line in mass.get_lines())
    last = results[10].runs[LEARNING].parameters["mass"]
    assert any(np.array_equal(line.get_ydata(), last.value) for line in rough.get_lines())
    assert any(np.array_equal(line.get_ydata(), eighth["inertia"].value) for line in inertia.get_lines())
    distance = 100 * np.hypot(eighth["com_x"].value - 0.3, eighth["com_y"].value - 0.15)
    assert any(np.asarray(line.get_ydata()) == pytest.approx(distance, abs=2e-3) for line in com.get_lines())
    assert (len(mass.get_lines()), len(rough.get_lines())) == (9, 6)  # with the limit; each with its truth
    assert (len(com.get_lines()), len(inertia.get_lines())) == (8, 16)  # of a straight line nothing is learned


def test_axes_have_units_and_tests_differ(results):
    figure = figure_table1(results)
    assert all("(" in axes.get_ylabel() for axes in figure.axes)
    assert all(axes.get_xlabel() == "Time (s)" for axes in figure.axes[-2:])
    (legend,) = figure.legends
    assert [text.get_text() for text in legend.get_texts()] == [*map(str, range(1, 12)), "truth"]
    looks = {(line.get_color(), line.get_linestyle()) for line in legend.get_lines()}
    assert len(looks) == 12


def test_some_rows_alone_are_drawn(results, tmp_path):
    save_plots(results[3:4], [], tmp_path)
    assert (tmp_path / "table1.png").stat().st_size > 1000
