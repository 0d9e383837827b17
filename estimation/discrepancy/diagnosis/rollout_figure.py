"""Two unseen stretches, measured and simulated, without what was added and with it: a usual one, and that in which
simulation without it goes the farthest astray."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from cartgrasp.frames import Array, wrap_angle
from cartgrasp.model import CartModel

from ...weak_form.balances import Balances
from ..findings.forced_motion import ForcedMotion
from ..findings.held_out import HELD_OUT_FOLDS, fold_carts, fold_starts
from ..findings.rollouts import HORIZONS, rolled_out, rollouts
from .drawing import MODEL_COLOURS, grid

if TYPE_CHECKING:
    from .diagnosis import Diagnosis

STEPS_PER_CURVE_POINT = 5
"""Steps of the grid from point to point of a curve."""
DRAWN_HORIZON_INDEX = -1
"""Index of the horizon that is as long as a stretch is drawn."""


@dataclass(frozen=True, eq=False)
class Stretch:
    """A row of a log's grid from which a fold's carts begin, and how far (m) the refitted one is astray in the end."""

    balances: Balances
    fold: int
    first: int
    error: float


def rollout_figure(found: Diagnosis) -> Figure | None:
    """Figure with a row for each stretch; None where no stretch is long enough."""
    carts = {"nominal": [found.nominal.guess] * HELD_OUT_FOLDS, "refitted": fold_carts(found.nominal)}
    carts |= {"extended": fold_carts(found.final)} if found.effects else {}
    known = [
        Stretch(balances, k, int(row), float(error))
        for balances, k, first in fold_starts(found.nominal)
        for row, error in zip(first, _end_errors(balances, carts["refitted"][k], first), strict=True)
        if np.isfinite(error)
    ]
    if not known:
        return None
    usual = float(np.sqrt(np.mean([one.error**2 for one in known])))
    shown = {
        "a usual stretch": min(known, key=lambda one: abs(one.error - usual)),
        "the farthest astray": max(known, key=lambda one: one.error),
    }
    turns = found.nominal.cart.constraints.n_free > 1
    figure, axes = grid(len(shown), 2 + turns, 1.9)
    for row, (words, stretch) in zip(axes, shown.items(), strict=True):
        _draw(row, stretch, {name: own[stretch.fold] for name, own in carts.items()})
        row[0].set_title(f"{words}, from t = {stretch.balances.motion.time[stretch.first]:.1f} s", fontsize=8)
    for ax in axes[-1]:
        ax.set_xlabel("time simulated (s)")
    axes[0][0].legend(frameon=False, fontsize=7)
    return figure


def _end_errors(balances: Balances, cart: CartModel, first: np.ndarray) -> Array:
    """How far (starts,), m, a cart is astray in the end."""
    return np.asarray(np.hypot(*rollouts(balances, cart, first).error[:, DRAWN_HORIZON_INDEX, :2].T))


def _draw(row: np.ndarray, stretch: Stretch, carts: dict[str, CartModel]) -> None:
    motion = stretch.balances.motion
    after = np.arange(0, round(HORIZONS[DRAWN_HORIZON_INDEX] / motion.step) + 1, STEPS_PER_CURVE_POINT)
    time = motion.time[stretch.first + after] - motion.time[stretch.first]
    for name, cart in carts.items():
        true, driven = motion.of_body(cart).pose[stretch.first + after], ForcedMotion.of(stretch.balances, cart)
        rolled = rolled_out(stretch.balances, cart, np.array([stretch.first]), driven, after[1:])[0]
        pose = np.vstack([driven.pose[stretch.first], rolled])
        if name == "nominal":
            _rates(row, time, true, "measured")
        _rates(row, time, pose, name)
        row[-1].plot(time, 1e3 * np.hypot(*(pose - true)[:, :2].T), color=MODEL_COLOURS[name], lw=1.2, label=name)
    for ax, words in zip(row[:-1], ("forward speed (m/s)", "yaw rate (rad/s)"), strict=False):
        ax.set_ylabel(words)
    row[-1].set_ylabel("astray (mm)")


def _rates(row: np.ndarray, time: Array, pose: Array, name: str) -> None:
    """Draws the forward speed and yaw rate of poses (n, 3) from point to point."""
    step, middle = np.diff(time), (time[1:] + time[:-1]) / 2
    turned = wrap_angle(np.diff(pose[:, 2]))
    heading = pose[:-1, 2] + turned / 2
    forward = np.cos(heading) * np.diff(pose[:, 0]) + np.sin(heading) * np.diff(pose[:, 1])
    for ax, rate in zip(row[:-1], (forward, turned), strict=False):
        ax.plot(middle, rate / step, color=MODEL_COLOURS[name], lw=2.2 if name == "measured" else 1.2, label=name)
