"""What laws say against what the logs do: forces row by row, over the variable, folded where it repeats, with the law's
curve and its band on top; and what is left with the law."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from cartgrasp.frames import Array

from ..search.laws import constant, row_values, variable_of
from ..search.model import by_log
from ..where.residual import with_fine_rows
from .drawing import MODEL_COLOURS, ZERO_LINE_STYLE, on_floor, sides

if TYPE_CHECKING:
    from ..findings.learned_laws import LearnedLaw
    from .diagnosis import Diagnosis

MIN_UNIT_EFFECT_RATIO = 0.3
"""Least effect of a law on a row, as a share of the largest: rows with less tell its force too badly to be drawn."""
LAW_CURVE_POINTS, MAX_FIGURE_DOTS = 400, 3000


def law_figure(found: Diagnosis) -> Figure:
    """Figure of laws, a row for each."""
    laws = [law for _, law in found.certainty.laws]
    figure, axes = sides(len(laws), 2, 2.4)
    wheels = [wheel.y for wheel in found.final.cart.wheels if wheel.y]
    for row, law in zip(axes, laws, strict=True):
        at, force, told = required_forces(found, law)
        effect, every = law.effect, slice(None, None, 1 + len(at) // MAX_FIGURE_DOTS)
        unit = effect.parameters[0].unit
        if effect.knots_y:
            on_floor(figure, row, at[every], [force[every], (force - told)[every]], f"force ({unit})")
            continue
        at = at % effect.cycle if effect.cycle else at
        curve = np.linspace(at.min(), at.max(), LAW_CURVE_POINTS)
        value, std = law.curve(curve)
        for ax, dots in zip(row, (force, force - told), strict=True):
            ax.plot(at[every], dots[every], ".", ms=2, color="0.6")
            ax.axhline(0, **ZERO_LINE_STYLE)
            there = " of the wheel" * (effect.of == "travelled_distance" and effect.lever in wheels)
            ax.set_xlabel(f"{variable_of(effect)}{there} ({law.unit}){', folded' if effect.cycle else ''}")
        row[0].plot(curve, value, color=MODEL_COLOURS["extended"], lw=1.5)
        row[0].fill_between(curve, value - std, value + std, color=MODEL_COLOURS["extended"], alpha=0.3, lw=0)
        row[0].set_ylabel(f"{effect.acts_on.replace('_', ' ')} ({unit})")
    return figure


def required_forces(found: Diagnosis, law: LearnedLaw) -> tuple[Array, Array, Array]:
    """Values of a law's variable, the forces that rows ask for beside everything but this law, and what the law says of
    them. Each is (n,), of the rows in which the law shows."""
    model, logs, parts = found.final, with_fine_rows(found.final.logs), list[tuple[Array, Array, Array]]()
    last = model.cart.constraints.n_free - 1 if law.effect.acts_on == "yaw_moment" else 0
    left, at = by_log(model.residual_on(logs), logs), by_log(row_values(law.effect, logs), logs)
    for balances, rest, own_at in zip(logs, left, at, strict=True):
        own = (balances.columns(model.cart, law.effect) @ law.effect.values)[:, last]
        unit = balances.columns(model.cart, constant(law.effect))[:, last, 0]
        shown = np.abs(unit) >= MIN_UNIT_EFFECT_RATIO * np.abs(unit).max()
        parts.append((own_at[shown], ((rest[:, last] + own) / unit)[shown], (own / unit)[shown]))
    where, force, told = (np.concatenate(each) for each in zip(*parts, strict=True))
    return where, force, told
