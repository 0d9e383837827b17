"""Figures of arms: what they draw, with units, and what they refuse."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib.figure import Figure

from cartgrasp.errors import UsageError
from cartgrasp.view import arm_plots
from cartgrasp.view.figures import save_figure

SQUARE = np.array([[0.0, -5.0], [20.0, -5.0], [20.0, 5.0], [0.0, 5.0]])


def test_a_shadow_is_its_polygon_with_units():
    axes = Figure().subplots()
    area, edge = arm_plots.draw_wrench_shadow(axes, SQUARE, ("fx", "tz"), label="left")
    for polygon in (area, edge):
        np.testing.assert_array_equal(polygon.get_xy()[:4], SQUARE)
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("fx (N)", "tz (N·m)")
    assert [handle.get_label() for handle in axes.get_legend_handles_labels()[0]] == ["left"]


def test_the_needed_push_stands_at_its_force():
    (line,) = arm_plots.draw_needed_push(Figure().subplots(), 23.7)
    np.testing.assert_array_equal(line.get_xdata(), [23.7, 23.7])


def test_a_push_map_writes_what_is_in_reach_and_marks_what_cannot(tmp_path):
    figure = Figure()
    axes = figure.subplots()
    multiples = np.array([[np.nan, 0.8, 1.0], [120.0, 0.04, 2.34]])
    can, cannot, *texts = arm_plots.draw_push_map(axes, np.array([0.4, 0.5, 0.6]), np.array([0.8, 1.0]), multiples)
    assert [text.get_text() for text in texts] == ["0.80", "1.0", "120.0", "0.04", "2.3"]
    assert [text.get_weight() for text in texts] == ["bold", "normal", "normal", "bold", "normal"]
    assert texts[0].get_position() == (0.5, 0.8)
    np.testing.assert_array_equal(can.get_array().mask, [[True, True, False], [False, True, False]])
    np.testing.assert_array_equal(cannot.get_array().mask, [[True, False, True], [True, False, True]])
    assert axes.get_xlabel().endswith("(m)")
    assert axes.get_ylabel().endswith("(m)")
    assert save_figure(figure, tmp_path / "map.png").stat().st_size > 0


@pytest.mark.parametrize("multiples", [np.full((2, 2), np.nan), np.full((2, 2), 0.5), np.full((2, 2), 7.0)])
def test_maps_of_one_kind_are_drawn(multiples, tmp_path):
    figure = Figure()
    arm_plots.draw_push_map(figure.subplots(), np.array([0.4, 0.5]), np.array([0.8, 1.0]), multiples)
    save_figure(figure, tmp_path / "map.png")


@pytest.mark.parametrize(
    ("vertices", "components"), [(SQUARE, ("fx",)), (np.zeros((4, 3)), ("fx", "fy")), (SQUARE, ("fx", "fy", "fz"))]
)
def test_what_is_no_plane_shadow_is_refused(vertices, components):
    with pytest.raises(UsageError, match="wrench shadow: vertices"):
        arm_plots.draw_wrench_shadow(Figure().subplots(), vertices, components)
