"""Pictures of a run in three dimensions, by MuJoCo, without a display: a still, or a GIF that moves."""

from __future__ import annotations

import io
import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
from PIL import Image

from ..errors import UsageError
from ..writing import write_atomically
from .animation import frames_of, save_frames
from .scene import SCENE_HEIGHT, SCENE_WIDTH, Scene
from .shown_run import ShownRun

MAX_SCENE_SHAPES = 10_000
"""Largest number of shapes in a picture."""
SCENE_SUFFIXES = (".png", ".gif")
GIF_COLOURS = 96
"""The number of colours in a GIF's frame."""


def write_scene(run: ShownRun, path: str | os.PathLike[str], progress: Callable[[float], None] | None = None) -> Path:
    """Writes the run's middle as a PNG, or the run as a GIF of at most 12 s, with the path on the floor; `progress` is
    told the share done. UsageError where OpenGL can't be had."""
    path = Path(path)
    kind = path.suffix.lower()
    if kind not in SCENE_SUFFIXES:
        raise UsageError(f"{path}: a scene is written as {' or '.join(SCENE_SUFFIXES)}")
    rows = np.flatnonzero(np.isfinite(run.pose).all(axis=1))
    if not len(rows):
        raise UsageError(f"{path}: no pose of {run.name} is known, so there is nothing to draw")
    if kind == ".gif":
        wanted, shrunk = rows[np.minimum(np.searchsorted(rows, frames_of(run)), len(rows) - 1)], 2
    else:
        wanted, shrunk = rows[len(rows) // 2 :][:1], 1
    pictures = []
    for k, picture in enumerate(rendered(Scene.of(run), wanted, shrunk)):
        pictures.append(Image.fromarray(picture))
        if progress is not None:
            progress(k / len(wanted))
    if kind == ".gif":
        return save_frames([picture.quantize(GIF_COLOURS) for picture in pictures], path)
    content = io.BytesIO()
    pictures[0].save(content, "PNG")
    return write_atomically(path, content.getvalue())


def rendered(scene: Scene, instants: np.ndarray, shrunk: int = 1) -> Iterator[np.ndarray]:
    """A picture (SCENE_HEIGHT / shrunk, SCENE_WIDTH / shrunk, 3) for each instant, bytes of red, green, blue."""
    drawn, options = mujoco.MjvScene(scene.model, maxgeom=MAX_SCENE_SHAPES), mujoco.MjvOption()
    height, width = SCENE_HEIGHT // shrunk, SCENE_WIDTH // shrunk
    frame, every = mujoco.MjrRect(0, 0, width, height), mujoco.mjtCatBit.mjCAT_ALL.value
    with _context(scene.model) as context:
        for i in instants.tolist():
            placed, camera = scene.placed(i), scene.camera(i)
            mujoco.mjv_updateScene(scene.model, placed, options, None, camera, every, drawn)
            scene.draw_over(drawn, i)
            mujoco.mjr_render(frame, drawn, context)
            picture = np.empty((height, width, 3), np.uint8)
            mujoco.mjr_readPixels(picture, None, frame, context)
            yield picture[::-1]


@contextmanager
def _context(model: mujoco.MjModel) -> Iterator[Any]:
    window = offscreen()
    try:
        context = mujoco.MjrContext(model, mujoco.mjtFontScale.mjFONTSCALE_100.value)
        mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN.value, context)
        yield context
        context.free()
    finally:
        window.free()


def offscreen() -> Any:
    """Where OpenGL draws from now on, without a display, until it is freed; what keeps it from that is one error."""
    try:
        window = _window()
        window.make_current()
    except Exception as error:  # drivers and PyOpenGL have errors of their own, of no common base
        raise UsageError(
            f"MuJoCo finds no OpenGL to draw with ({error}): in cartgrasp's clone, pip install '.[rendering]'; "
            "where there is no graphics card, Mesa's (Debian: libegl1 and libgl1-mesa-dri)"
        ) from error
    return window


def _window() -> Any:
    """The OpenGL context; on Linux by EGL, which needs no display, unless MUJOCO_GL says otherwise."""
    if sys.platform == "linux" and not os.environ.get("MUJOCO_GL"):
        os.environ.setdefault("PYOPENGL_PLATFORM", "egl")
        from mujoco.egl import GLContext

        return GLContext(SCENE_WIDTH, SCENE_HEIGHT)
    return mujoco.GLContext(SCENE_WIDTH, SCENE_HEIGHT)
