"""A run as a moving GIF: the top view, which follows the cart."""

from __future__ import annotations

import io
import math
import os
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from PIL import Image

from ..errors import UsageError
from ..writing import write_atomically
from .plots import draw_path, house_style, legend_above
from .shown_run import ShownRun
from .top_view import draw_top_view

GIF_FRAMES_PER_SECOND = 10
MAX_ANIMATION_DURATION = 12.0
"""s; longer runs are shown faster."""
ANIMATION_DPI = 90


def write_gif(run: ShownRun, path: str | os.PathLike[str], progress: Callable[[float], None] | None = None) -> Path:
    """Writes a GIF of at most 12 s; `progress` is told the share done."""
    if Path(path).suffix.lower() != ".gif":
        raise UsageError(f"{path}: a moving picture is written as .gif")
    instants = frames_of(run)
    with house_style():
        figure = Figure(figsize=(4.8, 4.4))
        axes = figure.subplots()
        draw_path(axes, run.pose, run.reference_pose)
        axes.set_adjustable("box")
        shown = _show(axes, run, int(instants[0]))
        legend_above(axes)
        figure.draw_without_rendering()
        figure.set_layout_engine("none")
        frames = []
        for k, i in enumerate(instants.tolist()):
            while shown:
                shown.pop().remove()
            shown.extend(_show(axes, run, i))
            frames.append(_picture(figure))
            if progress is not None:
                progress(k / len(instants))
    return save_frames(frames, path)


def save_frames(frames: Sequence[Image.Image], path: str | os.PathLike[str]) -> Path:
    """As a GIF, over and over."""
    content = io.BytesIO()
    pause = 1000 // GIF_FRAMES_PER_SECOND
    frames[0].save(content, "GIF", save_all=True, append_images=frames[1:], duration=pause, loop=0)
    return write_atomically(path, content.getvalue())


def _show(axes: Axes, run: ShownRun, i: int) -> list[Artist]:
    """The cart in the middle; where its pose is missing the view stays."""
    x0, x1, y0, y1 = run.outline
    x, y = run.pose[i, :2].tolist()
    if math.isfinite(x + y):
        reach = 1.4 * max(x1 - x0, y1 - y0)
        axes.set(xlim=(x - reach, x + reach), ylim=(y - reach, y + reach))
    words = f"t = {run.time[i]:.1f} s"
    if "mass" in run.parameters:
        mass = run.parameters["mass"]
        words += f", mass {mass.value[i]:.1f} ± {mass.std[i]:.1f} kg"
    return [*draw_top_view(axes, run, i), axes.text(0.02, 0.02, words, transform=axes.transAxes, zorder=20)]


def _picture(figure: Figure) -> Image.Image:
    """With colours of its own, as GIFs have them."""
    drawn = io.BytesIO()
    figure.savefig(drawn, format="rgba", dpi=ANIMATION_DPI)
    width, height = (round(ANIMATION_DPI * side) for side in figure.get_size_inches().tolist())
    picture = Image.frombytes("RGBA", (width, height), drawn.getvalue())
    return picture.convert("P", palette=Image.Palette.ADAPTIVE)


def frames_of(run: ShownRun) -> np.ndarray:
    """The rows to show, evenly spaced in time; the last is the run's."""
    duration = float(run.time[-1] - run.time[0])
    count = int(min(duration, MAX_ANIMATION_DURATION) * GIF_FRAMES_PER_SECOND) + 1
    instants = np.linspace(run.time[0], run.time[-1], count)
    return np.minimum(np.searchsorted(run.time, instants - 1e-9), len(run.time) - 1)
