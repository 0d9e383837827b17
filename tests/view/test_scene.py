"""Scenes: bodies are where a plant's physics has them; pictures show arms and forces in their colours."""

from __future__ import annotations

from dataclasses import replace

import mujoco
import numpy as np
import pytest
from matplotlib.image import imread
from PIL import Image

from cartgrasp.contacts import ContactWrenches
from cartgrasp.errors import UsageError
from cartgrasp.model import CartModel
from cartgrasp.simulation.mujoco_plant import MujocoPlant
from cartgrasp.view import rendering
from cartgrasp.view.plots import OKABE_ITO
from cartgrasp.view.rendering import rendered, write_scene
from cartgrasp.view.scene import SCENE_HEIGHT, SCENE_WIDTH, Scene
from cartgrasp.view.shown_run import ShownRun

from .offscreen import needs_opengl


def pushed(cart: CartModel, steps: int = 150) -> tuple[MujocoPlant, ShownRun]:
    """A plant that turned while its casters swung, and the run's last instant as shown."""
    plant = MujocoPlant(cart, (1.0, -2.0, 0.7), heading=2.5)
    push = ContactWrenches({"hand": np.array([25.0, 0, 0, 0, 0, 6.0])}, {"hand": np.array([-0.25, 0.1, 1.0])})
    for _ in range(steps):
        plant.step(push, 0.01)
    assert plant.caster_headings is not None
    return plant, ShownRun(
        name="pushed",
        cart=cart,
        time=np.array([plant.time]),
        pose=plant.motion.pose_sb[None],
        velocity_b=plant.velocity_b[None],
        contacts={"hand": push.contacts["hand"][None]},
        wrenches={"hand": push.wrenches["hand"][None]},
        caster_headings=plant.caster_headings[None],
    )


def test_wheels_are_where_physics_has_them(shown: ShownRun):
    assert shown.cart is not None
    plant, run = pushed(shown.cart)
    scene = Scene.of(run)
    placed = scene.placed(0)
    turn = np.array([[np.cos(0.7), -np.sin(0.7)], [np.sin(0.7), np.cos(0.7)]])
    there = plant._data.geom_xpos[plant._wheel_geoms]
    there = np.column_stack([there[:, :2] @ turn.T + (1.0, -2.0), there[:, 2]])
    assert placed.mocap_pos[1:] == pytest.approx(there, abs=2e-3)
    assert scene.model.nmocap == 1 + len(there)


@needs_opengl
def test_what_a_picture_shows(shown: ShownRun, tmp_path):
    path = write_scene(shown, tmp_path / "scene.png")
    pixels = imread(path)[..., :3]
    assert pixels.shape == (SCENE_HEIGHT, SCENE_WIDTH, 3)
    for colour in OKABE_ITO[: len(shown.contacts)]:
        assert like(pixels, colour) > 50
    silent = replace(shown, wrenches={name: 0 * wrench for name, wrench in shown.wrenches.items()})
    without = imread(write_scene(silent, tmp_path / "silent.png"))[..., :3]
    assert like(without, OKABE_ITO[0]) < like(pixels, OKABE_ITO[0])


def like(pixels: np.ndarray, colour: str) -> int:
    """Pixels of a hue, in light or shade."""
    wanted = np.array([int(colour[i : i + 2], 16) for i in (1, 3, 5)]) / 255
    bright = np.linalg.norm(pixels, axis=-1)
    along = pixels @ wanted / (np.maximum(bright, 1e-9) * np.linalg.norm(wanted))
    return int(((along > 0.99) & (bright > 0.15)).sum())


@needs_opengl
def test_the_camera_stays_with_the_cart(shown: ShownRun):
    """So two instants show the cart in one place, though it moved metres."""
    bare = replace(shown, contacts={}, wrenches={}, parameters={}, reference_pose=None)
    bare = replace(bare, pose=np.column_stack([shown.pose[:, :2], 0 * shown.time]), caster_headings=None)
    first, last = rendered(Scene.of(bare), np.array([0, len(bare.time) // 2]), shrunk=4)
    assert np.hypot(*(bare.pose[0, :2] - bare.pose[len(bare.time) // 2, :2])) > 1.0
    dark = [(picture < 90).all(axis=-1) for picture in (first, last)]
    assert dark[0].sum() > 20
    assert (dark[0] & dark[1]).sum() > 0.6 * dark[0].sum()


@needs_opengl
def test_a_gif_moves(shown: ShownRun, tmp_path):
    short = shown.averaged(1.0)
    short = replace(short, time=short.time * 0.02)
    told: list[float] = []
    with Image.open(write_scene(short, tmp_path / "scene.gif", told.append)) as moving:
        assert moving.size == (SCENE_WIDTH // 2, SCENE_HEIGHT // 2)
        assert 5 < getattr(moving, "n_frames", 1) == len(told)


def test_what_is_refused(shown: ShownRun, tmp_path, monkeypatch):
    with pytest.raises(UsageError, match=r"\.png or \.gif"):
        write_scene(shown, tmp_path / "scene.svg")
    with pytest.raises(UsageError, match="no pose of"):
        write_scene(replace(shown, pose=np.full_like(shown.pose, np.nan)), tmp_path / "scene.png")

    def none() -> None:
        raise ImportError("No module named 'OpenGL'")

    monkeypatch.setattr(rendering, "_window", none)
    with pytest.raises(UsageError, match=r"pip install '\.\[rendering\]'"):
        write_scene(shown, tmp_path / "scene.png")
    assert not list(tmp_path.iterdir())


def test_missing_samples_are_left_out(shown: ShownRun):
    holes = shown.pose.copy()
    holes[::3] = np.nan
    run = replace(shown, pose=holes, contacts={k: np.full_like(v, np.nan) for k, v in shown.contacts.items()})
    scene = Scene.of(run)
    drawn = mujoco.MjvScene(scene.model, maxgeom=1000)
    scene.draw_over(drawn, 1)
    assert 0 < drawn.ngeom < 1000
    full = mujoco.MjvScene(scene.model, maxgeom=3)
    Scene.of(shown).draw_over(full, 1)
    assert full.ngeom == 3
