"""The cart from above at one instant: body, wheels, casters, arms with their forces, estimated CoM with its ellipse."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.patches import Ellipse, FancyArrow, Polygon
from matplotlib.transforms import Affine2D, Transform

from ..frames import Array, rotation_planar
from ..wheels import CASTER
from .plots import ARM_MARKERS, OKABE_ITO, PURPLE, plain_text
from .shown_run import ShownRun

BODY_COLOUR, EDGE_COLOUR, WHEEL_COLOUR = "#EEF1F4", "#7A8592", "#3C4654"
FRONT_ZORDER = 4
MAX_ARROW_FRACTION = 0.7
"""Length of an arrow for the run's large forces, as a share of the cart's length."""


def draw_top_view(axes: Axes, run: ShownRun, i: int, mark_size: float = 4.0) -> list[Artist]:
    """The run at instant `i`, in {s}, m, with marks of so many points; nothing where the pose is missing. A body that
    is only guessed is dotted."""
    x, y, theta = run.pose[i].tolist()
    if not math.isfinite(x + y + theta):
        return []
    from_b = Affine2D().rotate(theta).translate(x, y)
    artists = _body(axes, run, from_b) + _wheels(axes, run, i, from_b)
    artists += _estimated_com(axes, run, i, from_b) + _arms(axes, run, i, mark_size)
    axes.set(aspect="equal", xlabel="x (m)", ylabel="y (m)")
    return artists


def _body(axes: Axes, run: ShownRun, from_b: Affine2D) -> list[Artist]:
    x0, x1, y0, y1 = run.outline
    size, middle = 0.12 * min(x1 - x0, y1 - y0), (y0 + y1) / 2
    corners = [(x0, y0), (x1, y0), (x1, y1), (x0, y1)]
    nose = [(x1 - 2 * size, middle + size), (x1 - size, middle), (x1 - 2 * size, middle - size)]
    known: dict[str, Any] = {"facecolor": BODY_COLOUR} if run.cart else {"fill": False, "linestyle": ":"}
    box = Polygon(corners, edgecolor=EDGE_COLOUR, linewidth=0.8, joinstyle="round", zorder=FRONT_ZORDER, **known)
    front = Polygon(nose, closed=False, fill=False, edgecolor=EDGE_COLOUR, linewidth=1.0, zorder=FRONT_ZORDER)
    return [_placed(axes, one, from_b) for one in (box, front)]


def _wheels(axes: Axes, run: ShownRun, i: int, from_b: Affine2D) -> list[Artist]:
    wheels = () if run.cart is None else run.cart.wheels
    headings = iter([] if run.caster_headings is None else run.caster_headings[i].tolist())
    x0, x1, y0, y1 = run.outline
    size = float(np.clip(0.2 * min(x1 - x0, y1 - y0), 0.05, 0.3))
    artists = []
    for wheel in wheels:
        is_caster = wheel.kind == CASTER
        heading = next(headings, math.nan) if is_caster else 0.0
        if not math.isfinite(heading):
            continue
        behind = max(wheel.trail, 0.3 * size) if is_caster else 0.0
        a, b = size / 2, 0.19 * size
        tyre = Polygon(
            [(-a, -b), (a, -b), (a, b), (-a, b)], facecolor=WHEEL_COLOUR, edgecolor="none", zorder=FRONT_ZORDER + 1
        )
        turned = Affine2D().translate(-behind, 0).rotate(heading).translate(wheel.x, wheel.y)
        artists.append(_placed(axes, tyre, turned + from_b))
    return artists


def _estimated_com(axes: Axes, run: ShownRun, i: int, from_b: Affine2D) -> list[Artist]:
    """The ellipse of one standard deviation; without a covariance its axes are those of {b}."""
    known = run.estimated_com(i)
    if known is None:
        return []
    com, covariance = known
    variances, directions = np.linalg.eigh(covariance)
    height, width = 2 * np.sqrt(np.maximum(variances, 0.0))
    turn = math.degrees(math.atan2(directions[1, 1], directions[0, 1]))
    ellipse = Ellipse(
        com, width, height, angle=turn, facecolor=PURPLE, edgecolor=PURPLE, alpha=0.35, zorder=FRONT_ZORDER + 2
    )
    dot = axes.plot(*from_b.transform(com), color=PURPLE, marker=".", markersize=2, zorder=FRONT_ZORDER + 3)
    return [_placed(axes, ellipse, from_b), *dot]


def _arms(axes: Axes, run: ShownRun, i: int, size: float) -> list[Artist]:
    x, y, theta = run.pose[i].tolist()
    rotation = rotation_planar(theta)
    x0, x1, _, _ = run.outline
    scale = MAX_ARROW_FRACTION * (x1 - x0) / large_force(run)
    artists: list[Artist] = []
    for k, (name, contacts) in enumerate(run.contacts.items()):
        colour, mark = OKABE_ITO[k % len(OKABE_ITO)], ARM_MARKERS[k % len(ARM_MARKERS)]
        contact = rotation @ contacts[i, :2] + (x, y)
        force = scale * rotation @ run.wrenches[name][i, :2]
        if not np.isfinite(contact).all():
            continue
        look: dict[str, Any] = {"color": colour, "marker": mark, "markersize": size, "linestyle": "none"}
        artists += axes.plot(*contact, label=plain_text(name, 14), zorder=FRONT_ZORDER + 4, **look)
        if np.isfinite(force).all():
            artists.append(_arrow(axes, contact, force, 0.07 * (x1 - x0), colour))
    return artists


def _arrow(axes: Axes, start: Array, along: Array, head: float, colour: str) -> Artist:
    head = min(head, 0.5 * float(np.hypot(*along)))
    look: dict[str, Any] = {"length_includes_head": True, "color": colour, "zorder": FRONT_ZORDER + 3}
    return axes.add_patch(FancyArrow(*start, *along, width=0.25 * head, head_width=head, **look))


def large_force(run: ShownRun) -> float:
    """N: one in twenty of the run's is larger."""
    sizes = np.concatenate([np.zeros(0), *(np.hypot(*wrench[:, :2].T) for wrench in run.wrenches.values())])
    sizes = sizes[np.isfinite(sizes)]
    return max(1.0, float(np.quantile(sizes, 0.95))) if len(sizes) else 1.0


def _placed(axes: Axes, patch: Polygon | Ellipse, from_b: Transform) -> Artist:
    patch.set_transform(from_b + axes.transData)
    axes.add_patch(patch)
    return patch
