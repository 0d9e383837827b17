"""The top view in figures and as a GIF."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from matplotlib.artist import Artist
from matplotlib.figure import Figure
from matplotlib.patches import Ellipse, FancyArrow, Polygon
from matplotlib.transforms import Affine2D
from PIL import Image

from cartgrasp.errors import UsageError
from cartgrasp.frames import rotation_planar
from cartgrasp.view import figures
from cartgrasp.view.animation import frames_of, write_gif
from cartgrasp.view.shown_run import ShownRun
from cartgrasp.view.top_view import draw_top_view, large_force


def in_s(artist) -> np.ndarray:
    """Corners of a patch in {s}."""
    to_s = Artist.get_transform(artist) - artist.axes.transData
    return to_s.transform([artist.center] if isinstance(artist, Ellipse) else artist.get_path().vertices)


def test_what_is_drawn_stands_where_it_is(shown: ShownRun):
    i = 4000
    axes = Figure().subplots()
    artists = draw_top_view(axes, shown, i)
    rotation, origin = rotation_planar(shown.pose[i, 2]), shown.pose[i, :2]
    body, _, *tyres = (a for a in artists if isinstance(a, Polygon) and not isinstance(a, FancyArrow))
    corners = in_s(body)[:4]
    np.testing.assert_allclose(corners.mean(axis=0), origin + rotation @ [0.36, 0.0], atol=1e-9)
    fixed, behind, caster, _ = (in_s(tyre)[:4].mean(axis=0) for tyre in tyres)
    np.testing.assert_allclose(fixed, origin + rotation @ [0.0, 0.27], atol=1e-9)
    np.testing.assert_allclose(behind, origin + rotation @ [0.0, -0.27], atol=1e-9)
    assert np.hypot(*(caster - origin - rotation @ [0.72, 0.20])) == pytest.approx(0.045)
    (ellipse,) = (a for a in artists if isinstance(a, Ellipse))
    com = [shown.parameters[name].value[i] for name in ("com_x", "com_y")]
    np.testing.assert_allclose(in_s(ellipse)[0], origin + rotation @ com, atol=1e-9)
    forces = [a for a in artists if isinstance(a, FancyArrow)]
    assert len(forces) == 2
    contact = origin + rotation @ shown.contacts["left"][i, :2]
    tip = forces[0].get_xy()[np.hypot(*(forces[0].get_xy() - contact).T).argmax()]
    wanted = rotation @ shown.wrenches["left"][i, :2] * 0.7 * 0.88 / large_force(shown)
    np.testing.assert_allclose(tip - contact, wanted, atol=1e-9)


def test_the_ellipse_is_that_of_the_covariance(shown: ShownRun):
    covariance = np.array([[4e-4, -1e-4], [-1e-4, 2e-4]])
    level = replace(shown, pose=np.zeros_like(shown.pose), com_covariance=np.tile(covariance, (len(shown.time), 1, 1)))
    (ellipse,) = (a for a in draw_top_view(Figure().subplots(), level, 10) if isinstance(a, Ellipse))
    # In units that are fine enough for flat pieces of its curve to be short.
    large = ellipse.get_patch_transform() + Affine2D().scale(1e6)
    edge = 1e-6 * large.transform_path(ellipse.get_path()).to_polygons()[0]
    distance = np.einsum("ni,ij,nj->n", edge - ellipse.center, np.linalg.inv(covariance), edge - ellipse.center)
    np.testing.assert_allclose(distance, 1.0, rtol=1e-2)  # one standard deviation


def test_a_missing_pose_draws_nothing_and_a_cart_that_is_not_known_is_dotted(shown: ShownRun):
    pose = shown.pose.copy()
    pose[7] = np.nan
    axes = Figure().subplots()
    assert draw_top_view(axes, replace(shown, pose=pose), 7) == []
    body = draw_top_view(axes, replace(shown, cart=None, parameters={}), 8)[0]
    assert isinstance(body, Polygon)
    assert body.get_linestyle() in (":", "dotted")


def test_overview_without_reference_shows_velocities(shown: ShownRun, tmp_path):
    bare = replace(shown, reference_pose=None, cart=None, caster_headings=None)
    figure = figures.figure_overview(bare)
    labels = [axes.get_ylabel() for axes in figure.axes]
    assert {"Velocity in {b} (m/s)", "Yaw rate (rad/s)"} <= set(labels)
    figures.save_figure(figure, tmp_path / "bare.svg")
    with pytest.raises(UsageError, match="no reference"):
        figures.figure_tracking(bare)


def test_names_that_the_font_lacks_do_not_stop_a_gif(bare: ShownRun, tmp_path):
    """Warnings are errors here: letters without a glyph are boxes, and nothing is said."""
    name, (contact, wrench) = "推车🛒", (next(iter(part.values())) for part in (bare.contacts, bare.wrenches))
    named = replace(bare, time=bare.time / 60, contacts={name: contact}, wrenches={name: wrench})
    assert write_gif(named, tmp_path / "run.gif").read_bytes().startswith(b"GIF")


def test_a_gif_moves_and_ends_with_the_run(bare: ShownRun, tmp_path):
    short = replace(bare, time=bare.time / 6)  # one second
    path = write_gif(short, tmp_path / "run.gif")
    with Image.open(path) as picture:
        assert picture.n_frames == len(frames_of(short)) == 10
        first = np.asarray(picture.convert("RGB")).astype(int)
        picture.seek(9)
        last = np.asarray(picture.convert("RGB")).astype(int)
    assert (np.abs(last - first).max(axis=-1) > 60).mean() > 0.001
    assert frames_of(short)[-1] == len(short.time) - 1
    assert [p.name for p in tmp_path.iterdir()] == ["run.gif"]
    with pytest.raises(UsageError, match=r"\.gif"):
        write_gif(short, tmp_path / "run.png")
