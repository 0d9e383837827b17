"""How much more probable a log is with an effect than without: Bayes factors of linear Gaussian models.

With the base's parameters taken out (their Schur complement), an effect's amplitudes have information S and pull g.
Against their prior of covariance Σ, the log of the factor is `(gᵀ (S + Σ⁻¹)⁻¹ g - log det(1 + Σ S)) / 2`. What can
have one sign only has half the prior, and twice the density; a grid of places, times and speeds shares one prior.
"""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass
from itertools import groupby

import numpy as np
from scipy.special import log_ndtr, logsumexp

from cartgrasp.effects import Effect
from cartgrasp.effects.effect import Gate
from cartgrasp.frames import Array

from .dictionary import BLOCK, Dictionary, Trial

LENGTHS = (1, 2, 3, 4, 6, 8, 12, 16, 24)
"""Blocks that something may act for."""
PARTS = 4
"""Of a log, each of which is left out once."""
FEWEST_BEFORE = 4
"""Blocks before a change from which on something acts, and after it."""


@dataclass(frozen=True)
class Finding:
    """An effect at its most probable setting, with the amplitudes' values; the log of its Bayes factor over all
    settings; half the chi-squared that the best setting takes away; which parameters the amplitudes are, their
    standard deviations before and after data; by how much of their size they change, at most, when a part of the log is
    left out, and from one part to another (`drift`; both 0 for what acts at a time or a place)."""

    effect: Effect
    log_factor: float
    gain: float
    amplitudes: np.ndarray
    prior_std: Array
    std: Array
    change: float = 0.0
    drift: float = 0.0

    @property
    def occam(self) -> float:
        """What the factor loses for all that the effect might have been."""
        return self.log_factor - self.gain


@dataclass(frozen=True)
class Base:
    """What is believed of the base's parameters where the dictionary was made: information (p, p), and the pull (p,)
    back to what was believed first. `excess` is how many times too small the noise variance is believed."""

    information: Array
    pull: Array
    excess: float = 1.0


def findings(dictionary: Dictionary, base: Base) -> list[Finding]:
    """One for each effect (and arm), the most probable first."""
    reduce = _Reduction(dictionary, base)
    found = []
    by_key = groupby(dictionary.trials, key=lambda trial: (trial.effect.name, trial.effect.label))
    for _, group in by_key:
        found.append(_best(reduce, list(group)))
    return sorted(found, key=lambda one: -one.log_factor)


def _best(reduce: _Reduction, trials: Sequence[Trial]) -> Finding:
    settings, factors, gains, means, stds = [], [], [], [], []
    if trials[0].effect.gate is Gate.INSIDE:
        families = [(trials[0], _inside(reduce, trials))]
    else:
        families = [(trial, _SETTINGS[trial.effect.gate](reduce, trial)) for trial in trials]
    for trial, (gates, sums) in families:
        factor, gain, mean, std = _scored(trial, sums)
        settings += [(trial.effect, gate) for gate in gates]
        factors.append(factor)
        gains.append(gain)
        means.append(mean)
        stds.append(std)
    factor, mean, std = np.concatenate(factors), np.concatenate(means), np.concatenate(stds)
    best = int(np.argmax(factor))
    amplitudes = trials[0].amplitudes
    effect, gate = settings[best]
    values = effect.values.copy()
    values[: len(gate)] = gate
    values[amplitudes] += mean[best]
    total = float(logsumexp(factor) - np.log(len(factor)))
    most = float(np.concatenate(gains)[best])
    change = drift = 0.0
    if effect.gate is Gate.ALWAYS:
        chosen = next(trial for trial in trials if trial.effect is effect)
        change, drift = _change(reduce, chosen, mean[best]), _drift(reduce, chosen, mean[best])
    return Finding(effect.with_values(values), total, most, amplitudes, trials[0].std, std[best], change, drift)


def _change(reduce: _Reduction, trial: Trial, whole: Array) -> float:
    """The largest, in the metric of the amplitudes' information, over parts of the log that are left out; what noise
    alone may change is taken off."""
    own = reduce.gram[:, trial.columns[:, None], reduce.rows(trial.columns)]
    prior = np.diag(trial.std**-2.0)
    total = own.sum(axis=0)
    information = reduce.of(total)[0] + prior
    size, found = float(whole @ information @ whole), 0.0
    for left_out in np.array_split(np.arange(len(own)), PARTS):
        left, pull = reduce.without(left_out).of(total - own[left_out].sum(axis=0))
        spread = np.linalg.inv(left + prior)
        other = spread @ pull - whole
        noise = float(np.trace(spread @ information)) - len(whole)
        found = max(found, float(other @ information @ other) - 9 * max(noise, 0.0))
    return float(np.sqrt(max(found, 0.0) / max(size, 1e-300)))


def _drift(reduce: _Reduction, trial: Trial, whole: Array) -> float:
    """The same, of each part's own size beside those of the others, with one base for all; of the parts' mean, as much
    is believed before data as of the whole."""
    own = reduce.gram[:, trial.columns[:, None], reduce.rows(trial.columns)]
    k, prior = len(whole), np.diag(trial.std**-2.0)
    metric = reduce.of(own.sum(axis=0))[0] + prior
    sums = np.array([own[part].sum(axis=0) for part in np.array_split(np.arange(len(own)), PARTS)])
    apart = np.zeros((PARTS, k, sums.shape[2] + (PARTS - 1) * k))
    p = reduce.dictionary.n_base
    apart[:, :, :p], apart[:, :, -1] = sums[:, :, :p], sums[:, :, -1]
    for i in range(PARTS):
        apart[i, :, p + i * k : p + (i + 1) * k] = sums[i, :, p:-1]
    information, pull = reduce.of(apart.reshape(PARTS * k, -1))
    believed = np.eye(PARTS) - (1 / PARTS - 1 / PARTS**2)
    spread = np.linalg.inv(information + np.kron(believed, prior))
    other = (spread @ pull).reshape(PARTS, k) - whole
    found = 0.0
    for i in range(PARTS):
        noise = float(np.trace(spread[i * k : (i + 1) * k, i * k : (i + 1) * k] @ metric))
        found = max(found, float(other[i] @ metric @ other[i]) - 9 * noise)
    return float(np.sqrt(max(found, 0.0) / max(float(whole @ metric @ whole), 1e-300)))


def _scored(trial: Trial, sums: tuple[Array, Array]) -> tuple[Array, Array, Array, Array]:
    """Logs of factors and gains (s,), means and standard deviations (s, k)."""
    information, pull = sums
    scaled = trial.std[:, None] * information * trial.std
    pull = trial.std * pull
    values, axes = np.linalg.eigh(scaled)
    covariance = axes / (1 + np.maximum(values, 0.0))[..., None, :] @ np.swapaxes(axes, -1, -2)
    mean = (covariance @ pull[..., None])[..., 0]
    std = np.sqrt(np.diagonal(covariance, axis1=-2, axis2=-1))
    gain = 0.5 * (pull * mean).sum(axis=-1)
    factor = gain + 0.5 * np.linalg.slogdet(covariance)[1]
    parameters = [trial.effect.parameters[i] for i in trial.amplitudes]
    for i, parameter in enumerate(parameters):
        if parameter.lower == parameter.absent:
            factor = factor + np.log(2) + log_ndtr(mean[..., i] / std[..., i])
    return factor, gain, mean * trial.std, std * trial.std


class _Reduction:
    """Information and pull of amplitudes when the base's parameters are taken out."""

    def __init__(self, dictionary: Dictionary, base: Base) -> None:
        self.dictionary, self.base = dictionary, base
        self.gram, self.places = dictionary.gram / base.excess, dictionary.places / base.excess
        self._whole = self.gram[:, dictionary.base].sum(axis=0)
        self._take_out(self._whole)

    def _take_out(self, whole: Array) -> None:
        """The base, whose rows of the sums are `whole`."""
        self._inverse = np.linalg.inv(whole[:, self.dictionary.base] + self.base.information)
        self._pull = whole[:, -1] + self.base.pull

    def without(self, blocks: np.ndarray) -> _Reduction:
        """As if these blocks had not been recorded."""
        other = copy(self)
        other._take_out(self._whole - self.gram[blocks, self.dictionary.base].sum(axis=0))
        return other

    def of(self, gram: Array) -> tuple[Array, Array]:
        """From sums (..., k, p + k + 1): products with the base, with themselves, with the residual."""
        p = self.dictionary.n_base
        to_base, own, pull = gram[..., :p], gram[..., p:-1], gram[..., -1]
        through = to_base @ self._inverse
        return own - through @ np.swapaxes(to_base, -1, -2), pull - through @ self._pull

    def rows(self, columns: np.ndarray) -> np.ndarray:
        return np.asarray(np.r_[np.arange(self.dictionary.n_base), columns, self.gram.shape[1] - 1])


Settings = tuple[Array, tuple[Array, Array]]
"""Values of the gate's parameters (s, g), and sums."""


def _always(reduce: _Reduction, trial: Trial) -> Settings:
    whole = reduce.gram[:, trial.columns[:, None], reduce.rows(trial.columns)].sum(axis=0)
    information, pull = reduce.of(whole)
    return np.zeros((1, 0)), (information[None], pull[None])


def _from(reduce: _Reduction, trial: Trial) -> Settings:
    sums = _running(reduce, trial)
    n = len(sums) - 1
    first = np.arange(min(FEWEST_BEFORE, n - 1), max(n - FEWEST_BEFORE, min(FEWEST_BEFORE, n - 1) + 1))
    return reduce.dictionary.start[first][:, None], reduce.of(sums[-1] - sums[first])


def _while(reduce: _Reduction, trial: Trial) -> Settings:
    sums = _running(reduce, trial)
    n, start = len(sums) - 1, reduce.dictionary.start
    log = reduce.dictionary.log
    pairs = [(i, i + k) for k in LENGTHS for i in range(n - k + 1) if log[i] == log[i + k - 1]]
    first, last = np.array(pairs).T
    gates = np.column_stack([start[first], start[last - 1] + BLOCK - start[first]])
    return gates, reduce.of(sums[last] - sums[first])


def _running(reduce: _Reduction, trial: Trial) -> Array:
    own = reduce.gram[:, trial.columns[:, None], reduce.rows(trial.columns)]
    return np.concatenate([np.zeros((1, *own.shape[1:])), np.cumsum(own, axis=0)])


def _inside(reduce: _Reduction, trials: Sequence[Trial]) -> Settings:
    grid, p = reduce.dictionary.grid, reduce.dictionary.n_base
    nx, ny = len(grid.x) - 1, len(grid.y) - 1
    cells = np.array([trial.cell for trial in trials])
    columns = np.concatenate([trial.columns for trial in trials])
    own = np.zeros((nx, ny, nx, ny))
    i, j = cells.T
    own[i[:, None], j[:, None], i, j] = reduce.places[np.ix_(columns, p + columns)]
    other = np.zeros((nx, ny, p + 1))
    other[i, j] = np.delete(reduce.places[columns], np.s_[p:-1], axis=1)
    boxes = np.array(
        [(a, b, c, d) for a in range(nx) for b in range(a + 1, nx + 1) for c in range(ny) for d in range(c + 1, ny + 1)]
    )
    a, b, c, d = boxes.T
    other = _corner_sums(other)
    linear = other[b, d] - other[a, d] - other[b, c] + other[a, c]
    both = _corner_sums(_corner_sums(own).transpose(2, 3, 0, 1))
    square = sum(
        s * t * both[x, y, u, v]
        for x, y, s in ((b, d, 1), (a, d, -1), (b, c, -1), (a, c, 1))
        for u, v, t in ((b, d, 1), (a, d, -1), (b, c, -1), (a, c, 1))
    )
    gates = np.column_stack([grid.x[a], grid.x[b], grid.y[c], grid.y[d]])
    gram = np.concatenate([linear[:, :p], square[:, None], linear[:, p:]], axis=1)[:, None, :]
    return gates, reduce.of(gram)


def _corner_sums(cells: Array) -> Array:
    """Sums over all cells before a corner, along the first two axes."""
    sums = np.zeros((cells.shape[0] + 1, cells.shape[1] + 1, *cells.shape[2:]))
    sums[1:, 1:] = cells.cumsum(axis=0).cumsum(axis=1)
    return sums


_SETTINGS = {Gate.ALWAYS: _always, Gate.FROM: _from, Gate.WHILE: _while}
