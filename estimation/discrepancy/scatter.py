"""Residual wrenches in weak form: their means over stretches, with what is known of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cartgrasp.frames import Array

from ..batch.linearisation import Linearisation
from ..batch.wrench_regression import WrenchRegression

SCATTER_BLOCK, EXCESS_BLOCK = 0.5, 0.2
"""s."""
LONG = 1.0
APART = 4
"""Stretches: noise does not reach so far."""
SLOWEST, FASTEST = 0.4, 2.0
"""Hz: between which noise is looked for."""
LEAST_KNOWN = 0.01
"""Of what a log's stretches tell in the mean: one that tells less, as across a jolt, is left out. Its mean is any
number, and what it tells may round to less than nothing."""

Linearised = Sequence[tuple[WrenchRegression, Linearisation, float]]
"""Logs, each around the parameters of one cart, and their delays."""


@dataclass(frozen=True)
class Scatter:
    """Residual wrenches in weak form: of each stretch the mean (b, f) along the free directions, its information
    (b, f, f), when it begins, and of which log it is; how many times too small the noise variance is believed to be."""

    mean: Array
    information: Array
    start: Array
    log: np.ndarray
    excess: float

    @classmethod
    def of(cls, linearised: Linearised, excess: float) -> Scatter:
        return cls(*_means(linearised, SCATTER_BLOCK), excess)

    @property
    def middle(self) -> Array:
        """Of each stretch (b,), s."""
        return self.start + SCATTER_BLOCK / 2

    @property
    def std(self) -> Array:
        """Of each mean (b, f), whatever the other directions' are."""
        return np.sqrt(self.excess * np.diagonal(np.linalg.inv(self.information), axis1=1, axis2=2))

    @property
    def misfit(self) -> Array:
        """Of each stretch (b,), chi-squared with f degrees of freedom where the model is right."""
        return np.asarray(np.einsum("bi,bij,bj->b", self.mean, self.information, self.mean))


def _means(linearised: Linearised, duration: float) -> tuple[Array, Array, Array, np.ndarray]:
    """A constant on one stretch is whitened beside those on stretches that noise does not reach from there."""
    means, informations, starts, logs = [], [], [], []
    for k, (_, line, _) in enumerate(linearised):
        f = line.residual.shape[1]
        number = ((line.time - line.time[0]) // duration).astype(int)
        group = number % APART
        ones = (group[:, None] == np.arange(APART))[:, None, :, None] * np.eye(f)[None, :, None, :]
        sides = np.concatenate([ones.reshape(len(number), f, APART * f), line.residual[..., None]], axis=2)
        sums = np.add.reduceat(line.whitened(sides), line.ends(duration)[:-1], axis=0)
        begins = np.unique(number)
        own = sums[..., :-1].reshape(len(begins), f, APART, f)[np.arange(len(begins)), :, begins % APART]
        information = (own + np.swapaxes(own, 1, 2)) / 2
        known = _known(information)
        information = information[known]
        means.append(np.linalg.solve(information, sums[known, :, -1:])[..., 0])
        informations.append(information)
        starts.append(begins[known] * duration + line.time[0])
        logs.append(np.full(len(information), k))
    return (np.concatenate(means), np.concatenate(informations), np.concatenate(starts), np.concatenate(logs))


def _known(information: Array) -> np.ndarray:
    """Which stretches (b,) tell, along every direction, enough beside the others."""
    scale = np.linalg.inv(np.linalg.cholesky(information.mean(axis=0)))
    return np.asarray(np.linalg.eigvalsh(scale @ information @ scale.T)[:, 0] > LEAST_KNOWN)


def noise_excess(linearised: Linearised) -> float:
    """How many times too small the noise variance of long means is believed to be, 1 or more: the median of a spectrum
    between slow misfits and single samples. Coloured noise fills it; what swings at one frequency does not."""
    mean, _, start, log = _means(linearised, EXCESS_BLOCK)
    long = np.median(_means(linearised, LONG)[1], axis=0) * EXCESS_BLOCK / LONG
    standard = mean @ np.linalg.cholesky(long)
    found = [np.zeros(0)]
    for k in np.unique(log):
        own = log == k
        place = np.round((start[own] - start[own][0]) / EXCESS_BLOCK).astype(int)
        row = np.zeros((place[-1] + 1, mean.shape[1]))
        row[place] = standard[own]
        power = np.abs(np.fft.rfft(row, axis=0)) ** 2 / len(place)
        frequency = np.fft.rfftfreq(len(row), EXCESS_BLOCK)
        found.append(power[(frequency > SLOWEST) & (frequency < FASTEST)].ravel())
    power = np.concatenate(found)
    return max(1.0, float(np.median(power)) / np.log(2)) if len(power) else 1.0
