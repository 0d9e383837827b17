"""What laws say against what the logs do: forces row by row, over the variable, folded where it repeats, with the law's
curve and its band on top."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from cartgrasp.effects import LearnedForce
from cartgrasp.frames import Array

from ..weak_form.balances import Balances
from .course import ROLLING, rows_at
from .laws import seen_values

if TYPE_CHECKING:
    from .diagnosis import Diagnosis
    from .learned import LearnedLaw

LEAST_UNIT = 0.3
"""Of the largest: rows in which a law shows less tell its force too badly to be drawn."""
POINTS = 400
LEFT, LAW = "0.6", "#0072b2"


def law_figure(found: Diagnosis) -> Figure:
    """A row for each law."""
    laws = [law for _, law in found.certainty.laws]
    figure = Figure(figsize=(7.2, 2.4 * len(laws)), layout="constrained")
    for ax, law in zip(figure.subplots(len(laws), 1, squeeze=False).ravel(), laws, strict=True):
        at, force, told = (np.concatenate(each) for each in zip(*asked_forces(found, law), strict=True))
        effect, unit = law.effect, law.effect.parameters[0].unit
        ax.set_title(law.words, fontsize=8)
        if effect.knots_y:
            most = float(np.abs(law.range).max())
            shown = ax.scatter(*at.T, c=force, s=6, cmap="PuOr", vmin=-most, vmax=most)
            ax.set(xlabel="x (m)", ylabel="y (m)", aspect="equal")
            bar = figure.colorbar(shown, ax=ax, label=f"force ({unit})")
            if bar.solids is not None:
                bar.solids.set(rasterized=False, edgecolor="face")
            continue
        at = at % effect.cycle if effect.cycle else at
        curve = np.linspace(at.min(), at.max(), POINTS)
        value, std = law.curve(curve)
        ax.plot(at, force, ".", ms=2, color=LEFT, label="rows, all else taken away")
        ax.plot(at, told, ".", ms=2, color=LAW, alpha=0.5, label="law, averaged as rows are")
        ax.fill_between(curve, value - std, value + std, color=LAW, alpha=0.3, lw=0)
        ax.plot(curve, value, color=LAW, lw=1.2, label="law ± one standard deviation")
        name = effect.of.replace("_", " ") + (", folded" if effect.cycle else "")
        ax.set(xlabel=f"{name} ({law.unit})", ylabel=unit)
        ax.legend(frameon=False, fontsize=7)
    return figure


def asked_forces(found: Diagnosis, law: LearnedLaw) -> list[tuple[Array, Array, Array]]:
    """Of each log, values of the variable, the forces that rows ask for beside everything but this law, and what the
    law says of them."""
    model, parts = found.final, list[tuple[Array, Array, Array]]()
    left = np.split(model.left, np.cumsum([len(balances.used) for balances in model.logs])[:-1])
    for balances, rest in zip(model.logs, left, strict=True):
        own = balances.columns(model.cart, law.effect) @ law.effect.values
        last = model.cart.constraints.n_free - 1 if law.effect.acts_on == "yaw_moment" else 0
        weight = balances.integrated(np.ones(len(balances.motion.time)))
        rows = rows_at(balances.motion, balances.time)
        unit = _unit(law.effect, balances)[rows]
        shown = np.abs(unit) >= LEAST_UNIT * np.abs(unit).max()
        force, told = (-(one[:, last] / weight)[shown] / unit[shown] for one in (rest + own, own))
        parts.append((seen_values(law.effect, [balances.motion])[rows][shown], force, told))
    return parts


def _unit(effect: LearnedForce, balances: Balances) -> Array:
    """What a unit of the force gives forwards, or as a moment, along the motion (n,)."""
    motion = balances.motion
    speed = motion.velocity[:, 0] - (effect.lever * motion.velocity[:, -1] if motion.velocity.shape[1] > 1 else 0.0)
    along = {
        "drag": -np.where(np.abs(speed) > ROLLING, np.sign(speed), 0.0),
        "viscous_drag": -speed,
        "world_force": np.cos(effect.direction - motion.pose[:, 2]),
    }
    return np.asarray(along.get(effect.acts_on, np.ones(len(speed))))
