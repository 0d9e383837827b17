"""What the world may add to an effect of ours that it has in another form.

A name stands for many forms: friction of bristles or of a step, drag at the origin or at the CoM, a carpet's ramp. What
a form leaves looks like a small second effect. So from one manoeuvre to the next the size of an added effect is free by
a share, and the line along which its force acts by a lever; both are unknowns beside the parameters. Near rest so is
its whole moment: a caster drags along its own heading, and takes a trail's length to find that of its pivot's velocity.
So is how sharply the smoothed motion bends, which looks like a small delay, or like something that swings and is damped
at once. What passes has one share, whatever the cart does meanwhile.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cartgrasp.effects import Effect, ForceEffect
from cartgrasp.frames import Array

from ..batch.linearisation import Linearisation
from ..batch.wrench_regression import WrenchRegression
from .manoeuvres import manoeuvres, settled

SHARE = 0.1
"""Of its size: how far an effect may be from ours in one manoeuvre."""
LEVER = 0.05
"""m: how far beside our line of action its force may act there."""
BLUR = 0.5
"""Times second differences of wrenches, those of a motion smoothed over a row more or less."""
TRACE = 1e-9
KINDS = 3
SIZES = np.array([0.0, 0.1, 0.25, 0.5, 1.0, 2.0, 4.0])
"""Times SHARE or LEVER: what a family of forms may come to on some logs."""
ROUNDS = 2


@dataclass(frozen=True)
class Forms:
    """Of a log: what other forms, each of one deviation, add to its rows (m, f, k), and of which family each is (k,):
    one effect's shares, its levers, its moments near rest, or the smoothing."""

    columns: Array
    family: np.ndarray

    @classmethod
    def of(cls, regression: WrenchRegression, line: Linearisation, traces: Sequence[tuple[Effect, Array]]) -> Forms:
        """Of effects, each with what it adds to the rows (m, f)."""
        turns = not regression.cart.constraints.no_rotation
        rows = line.nodes // regression.size
        number = manoeuvres(regression.motion, turns)[rows]
        each, swings = number[:, None] == np.unique(number), ~settled(regression)[rows]
        parts, family = [BLUR * regression.bends()[..., None]], [-1]
        for k, (effect, trace) in enumerate(traces):
            if np.abs(trace).max(initial=0.0) < TRACE:
                continue
            kinds = [SHARE * trace]
            if turns and isinstance(effect, ForceEffect):
                kinds += [_moment(trace, LEVER * trace[:, 0]), _moment(trace, swings * trace[:, -1])]
            inside = (
                np.ones((len(rows), 1)) if effect.gate.ends else each[:, each[np.abs(trace).any(axis=1)].any(axis=0)]
            )
            for i, kind in enumerate(kinds):
                parts.append(kind[:, :, None] * inside[:, None, :])
                family += inside.shape[1] * [KINDS * k + i]
        return cls(np.concatenate(parts, axis=2), np.array(family, dtype=int))

    def taken(self, line: Linearisation) -> float:
        """Of the residual's chi-squared: what they take away, less what they cost for all that they might have been, so
        that the rest is -2 log of a likelihood."""
        taught, pull = line.taught(self.columns)
        information = taught + np.eye(len(pull))
        return float(pull @ np.linalg.solve(information, pull)) - float(np.linalg.slogdet(information)[1])


def _moment(trace: Array, moment: Array) -> Array:
    """Alone, on rows like those of a trace (m, f)."""
    found = np.zeros_like(trace)
    found[:, -1] = moment
    return found


def form_sizes(information: Array, pull: Array, family: np.ndarray) -> Array:
    """How large forms (k,) are on some logs, root mean square, from the information (k, k) and the pull (k,) on them
    beside a base that is taken out: each family's size is averaged over a grid by the evidence for it."""
    size = np.ones(len(pull))
    for _ in range(ROUNDS):
        for one in np.unique(family):
            own, logs = family == one, []
            for tried in SIZES:
                size[own] = tried
                matrix = np.eye(len(pull)) + size[:, None] * information * size
                drawn = size * pull
                logs.append(0.5 * float(drawn @ np.linalg.solve(matrix, drawn)) - 0.5 * np.linalg.slogdet(matrix)[1])
            weight = np.exp(np.array(logs) - max(logs))
            size[own] = np.sqrt(weight @ SIZES**2 / weight.sum())
    return size
