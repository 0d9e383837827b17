"""Every trial's trace in a log: the slopes of the reduced wrench by its amplitudes, whitened, and summed by blocks.

What an amplitude adds is linear near absence, so that one linearisation of a cart with every trial on it holds all.
Sums of products over blocks of time are then all that a comparison needs. An effect that acts for a while is worked out
as if it always acted, and its blocks are picked; one that acts in a place is worked out on the cells of a grid, over
all times.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from cartgrasp.effects import Effect, ForceEffect, SensorEffect
from cartgrasp.effects.effect import Gate
from cartgrasp.frames import Array, rotation_planar
from cartgrasp.model import CartModel

from ..batch.linearisation import Linearisation
from ..batch.wrench_regression import WrenchRegression

BLOCK = 0.25
"""s."""
CELL = 0.4
"""m."""
RIM = 0.05
"""m: so far outside of all wheels' tracks a grid ends."""
MOST_CELLS = 144
EVER = 1e12
"""s, m: as long, and as far, as no log goes, be its clock that of the world, which began in 1970."""
TRACE = 1e-9
"""Of a column's largest one: below it an amplitude leaves no trace."""


@dataclass(frozen=True)
class Trial:
    """An absent effect, its gate open, with the columns of its amplitudes; which of its parameters they are; their
    standard deviations before any data. `cell` counts along x and y where the gate is a place, and columns are those of
    places then."""

    effect: Effect
    columns: np.ndarray
    amplitudes: np.ndarray
    std: Array
    cell: tuple[int, int] | None = None


@dataclass(frozen=True)
class Grid:
    """Edges of cells along x and y, m in {s}."""

    x: Array
    y: Array

    @classmethod
    def over(cls, points: Array) -> Grid:
        low, high = points.min(axis=0) - RIM, points.max(axis=0) + RIM
        size = max(CELL, float(np.sqrt(np.prod(np.maximum(high - low, CELL)) / MOST_CELLS)))
        counts = np.maximum(1, np.ceil((high - low) / size)).astype(int)
        return cls(np.linspace(low[0], high[0], counts[0] + 1), np.linspace(low[1], high[1], counts[1] + 1))


@dataclass(frozen=True)
class Dictionary:
    """Sums over blocks (b,), which begin at `start` of log `log`, of products of columns: the base's (p) first, then
    the trials', and the residual last. `places` (c, p + c + 1) are those of cells' columns, over all blocks, with the
    base's, their own, and the residual."""

    trials: tuple[Trial, ...]
    grid: Grid
    gram: Array
    places: Array
    start: Array
    log: np.ndarray
    n_base: int

    @property
    def base(self) -> slice:
        return slice(0, self.n_base)


def build_dictionary(
    linearised: Sequence[tuple[WrenchRegression, Linearisation, float]],
    effects: Sequence[Effect],
    base: Sequence[Array],
) -> Dictionary:
    """Of logs, each with a linearisation of the same cart, its delay, and columns (m, f, b) of the base."""
    grid = Grid.over(np.concatenate([_tracks(regression) for regression, _, _ in linearised]))
    opened = [one for effect in effects for one in _opened(effect, grid)]
    slopes = [slopes_of(regression, [effect for effect, _ in opened], delay) for regression, _, delay in linearised]
    trials, chosen, at = [], list[tuple[int, np.ndarray]](), base[0].shape[2]
    cells = list[tuple[int, np.ndarray]]()
    for i, (effect, cell) in enumerate(opened):
        scale = np.max([np.abs(own[i]).max(axis=(0, 1), initial=0.0) for own in slopes], axis=0)
        typical = np.array([p.typical for p in effect.parameters])
        seen = np.flatnonzero((scale * typical > TRACE) & may_be_amplitudes(effect))
        if len(seen):
            first = at if cell is None else len(cells)
            trials.append(Trial(effect, np.arange(first, first + len(seen)), seen, 2 * typical[seen], cell))
            (chosen if cell is None else cells).append((i, seen))
            at += len(seen) if cell is None else 0
    grams, starts, logs = [], [], []
    places = np.zeros((len(cells), base[0].shape[2] + len(cells) + 1))
    for k, ((_, line, _), known, own) in enumerate(zip(linearised, base, slopes, strict=True)):
        timed, placed = (_columns(line, own, which) for which in (chosen, cells))
        sides = np.concatenate([known, timed, line.residual[..., None]], axis=2)
        gram = line.by_block(sides, line.whitened(sides), BLOCK)
        grams.append((gram + np.swapaxes(gram, 1, 2)) / 2)
        whitened = line.whitened(placed)
        parts = known, placed, line.residual[..., None]
        places += np.concatenate([np.tensordot(whitened, part, ((0, 1), (0, 1))) for part in parts], axis=1)
        starts.append(np.unique((line.time - line.time[0]) // BLOCK) * BLOCK + line.time[0])
        logs.append(np.full(len(gram), k))
    return Dictionary(
        tuple(trials),
        grid,
        np.concatenate(grams),
        places,
        np.concatenate(starts),
        np.concatenate(logs),
        base[0].shape[2],
    )


def _columns(line: Linearisation, slopes: Sequence[Array], which: Sequence[tuple[int, np.ndarray]]) -> Array:
    """Chosen slopes (m, f, k)."""
    return np.concatenate([np.empty((*line.residual.shape, 0)), *(slopes[i][..., seen] for i, seen in which)], axis=2)


def _tracks(regression: WrenchRegression) -> Array:
    """Where wheels, or a caster's pivot, have been (..., 2)."""
    pose, wheels = regression.motion.pose, regression.cart.wheel_set.wheels
    return np.concatenate([pose[:, :2] + rotation_planar(pose[:, 2]) @ [wheel.x, wheel.y] for wheel in wheels])


def amplitudes_of(effect: Effect) -> np.ndarray:
    """Indices of the parameters that are amplitudes."""
    return np.flatnonzero(may_be_amplitudes(effect))


def may_be_amplitudes(effect: Effect) -> np.ndarray:
    gated = np.arange(len(effect.parameters)) < effect.gate.n_parameters
    return np.asarray(~gated & np.array([not p.grid for p in effect.parameters]))


def _memory(effect: Effect, cart: CartModel) -> tuple[str, ...]:
    return effect.memory_names(cart.wheel_set) if isinstance(effect, ForceEffect) else ()


def _opened(effect: Effect, grid: Grid) -> list[tuple[Effect, tuple[int, int] | None]]:
    """With its gate as wide as can be, or once for each cell."""
    values = effect.values.copy()
    if effect.gate is Gate.FROM:
        values[0] = -EVER
    elif effect.gate is Gate.WHILE:
        values[:2] = -EVER, 2 * EVER
    elif effect.gate is Gate.INSIDE:
        cells = product(range(len(grid.x) - 1), range(len(grid.y) - 1))
        boxes = [((i, j), [grid.x[i], grid.x[i + 1], grid.y[j], grid.y[j + 1]]) for i, j in cells]
        return [(effect.with_values(np.r_[box, values[4:]]), cell) for cell, box in boxes]
    return [(effect.with_values(values), None)]


def slopes_of(regression: WrenchRegression, effects: Sequence[Effect], delay: float) -> list[Array]:
    """Slopes (m, f, q) by each effect's parameters, the effects of one kind on one cart."""
    cart, found = regression.cart, {}
    kinds = [isinstance(e, SensorEffect) + 2 * bool(_memory(e, cart)) for e in effects]
    for kind in sorted(set(kinds)):
        group = [i for i, own in enumerate(kinds) if own == kind]
        whole = replace(cart, effects=(*cart.effects, *(_apart(effects[i], i) for i in group)))
        by = regression.sensor_slopes(whole, delay) if kind == 1 else regression.force_slopes(whole, delay)
        first = len(cart.parameters)
        for i in group:
            found[i] = by[..., first : first + len(effects[i].parameters)]
            first += len(effects[i].parameters)
    return [found[i] for i in range(len(effects))]


def _apart(effect: Effect, i: int) -> Effect:
    return effect if isinstance(effect, SensorEffect) else replace(effect, label=f"trial {i}")
