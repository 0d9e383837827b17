"""Figures: what they draw, that units stand on every axis, and what becomes a file."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import replace

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.artist import Artist
from matplotlib.figure import Figure

from cartgrasp.errors import UsageError
from cartgrasp.simulation.record import Series
from cartgrasp.view import figures, plots
from cartgrasp.view.shown_run import ShownRun

EVERY_FIGURE = (
    figures.figure_overview,
    figures.figure_tracking,
    figures.figure_parameters,
    figures.figure_arms,
)


def has_unit(label: str) -> bool:
    return label.endswith(")") and "(" in label and len(label.rsplit("(", 1)[1]) > 1


def assert_units_everywhere(figure: Figure) -> None:
    assert figure.axes
    for axes in figure.axes:
        assert has_unit(axes.get_xlabel()), axes.get_xlabel()
        assert has_unit(axes.get_ylabel()), axes.get_ylabel()


@pytest.mark.parametrize("make", EVERY_FIGURE)
def test_figures_have_units_on_every_axis_and_become_png(make, shown: ShownRun, tmp_path):
    figure = make(shown)
    assert_units_everywhere(figure)
    path = figures.save_figure(figure, tmp_path / "figure.png")
    content = path.read_bytes()
    assert content.startswith(b"\x89PNG\r\n")
    width = int.from_bytes(content[16:20], "big")
    assert width == round(160 * figure.get_size_inches()[0])
    assert [p.name for p in tmp_path.iterdir()] == ["figure.png"]


def test_the_same_run_gives_the_same_file(shown: ShownRun, tmp_path):
    for kind in ("png", "pdf", "svg"):
        first, second = (
            figures.save_figure(figures.figure_tracking(shown), tmp_path / f"{i}.{kind}").read_bytes() for i in (1, 2)
        )
        assert first == second


def test_a_suffix_that_is_no_format_is_refused(shown: ShownRun, tmp_path):
    with pytest.raises(UsageError, match=r"\.png, \.pdf, \.svg"):
        figures.save_figure(Figure(), tmp_path / "figure.bmp")


def test_a_run_without_estimates_has_an_overview_and_no_parameters(bare: ShownRun, tmp_path):
    figure = figures.figure_overview(bare)
    assert_units_everywhere(figure)
    assert len(figure.axes) == 5
    figures.save_figure(figure, tmp_path / "bare.png")
    with pytest.raises(UsageError, match="nothing was estimated"):
        figures.figure_parameters(bare)


def test_functions_return_what_they_drew(shown: ShownRun):
    axes = Figure().subplots()
    drawn = {
        "tracking error": plots.draw_tracking_error(axes, shown.time, shown.tracking_error),
        "parameter": plots.draw_parameter(axes, shown.time, shown.parameters["mass"], "mass"),
        "path": plots.draw_path(axes, shown.pose, shown.reference_pose),
        "forces": plots.draw_forces(axes, shown.time, shown.wrenches),
        "moments": plots.draw_moments(axes, shown.time, shown.wrenches),
        "contacts": plots.draw_contacts(axes, shown.time, shown.contacts),
    }
    assert {name: len(artists) for name, artists in drawn.items()} == {
        "tracking error": 1,
        "parameter": 3,
        "path": 3,
        "forces": 4,
        "moments": 2,
        "contacts": 4,
    }
    assert all(isinstance(a, Artist) and a.axes is axes for artists in drawn.values() for a in artists)


def test_lines_hold_the_data_in_the_unit_of_their_axis(shown: ShownRun):
    axes = Figure().subplots()
    (error,) = plots.draw_tracking_error(axes, shown.time, shown.tracking_error)
    np.testing.assert_allclose(error.get_ydata(), 100 * shown.tracking_error)
    (left, right) = plots.draw_moments(axes, shown.time, shown.wrenches)
    np.testing.assert_array_equal(left.get_ydata(), shown.wrenches["left"][:, 5])
    np.testing.assert_array_equal(right.get_ydata(), shown.wrenches["right"][:, 5])


def test_band_is_one_standard_deviation_and_truth_is_dashed():
    time = np.linspace(0, 1, 5)
    series = Series(np.full(5, 20.0), np.linspace(2, 1, 5), np.full(5, 21.0), "kg")
    axes = Figure().subplots()
    band, estimate, truth = plots.draw_parameter(axes, time, series, "mass")
    edges = band.get_paths()[0].vertices
    assert edges[:, 1].max() == 22.0
    assert edges[:, 1].min() == 18.0
    assert estimate.get_linestyle() == "-"
    assert truth.get_linestyle() == "--"
    assert axes.get_ylabel() == "Mass (kg)"


@pytest.mark.parametrize(
    ("name", "unit", "label"),
    [
        ("com_x", "m", "CoM x (m)"),
        ("rolling_resistance.coefficient", "-", "rolling_resistance\ncoefficient (–)"),
        ("force_bias.left.fx", "N", "force_bias.left\nfx (N)"),
    ],
)
def test_labels_of_parameters(name: str, unit: str, label: str):
    axes = Figure().subplots()
    plots.draw_parameter(axes, np.arange(3.0), Series(np.ones(3), np.ones(3), None, unit), name)
    assert axes.get_ylabel() == label


def test_unknown_or_mixed_components_are_refused(shown: ShownRun):
    axes = Figure().subplots()
    for components in (("fx", "tz"), ("fq",), ()):
        with pytest.raises(UsageError, match="components"):
            plots.draw_wrenches(axes, shown.time, shown.wrenches, components)


def test_missing_samples_leave_gaps(shown: ShownRun, tmp_path):
    pose = shown.pose.copy()
    pose[100:200] = np.nan
    empty = Series(*np.full((3, len(shown.time)), np.nan), "kg")
    gappy = replace(shown, pose=pose, parameters=shown.parameters | {"mass": empty})
    figures.save_figure(figures.figure_overview(gappy), tmp_path / "gaps.png")
    nowhere = replace(shown, pose=np.full_like(pose, np.nan))
    figures.save_figure(figures.figure_tracking(nowhere), tmp_path / "nowhere.png")


@pytest.mark.parametrize("name", ["_left", "$\\frac{", "a$b$c", "line\nbreak\x00", "左腕", "\ud800", "x" * 200])
def test_names_of_arms_are_drawn_letter_by_letter(name: str, shown: ShownRun, tmp_path):
    left = shown.contacts["left"], shown.wrenches["left"]
    figure = figures.figure_arms(replace(shown, contacts={name: left[0]}, wrenches={name: left[1]}))
    legend = figure.axes[0].get_legend()
    assert legend is not None
    assert len(legend.get_texts()) == 3
    figures.save_figure(figure, tmp_path / "named.png")
    assert figure.axes[0].get_position().width > 0.6


def test_style_ends_with_its_context():
    before = dict(mpl.rcParams)
    with plots.house_style():
        assert mpl.rcParams["axes.spines.top"] is False
    assert dict(mpl.rcParams) == before


def test_colours_are_those_of_okabe_and_ito():
    published = {"000000", "E69F00", "56B4E9", "009E73", "F0E442", "0072B2", "D55E00", "CC79A7"}
    assert {colour.lstrip("#").upper() for colour in plots.OKABE_ITO} == published


def test_only_figures_import_matplotlib():
    code = (
        "import sys, cartgrasp.view, cartgrasp.view.player\n"
        "assert 'matplotlib' not in sys.modules\n"
        "import cartgrasp.view.figures\n"
        "assert 'matplotlib.pyplot' not in sys.modules"
    )
    subprocess.run([sys.executable, "-c", code], check=True, timeout=60)


def test_where_nobody_touches_the_cart_no_arm_is_drawn(record, shown: ShownRun):
    bare = ShownRun.of_log(replace(record.log, arms={}))
    figure = figures.figure_overview(bare)
    assert_units_everywhere(figure)
    with_arms = figures.figure_overview(ShownRun.of_log(record.log))
    assert len(with_arms.axes) - len(figure.axes) == 3  # forces, moments, contacts
    with pytest.raises(UsageError, match="nobody touches the cart"):
        figures.figure_arms(bare)


def test_where_the_estimate_is_not_ok_is_drawn_behind_it(shown: ShownRun):
    """Words are spread over the run, be they as many as its rows or fewer."""
    n = len(shown.time)
    assert not shown.doubtful.any()
    doubtful = replace(shown, healths=("ok", "inconsistent", "ok", "ok"))
    np.testing.assert_array_equal(np.flatnonzero(doubtful.doubtful), np.arange(n // 4, n // 2))
    for run, told in ((shown, []), (doubtful, ["health not ok"])):
        legend = figures.figure_parameters(run).axes[0].get_legend_handles_labels()[1]
        assert [label for label in legend if "health" in label] == told
