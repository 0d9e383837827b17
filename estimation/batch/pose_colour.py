"""Pose noise that remembers: an autoregression beside the white noise, as trackers and scan matchers make.

Taken for white, it passes for motion, and the acceleration that the smoother finds is mostly noise. What it is can be
read where no motion can be: wheels that roll keep the axle from going sideways, so sideways increments of the pose
are noise alone. Over a lag t their squares grow with `1 - exp(-t / time)`, those of a cart that does slip smoothly,
and those of white noise not at all; a fit of the three tells them apart. A cart on casters alone goes any way, but no
motion makes third differences that grow as slowly: their squares go with t³ where velocities jump, and with higher
powers else.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import final

import numpy as np
from scipy.linalg import cholesky_banded, solve_banded

from cartgrasp.frames import Array

from ..variogram import FEWEST, LONGEST, Variogram, autoregression, in_third_differences
from .block_tridiagonal import BlockTridiagonal

TIMES = np.geomspace(0.008, 0.3, 18)
"""s: correlation times that are tried."""
SLIPS = np.array([0.1, 0.2, 0.4, 0.8])
"""s: for as long as this a cart that slips keeps its sideways speed."""
MISFIT = 0.05
"""By how much smooth motion and white noise alone fit worse, in squares of the relative misfit summed over lags."""
MISFIT_OF_SHAPE = 0.1
"""The same of white noise and motion alone, to third differences."""
LEAST_WHITE = 0.3
"""Of what was read off as white noise."""


@final
@dataclass(frozen=True)
class PoseColour:
    """Standard deviations of the slow noise of x and y (m) and of the heading (rad), and its correlation time (s)."""

    position: float
    heading: float
    time: float

    @property
    def std(self) -> Array:
        return np.array([self.position, self.position, self.heading])

    def times(self, shares: Array) -> PoseColour:
        """As many times as large (3,)."""
        position, heading, time = (np.array([self.position, self.heading, self.time]) * shares).tolist()
        return PoseColour(position, heading, time)

    def white(self, std: Array, step: float) -> Array:
        """White noise (k,) where third differences show as much as white noise of `std` (k,) would."""
        share = in_third_differences(float(np.exp(-step / self.time)))
        own = np.array([self.position, self.heading])
        return np.asarray(np.sqrt(np.maximum(std**2 - share * own**2, (LEAST_WHITE * std) ** 2)))


@final
@dataclass(frozen=True)
class SlowNoise:
    """Of poses at rows: `fade` (n - 1,) from one to the next, 0 where neighbours are not linked."""

    colour: PoseColour
    fade: Array

    @classmethod
    def of(cls, colour: PoseColour, steps: Array, linked: np.ndarray) -> SlowNoise:
        return cls(colour, np.where(linked, np.exp(-steps / colour.time), 0.0))

    @cached_property
    def precision(self) -> tuple[Array, Array]:
        """Of noise of unit variance: on the diagonal (n,), and below it (n - 1,)."""
        fresh = 1 / (1 - self.fade**2)
        diagonal = np.append(1.0, fresh)
        diagonal[:-1] += fresh * self.fade**2
        return diagonal, -fresh * self.fade

    def add_to(self, information: BlockTridiagonal, gradient: Array, noise: Array) -> float:
        """What is known of the noise (n, 3) beforehand, to the last three of each state's; the cost of it."""
        diagonal, below = (each[:, None] / self.colour.std**2 for each in self.precision)
        last = range(gradient.shape[1] - 3, gradient.shape[1])
        information.diagonal[:, last, last] += diagonal
        information.below[:, last, last] += below
        pull = diagonal * noise
        pull[1:] += below * noise[:-1]
        pull[:-1] += below * noise[1:]
        gradient[:, -3:] -= pull
        return float((noise * pull).sum())

    @property
    def log_determinant(self) -> float:
        """Of the precision."""
        n = len(self.fade) + 1
        return float(-3 * np.log(1 - self.fade**2).sum() - 2 * n * np.log(self.colour.std).sum())

    def drawn(self, generator: np.random.Generator) -> Array:
        """Noise (n, 3)."""
        diagonal, below = self.precision
        root = cholesky_banded(np.stack([diagonal, np.append(below, 0.0)]), lower=True)
        upper = np.stack([np.append(0.0, root[1, :-1]), root[0]])
        white = generator.standard_normal((len(diagonal), 3))
        return np.asarray(solve_banded((0, 1), upper, white) * self.colour.std)


def colour_of_free_poses(time: Array, position: Array, lever: float) -> PoseColour | None:
    """By the third differences of x and y (m, 2) of something that may go any way; as `colour_of_poses`."""
    shown = Variogram.of_third_differences(time, position) if len(time) > FEWEST else None
    if shown is None:
        return None
    fits = [(*shown.beside_motion(one), one) for one in TIMES]
    shares, misfit, fade = min(fits, key=lambda fit: fit[1])
    if shown.beside_motion(None)[1] - misfit < MISFIT_OF_SHAPE:
        return None
    slow = float(shares[1] ** 0.5)
    return PoseColour(slow, lever * slow, float(fade))


def colour_of_poses(time: Array, pose: Array, axle: float, lever: float) -> PoseColour | None:
    """By how the axle goes sideways, `axle` (m) before the pose (m, 3) of something that rolls along its heading; the
    heading's noise is taken to be like that of x and y, but for `lever` (rad/m). None where white noise and smooth slip
    explain it as well, at all rows or at those where the cart hardly goes in a curve: noise is there as well, slip is
    not."""
    if len(time) < FEWEST:
        return None
    across, bend = gone_across(pose, axle), _bend(time, pose)
    whole, calm = (Variogram.of(time, across, bend <= most) for most in (np.inf, np.median(bend)))
    if whole is None or calm is None:
        return None
    (slow, fade), gain = _explained(whole)
    return PoseColour(slow, lever * slow, fade) if min(gain, _explained(calm)[1]) > MISFIT else None


def gone_across(pose: Array, axle: float) -> Array:
    """How far (m,) to the left the axle has gone, `axle` (m) before the pose (m, 3) of something that rolls along its
    heading."""
    middle, step = (pose[:-1, 2] + pose[1:, 2]) / 2, np.diff(pose, axis=0)
    across = -np.sin(middle) * step[:, 0] + np.cos(middle) * step[:, 1] + axle * step[:, 2]
    return np.append(0.0, np.cumsum(across))


def _bend(time: Array, pose: Array) -> Array:
    """How far poses go, times how far they turn, within the longest lag from each of them."""
    after = np.minimum(np.searchsorted(time, time + LONGEST), len(time) - 1)
    moved = pose[after] - pose
    return np.asarray(np.abs(moved[:, 2]) * np.hypot(moved[:, 0], moved[:, 1]))


def _explained(grown: Variogram) -> tuple[tuple[float, float], float]:
    """The likeliest slow noise (m) and its correlation time (s), and by how much worse smooth slip explains it."""
    smooth = min(grown.shares(_slipped(grown.lag / one))[1] for one in SLIPS)
    fits = [(*grown.shares(autoregression(grown.lag, one)), one) for one in TIMES]
    shares, misfit, time = min(fits, key=lambda fit: fit[1])
    return (float(shares[1] ** 0.5), float(time)), smooth - misfit


def _slipped(after: Array) -> Array:
    """Squares of what is covered at a speed that fades, over its correlation times."""
    return np.asarray(after - 1 + np.exp(-after))
