"""What the forms of effects that were found may leave: as much of each as its form may be wrong by, where a motion goes
through something that the form does not know.

A form that is not quite right leaves a residual in which other names are found. Here the rivals of those names are the
same effects with another size at another time, speed, turn, heading, place or way since a reversal, at another lever,
or a little late, as nuisances of declared size (model discrepancy of Kennedy and O'Hagan, 2001). What a candidate
gains beside them is its own.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np

from cartgrasp.effects import Effect
from cartgrasp.effects.effect import Gate
from cartgrasp.frames import Array

from ...standstill import HALF_TRACK
from ...weak_form.balances import Balances
from ...weak_form.motion import Motion
from ...weak_form.score import Score
from ...weak_form.wheel_tracks import touches
from .covariates import Covariates
from .laws import Law, splines
from .model import Model

FORM_MODE_STD = 0.2
"""Standard deviation of an effect's size, as a share of it, by each of the modes."""
FORM_DELAY = 0.1
"""Time (s) by which an effect may come late whose form is wrong by its whole size."""
FORM_SPEED_SCALES, FORM_DISTANCE_SCALES = (0.05, 0.15), (0.05, 0.3, 1.0)
"""Speeds (m/s) and distances since a reversal (m): scales on which forms set in."""
MAX_FORM_MODES = 40
"""Most modes of all effects together, the largest: more would only cost memory."""


class FormError:
    """What the forms of a model's effects and laws may leave, of those that its first guess does not have."""

    def __init__(self, model: Model) -> None:
        self.model = model
        whole, known = model.cart_with_laws, {effect.key for effect in model.guess.effects}
        found = [effect for effect in whole.effects if effect.key not in known]
        less = [whole.without_effect(effect.key) for effect in found]
        self._gates = [effect.gate for effect in found]
        taken = [balances.taken(whole) for balances in model.logs]
        self._made = [[own - b.taken(one) for one in less] for own, b in zip(taken, model.logs, strict=True)]

    def scores(self, model: Model, candidate: Effect | Law) -> tuple[Score, Score]:
        """Scores of this model and of one with a candidate, both beside what forms may leave."""
        if isinstance(candidate, Law) or candidate.gate is Gate.ALWAYS:
            return self.alone, _beside(model, self._modes)
        columns = np.concatenate([self._modes, self._while(candidate)], axis=2)
        return _beside(self.model, columns), _beside(model, columns)

    @cached_property
    def alone(self) -> Score:
        """Score of this model beside what forms may leave."""
        return _beside(self.model, self._modes)

    def _while(self, candidate: Effect) -> Array:
        """Whitened columns (k, c, e) of effects as long as a candidate acts."""
        found = []
        for balances, made in zip(self.model.logs, self._made, strict=True):
            acts = _acting(candidate, balances, self.model)
            found.append(balances.integrated(np.stack([acts[:, None] * one for one in made], axis=2)))
        return FORM_MODE_STD * self.model.whitened(found)

    @cached_property
    def _modes(self) -> Array:
        """Whitened columns (k, c, q), each as large as it may be: the strongest of all combinations."""
        turn = self.model.cart.constraints.n_free - 1
        logs = zip(self.model.logs, self._made, strict=True)
        found = self.model.whitened([_modulated(balances, made, self._gates, turn) for balances, made in logs])
        flat = (found / self.model.score.scale[:, None]).reshape(-1, found.shape[2])
        _, along = np.linalg.eigh(flat.T @ flat)
        return np.asarray(FORM_MODE_STD * found @ along[:, -MAX_FORM_MODES:])


def _beside(model: Model, columns: Array) -> Score:
    """Score with whitened columns (k, c, q) more, each as large as it may be."""
    return model.with_columns(columns, np.ones(columns.shape[2]))


def _modulated(balances: Balances, made: list[Array], gates: list[Gate], turn: int) -> Array:
    """Raw columns (k, c, q) of a log: what effects make (n, c) times modes, late, and as a moment about a lever. The
    moment is in the balance `turn`, if that is another than the first."""
    by_gate = {gate: modes_of(balances.motion, gate) for gate in set(gates)}
    late = [np.gradient(one, balances.motion.step, axis=0) * FORM_DELAY for one in made]

    def along(part: slice) -> Array:
        found = []
        for one, slope, gate in zip(made, late, gates, strict=True):
            modes = by_gate[gate]
            found += [one[part, :, None] * modes[part, None], slope[part, :, None]]
            if turn:
                beside = np.zeros((len(one[part]), one.shape[1], modes.shape[1]))
                beside[:, turn] = HALF_TRACK * one[part, :1] * modes[part]
                found.append(beside)
        return np.concatenate(found, axis=2)

    return balances.integrals.by_parts(along)


def modes_of(motion: Motion, gate: Gate = Gate.ALWAYS) -> Array:
    """What an effect's size may change with, along a motion (n, m): each about one where it is largest. Not with the
    way it rolls, which makes another effect of a drag; nor with time or place where a gate says when or where."""
    course = Covariates.along(motion)
    speed, turning = (np.asarray(one / max(np.abs(one).max(), 1e-3)) for one in (np.abs(course.speed), course.yaw_rate))
    place = course.place - course.place.mean(axis=0)
    x, y = (place / np.maximum(np.abs(place).max(axis=0), 0.1)).T
    found = [
        *(() if gate.passes else splines(course.time / max(course.time[-1], motion.step))),
        speed,
        speed**2,
        *(np.exp(-np.abs(course.speed) / scale) for scale in FORM_SPEED_SCALES),
        turning,
        np.abs(turning),
        *(np.exp(-course.since_reversal / scale) for scale in FORM_DISTANCE_SCALES),
        *(() if gate is Gate.INSIDE else (x, y, x**2, x * y, y**2)),
        *(wave(k * course.heading) for k in (1, 2) for wave in (np.cos, np.sin)),
    ]
    return np.stack(found, axis=1)


def _acting(effect: Effect, balances: Balances, model: Model) -> Array:
    """Whether an effect's gate is open (n,)."""
    time = balances.motion.time
    if effect.gate is Gate.INSIDE:
        return touches(balances.motion.pose, effect.values[:4], model.cart.wheel_set).astype(float)
    start = effect.values[0]
    end = np.inf if effect.gate is Gate.FROM else start + effect.values[1]
    return np.asarray((time > start) & (time < end), dtype=float)
