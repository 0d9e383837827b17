"""Where a model and a log disagree, as what was named tells it: while and where an effect acts that comes and goes."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from cartgrasp.effects import ConstraintEffect, Effect
from cartgrasp.effects.effect import Gate

from ...weak_form.balances import Balances
from ...weak_form.wheel_tracks import touches
from ..search.gains import added
from ..search.model import Model
from .residual import Residual
from .where import Disagreement, runs

GATE_WORDS = {Gate.WHILE: "while", Gate.FROM: "from when", Gate.INSIDE: "where"}


def effect_disagreements(model: Model, residuals: Sequence[Residual]) -> Iterator[Disagreement]:
    """Disagreement of each effect of a model that does not act everywhere, in the coordinate in which it shows most."""
    for effect in added(model):
        if effect.gate.n_parameters and not isinstance(effect, ConstraintEffect):
            there = [residual for residual in residuals if residual.disagrees] or residuals
            told = [one for residual in there for one in _of(effect, model, residual)]
            if told:
                yield max(told, key=lambda one: one[0])[1]


def _of(effect: Effect, model: Model, residual: Residual) -> Iterator[tuple[float, Disagreement]]:
    """Disagreement in the log in which an effect acts for the longest time, with how far beyond noise it is there
    (squares)."""
    masks = [_mask(effect, balances, model) for balances in model.logs]
    balances, mask = max(zip(model.logs, masks, strict=True), key=lambda one: one[1].sum() * one[0].motion.step)
    motion, middle = balances.motion, residual.start + residual.duration / 2
    own = np.array([name == balances.name for name in residual.circumstances.names])[residual.circumstances.log]
    own &= (middle >= motion.time[0]) & (middle <= motion.time[-1])
    chosen = own & mask[np.clip(np.searchsorted(motion.time, middle), 0, len(mask) - 1)]
    if chosen.any():
        beyond = float(residual.beyond[chosen].sum())
        share = float(np.clip(beyond / max(residual.beyond.sum(), 1e-12), 0.0, 1.0))
        intervals, size = runs(motion.time[mask], motion.step), float(np.sqrt((residual.value[chosen] ** 2).mean()))
        span = f"t = {intervals[0][0]:.1f} to {intervals[-1][1]:.1f} s"
        text = f"{100 * share:.0f} % of the misfit lies {GATE_WORDS[effect.gate]} {effect.name} acts, {span}"
        told = Disagreement(intervals[0][0], intervals[-1][1], residual.coordinate, text, size, share, intervals)
        yield beyond, told


def _mask(effect: Effect, balances: Balances, model: Model) -> np.ndarray:
    """Whether (n,) an effect acts at each time of the motion."""
    time, values = balances.motion.time, effect.values
    if effect.gate is Gate.INSIDE:
        return touches(balances.motion.pose, values[:4], model.cart.wheel_set)
    end = values[0] + values[1] if effect.gate is Gate.WHILE else np.inf
    return np.asarray((time >= values[0]) & (time <= end))
