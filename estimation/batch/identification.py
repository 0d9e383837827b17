"""Batch identification: the parameters of a cart from whole logs, by generalised least squares with a prior.

Every log is regressed on its own smoothed motion (`wrench_regression.py`); all logs' information and the prior's add
up. Where the best fit is no body or an effect out of its bounds, the most likely physical one is taken.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from scipy.linalg import block_diag

from cartgrasp.errors import DataError, UsageError
from cartgrasp.frames import Array
from cartgrasp.inertia import Inertia
from cartgrasp.logs import RunLog
from cartgrasp.model import CartModel
from cartgrasp.motion import ParameterEstimate

from ..noise import FilterNoise
from ..parameter_report import ParameterReport
from ..physical_set import PhysicalSet
from ..prior import Prior
from .wrench_regression import WrenchRegression

ROUNDS, SETTLED = 20, 1e-3
EARLIEST, LATEST = -0.5, 1.0
"""Steps after its row at which a wrench may act."""


@dataclass(frozen=True)
class LogFit:
    """How a log fits: by what share of a step its wrenches are late, and how many times as large as believed the noise
    variance had to be for it."""

    name: str
    delay: float
    noise_excess: float


@dataclass(frozen=True)
class Identification:
    """What logs say of a cart. `model_parameters` (p,) and `covariance` (p, p) are of `(phi | effects' values)`."""

    structure: CartModel
    model_parameters: Array
    covariance: Array
    parameters: dict[str, ParameterEstimate]
    logs: tuple[LogFit, ...]

    def cart(self) -> CartModel:
        """The cart with the values put in."""
        cart = self.structure.with_parameters(self.model_parameters)
        if not self.structure.constraints.no_rotation:
            return cart
        body = self.structure.inertia
        return cart.with_inertia(Inertia(cart.inertia.mass, body.com, body.about_com))

    def as_dict(self) -> dict[str, Any]:
        """The result as the command line gives it."""
        parameters = {name: asdict(parameter) for name, parameter in self.parameters.items()}
        return {"parameters": parameters, "logs": [asdict(log) for log in self.logs]}


def identify(
    logs: Sequence[RunLog],
    cart: CartModel,
    prior: Prior | None = None,
    noise: FilterNoise | None = None,
    progress: Callable[[float], None] | None = None,
) -> Identification:
    """Fits the cart to all logs at once; `cart` is the first guess, and `noise` is read off each log unless given.
    `progress` is told the share done."""
    if not logs:
        raise UsageError("identify: no log is given; at least one is needed")
    regressions = []
    for i, log in enumerate(logs):
        regressions.append(WrenchRegression(log, cart, noise))
        if progress is not None:
            progress((i + 1) / (len(logs) + 1))
    return fit(cart, prior or Prior(), regressions)


def fit(
    cart: CartModel,
    prior: Prior,
    regressions: Sequence[WrenchRegression],
    start: Array | None = None,
    settled: float = SETTLED,
) -> Identification:
    """As `identify`, of logs whose motion is smoothed already; from parameters (p,) at which to begin, until a round
    would move none by more than a share `settled` of its standard deviation."""
    found = _Fit(cart, prior, [regression.with_cart(cart) for regression in regressions])
    return found.result(cart.parameters if start is None else start, settled)


class _Fit:
    """Unknown: the free parameters, then each log's delay."""

    def __init__(self, cart: CartModel, prior: Prior, regressions: Sequence[WrenchRegression]) -> None:
        self.cart, self.prior, self.regressions = cart, prior, regressions
        self.free = prior.free(cart)
        self.first = cart.parameters.copy()
        self.first_covariance = prior.covariance(cart)[np.ix_(self.free, self.free)]
        self.source = ", ".join(regression.name for regression in regressions)
        self.excess = np.ones(len(regressions))
        self.delays, self.delay_std = np.array([regression.usual_delay for regression in regressions]).T

    def result(self, start: Array, settled: float) -> Identification:
        parameters, delays, covariance = self._solve(start, settled)
        whole = np.zeros((len(parameters), len(parameters)))
        whole[np.ix_(self.free, self.free)] = covariance
        told = zip(self.regressions, delays.tolist(), self.excess.tolist(), strict=True)
        logs = tuple(LogFit(regression.name, delay, excess) for regression, delay, excess in told)
        return Identification(self.cart, parameters, whole, self._report(parameters, whole), logs)

    def _solve(self, start: Array, settled: float) -> tuple[Array, Array, Array]:
        """Parameters (p,), delays (logs,), and the covariance of the free parameters."""
        f = len(self.free)
        parameters = start.copy()
        delays = self.delays.copy()
        limits, before = PhysicalSet.of(self.cart, self.source), 0.0
        for _ in range(ROUNDS):
            information, pull = self._normal(parameters, delays)
            covariance = np.asarray(np.linalg.inv(information), dtype=float)
            if not (np.diagonal(covariance) > 0).all():
                raise DataError(
                    f"{self.source}: can't be fitted; look for jumps in it and for numbers that are not in SI units"
                )
            move = covariance @ pull
            aim = parameters.copy()
            aim[self.free] += move[:f]
            aim = limits.nearest(aim, self.free, np.linalg.inv(covariance[:f, :f]))
            moved = (aim - parameters)[self.free] / np.sqrt(np.diagonal(covariance)[:f])
            parameters = aim
            delays = np.clip(delays + move[f:], EARLIEST, LATEST)
            if not np.isfinite(parameters).all():
                raise DataError(f"{self.source}: can't be fitted; look for numbers that are not in SI units")
            most = float(np.abs(moved).max(initial=0.0))
            shrinks = min(most / before, 1.0) if before else 1.0
            if most * shrinks < settled:
                break
            before = most
        return parameters, delays, np.asarray(covariance[:f, :f], dtype=float)

    def _normal(self, parameters: Array, delays: Array) -> tuple[Array, Array]:
        f, n = len(self.free), len(self.regressions)
        weight = np.linalg.inv(self.first_covariance)
        information, pull = np.zeros((f + n, f + n)), np.zeros(f + n)
        information[:f, :f] = weight
        pull[:f] = weight @ (self.first - parameters)[self.free]
        for i, regression in enumerate(self.regressions):
            found = regression.evidence(parameters, float(delays[i]))
            sure = float(self.delay_std[i]) ** -2
            own = np.append(np.arange(f), f + i)
            part = np.append(self.free, len(parameters))
            taught, drawn, excess = found.part(part).weighed(block_diag(weight, np.full((1, 1), sure)))
            self.excess[i] = excess
            information[np.ix_(own, own)] += taught / excess
            pull[own] += drawn / excess
            information[f + i, f + i] += sure
            pull[f + i] += (self.delays[i] - delays[i]) * sure
        return information, pull

    def _report(self, parameters: Array, covariance: Array) -> dict[str, ParameterEstimate]:
        share = np.ones(len(parameters))
        share[self.free] = np.sqrt(np.diagonal(covariance)[self.free] / np.diagonal(self.first_covariance))
        return ParameterReport(self.cart, self.prior).of(parameters, covariance, share)
