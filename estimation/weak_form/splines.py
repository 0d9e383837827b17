"""Least-squares splines through samples of a signal and of its rate: banded, in time proportional to their number.

A fit is either `unbiased` (knots alone limit its band, so that accelerations are those that acted, with the sensors'
noise) or `smooth`: a penalty on third differences of the coefficients, as large as restricted maximum likelihood says
(Wood, Generalized Additive Models, 2nd ed., 6.2), takes out what is more likely noise.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.integrate import cumulative_trapezoid
from scipy.linalg.lapack import dpbsv
from scipy.optimize import minimize_scalar
from scipy.sparse import csr_array

from cartgrasp.frames import Array

SPLINE_DEGREE = 4
PENALTY_ORDER = 3
"""Order of the coefficients' differences that are penalised: what is left free is a constant acceleration."""
MIN_PENALTY_RATIO = 1e-9
"""Smallest penalty, in multiples of the data's weight: it bridges gaps."""
MIN_PENALTY_DECADES, MAX_PENALTY_DECADES = -9.0, 12.0
"""Decades of penalty between which the likelihood is searched: over the data's weight, and over that of values alone.
Rates leave a constant free, and of a penalty that is stiffer yet rounding hides what holds it."""
DIFFERENCE_ROUNDING = 1e-14
"""Relative rounding of squared third differences, which are up to 64 times a squared coefficient: what is smaller is
lost."""
OUTLIER_SIGMAS = 4.0
"""Standard deviations from which on a sample counts for less (Huber's weight would be 1.345; noise here is known)."""
N_REWEIGHTINGS = 3


@dataclass(frozen=True)
class Samples:
    """Values (n,) of a signal (`derivative` 0) or of its rate (1) at times (n,), with their standard deviation."""

    time: Array
    value: Array
    std: float
    derivative: int


@dataclass(frozen=True, eq=False)
class SplineBasis:
    """B-splines of degree 4 on knots `step` (s) apart from `start` on, `count` of them."""

    start: float
    step: float
    count: int

    @classmethod
    def over(cls, first: float, last: float, step: float) -> SplineBasis:
        return cls(first, step, max(int(np.ceil((last - first) / step)), 1) + SPLINE_DEGREE)

    def design(self, time: Array, derivative: int = 0) -> csr_array:
        """Design matrix (n, count) of the derivative at times (n,) inside the knots, by de Boor's recursion."""
        place = (time - self.start) / self.step
        first = np.clip(place.astype(np.intp), 0, self.count - SPLINE_DEGREE - 1)
        inside, value, nothing = place - first, np.ones((1, len(time))), np.zeros((1, len(time)))
        for degree in range(1, SPLINE_DEGREE + 1 - derivative):
            order = np.arange(degree + 1)[:, None]
            earlier, later = np.concatenate([nothing, value]), np.concatenate([value, nothing])
            value = ((inside + degree - order) * earlier + (1 + order - inside) * later) / degree
        for _ in range(derivative):
            value = np.diff(np.concatenate([nothing, value, nothing]), axis=0) / -self.step
        return _in_rows(first, value.T, self.count)

    def differences(self, order: int) -> csr_array:
        """Matrix (count - order, count) of the coefficients' differences of some order."""
        first = np.arange(self.count - order)
        return _in_rows(first, np.tile(np.diff(np.eye(order + 1), order, axis=0), (len(first), 1)), self.count)


class SplineFit:
    """Splines through samples of one signal on a basis, by their coefficients (count,): `unbiased` and `smooth`."""

    def __init__(self, basis: SplineBasis, samples: Sequence[Samples]) -> None:
        self.basis = basis
        self._designs = [basis.design(one.time, one.derivative) for one in samples]
        self._samples = tuple(samples)
        self._weigh([np.full(len(one.time), one.std**-2.0) for one in samples])
        self._roughness = self._penalised()
        self.smooth = self._robust()
        self.unbiased = self._solved(self._scale * MIN_PENALTY_RATIO, self._normal[1])

    def _penalised(self) -> Array:
        """Third differences; and where no sample is for k coefficients, the first, at k² of what rounding loses: in
        bends so long, third differences tell k**-6 of it."""
        basis, unseen = self.basis, self._normal[0][-1] == 0
        third, first, bridge = basis.differences(PENALTY_ORDER), basis.differences(1), unseen[1:] & unseen[:-1]
        weight = DIFFERENCE_ROUNDING * float(bridge.sum()) ** 2
        return _squares(third, np.ones(third.shape[0])) + _squares(first, weight * bridge)

    @cached_property
    def _scale(self) -> float:
        """The data's weight on one coefficient."""
        return float(np.mean(self._normal[0][-1]))

    def smooth_std(self, time: float, derivative: int = 0) -> float:
        """Standard deviation of the smooth fit at a time, if its penalty is that of the truth (a Bayesian credible
        one)."""
        matrix = self._normal[0] + self._penalty * self._roughness
        point = self.basis.design(np.array([time]), derivative).toarray()[0]
        return float(np.sqrt(point @ _by_cholesky(matrix, point)[0]))

    def beside(self, time: Array, known: tuple[Array, Array]) -> tuple[Array, float]:
        """Smooth coefficients of what the samples have beside what is `known` of the signal and its rate (n,) at times
        (n,), and the penalty. Weights of samples stay."""
        right = self._normal[1] - self._right([_at(one, time, known) for one in self._samples])
        penalty = self._likely_penalty(right)
        return self._solved(penalty, right), penalty

    def noise_beside(
        self, time: Array, known: tuple[Array, Array], penalty: float, generator: np.random.Generator
    ) -> Array:
        """What `beside` makes, with that penalty, of the samples' noise and of errors of what is known."""
        errors = [one.std * generator.standard_normal(len(one.time)) - _at(one, time, known) for one in self._samples]
        return self._solved(penalty, self._right(errors))

    def _weigh(self, weights: list[Array]) -> None:
        """Takes weights of samples, and works out the normal equations: a matrix in banded form, and its right side."""
        squares = [_squares(*one) for one in zip(self._designs, weights, strict=True)]
        of_values = (part for part, one in zip(squares, self._samples, strict=True) if one.derivative == 0)
        self._weight_of_values = sum(float(part[-1].mean()) for part in of_values)  # on one coefficient
        matrix = np.sum(squares, axis=0)
        place = np.linspace(-1.0, 1.0, self.basis.count)
        free = np.column_stack([np.ones_like(place), place, place**2])
        self._weights, self._parabolas = weights, (free, _times(matrix, free))
        self._normal = matrix, self._right([one.value for one in self._samples])

    def _right(self, values: Sequence[Array]) -> Array:
        """Right side (count,) of the normal equations, of values (n,) in place of the samples'."""
        parts = zip(self._designs, self._weights, values, strict=True)
        return np.asarray(sum(design.T @ (weight * value) for design, weight, value in parts))

    def _robust(self) -> Array:
        """The smooth fit, with samples far from it weighed less, round by round."""
        coefficients = np.zeros(self.basis.count)
        for _ in range(N_REWEIGHTINGS):
            self._penalty = self._likely_penalty(self._normal[1])
            coefficients = self._solved(self._penalty, self._normal[1])
            weights = []
            for design, one in zip(self._designs, self._samples, strict=True):
                off = np.abs(one.value - design @ coefficients) / one.std
                weights.append(one.std**-2.0 / np.maximum(off / OUTLIER_SIGMAS, 1.0) ** 2)
            if all(map(np.array_equal, weights, self._weights)):
                break
            self._weigh(weights)
        return coefficients

    def _solved(self, penalty: float, right: Array) -> Array:
        parabola, rest = self._without_parabola(right)
        matrix = self._normal[0] + penalty * self._roughness
        return np.asarray(parabola + _by_cholesky(matrix, rest)[0])

    def _without_parabola(self, right: Array) -> tuple[Array, Array]:
        """Coefficients (count,) of the parabola that fits best, which no penalty changes, and the right side (count,)
        that is left. Beside one that is far larger than the rest, rounding would leave nothing of that."""
        free, weighed = self._parabolas
        parabola = np.linalg.lstsq(free.T @ weighed, free.T @ right, rcond=None)[0]
        return free @ parabola, right - weighed @ parabola

    def _likely_penalty(self, right: Array) -> float:
        matrix, (_, right) = self._normal[0], self._without_parabola(right)
        scale, free = float(np.mean(matrix[-1])), self.basis.count - PENALTY_ORDER
        stiffest = MAX_PENALTY_DECADES + float(np.log10(self._weight_of_values / scale))

        def misfit(decade: float) -> float:
            penalty = scale * 10.0**decade
            found, root = _by_cholesky(matrix + penalty * self._roughness, right)
            return float(2 * np.log(root).sum() - free * np.log(penalty) - right @ found)

        decade = float(minimize_scalar(misfit, bounds=(MIN_PENALTY_DECADES, stiffest), method="bounded").x)
        return float(scale * 10.0**decade)


@dataclass(frozen=True, eq=False)
class PoseFits:
    """Fits (3) of a tracked frame's pose in {s}, and what makes values and rates at times (n,) of coefficients."""

    fits: tuple[SplineFit, ...]
    time: Array
    value: csr_array
    rate: csr_array

    def beside(self, known: Array) -> tuple[Array, Array, Array]:
        """Poses and rates (n, 3) that keep to what is known of the rates, (n, 3), but for what is smooth; and the
        penalties (3,) that make it so."""
        moved = self._moved(known)
        own = [fit.beside(self.time, (moved[:, i], known[:, i])) for i, fit in enumerate(self.fits)]
        pose, rate = self._summed([coefficients for coefficients, _ in own], moved, known)
        return pose, rate, np.array([penalty for _, penalty in own])

    def noise_beside(self, known: Array, penalties: Array, generator: np.random.Generator) -> tuple[Array, Array]:
        """Errors (n, 3) of such poses and rates that the sensors' noise makes, and errors of what is known."""
        moved = self._moved(known)
        own = [
            fit.noise_beside(self.time, (moved[:, i], known[:, i]), penalties[i], generator)
            for i, fit in enumerate(self.fits)
        ]
        return self._summed(own, moved, known)

    def _moved(self, rate: Array) -> Array:
        return np.asarray(cumulative_trapezoid(rate, self.time, axis=0, initial=0))

    def _summed(self, coefficients: list[Array], moved: Array, rate: Array) -> tuple[Array, Array]:
        own = np.column_stack(coefficients)
        return moved + self.value @ own, rate + self.rate @ own


def _at(samples: Samples, time: Array, known: tuple[Array, Array]) -> Array:
    """What is known of a signal and of its rate at times (n,), at those of samples; beyond, it goes on straight."""
    value = np.interp(samples.time, time, known[samples.derivative])
    if samples.derivative:
        return value
    beyond = samples.time - np.clip(samples.time, time[0], time[-1])
    return np.asarray(value + beyond * np.where(beyond < 0.0, known[1][0], known[1][-1]))


def _times(banded: Array, columns: Array) -> Array:
    """A symmetric matrix in upper banded form (width + 1, n) times columns (n, k)."""
    width, found = len(banded) - 1, banded[-1][:, None] * columns
    for k in range(1, width + 1):
        off = banded[width - k, k:, None]
        found[:-k] += off * columns[k:]
        found[k:] += off * columns[:-k]
    return np.asarray(found)


def _by_cholesky(matrix: Array, right: Array) -> tuple[Array, Array]:
    """Solution (n,) for a positive definite matrix in upper banded form, and the diagonal (n,) of its Cholesky root."""
    root, found, flaw = dpbsv(matrix, right)
    if flaw or not np.isfinite(found).all():
        raise np.linalg.LinAlgError("a spline's normal equations are not positive definite")
    return found, root[-1]


def _in_rows(first: np.ndarray, values: Array, count: int) -> csr_array:
    """Rows (n, count) of which each has its values (n, k) side by side, from column `first` (n,) on."""
    n, k = values.shape
    columns = first[:, None] + np.arange(k)
    return csr_array((values.ravel(), columns.ravel(), k * np.arange(n + 1)), shape=(n, count))


def _squares(rows: csr_array, weight: Array) -> Array:
    """Upper banded form (SPLINE_DEGREE + 1, count) of `rows.T @ diag(weight) @ rows`, for rows as `_in_rows` makes
    them."""
    n, count = rows.shape
    values, columns = (part.reshape(n, -1).T for part in (rows.data, rows.indices))
    found = np.zeros((SPLINE_DEGREE + 1, count))
    for one, weighed in enumerate(weight * values):
        for k, (column, value) in enumerate(zip(columns[one:], values[one:], strict=True)):
            found[SPLINE_DEGREE - k] += np.bincount(column, weighed * value, minlength=count)
    return found
