"""A log run through an online estimator, as if it were happening."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import Any, ClassVar, Protocol

import numpy as np

from cartgrasp.errors import DataError, UsageError
from cartgrasp.logs import RunLog
from cartgrasp.logs.alignment import aligned
from cartgrasp.model import CartModel
from cartgrasp.motion import Estimate, Measurement
from cartgrasp.roles import Estimator

from ..log_noise.log_noise import noise_of_log
from ..log_noise.sentinel_values import without_sentinels
from ..online.cart_filter import CartFilter
from ..online.paper_filter import DIVERGED, PaperFilter
from ..online.regressor_estimator import RegressorEstimator
from ..sensor_check.repeated_rows import without_repeats
from .coasting import prior_of, with_known_wrench

ONLINE_ESTIMATORS: dict[str, type[CartFilter | RegressorEstimator | PaperFilter]] = {
    "filter": CartFilter,
    "regressor": RegressorEstimator,
    "paper": PaperFilter,
}
"""By the name of the method."""


class CartEstimator(Estimator, Protocol):
    """An estimator that says of which cart, and whether it brings late wrenches back itself."""

    cart: CartModel
    aligns: ClassVar[bool]


@dataclass(frozen=True)
class Replay:
    """The estimates (n,), one a row of the log."""

    estimates: tuple[Estimate, ...]

    @property
    def last(self) -> Estimate:
        return self.estimates[-1]

    def as_dict(self) -> dict[str, Any]:
        """The result as the command line gives it."""
        parameters = {name: asdict(parameter) for name, parameter in self.last.parameters.items()}
        return {"time": self.last.time, "parameters": parameters, "health": str(self.last.health)}

    def series_csv(self) -> str:
        """Time, and value and standard deviation of each parameter."""
        names = list(self.last.parameters)
        header = ["t", *(f"{name}{suffix}" for name in names for suffix in ("", ".std")), "health"]
        lines = [",".join(header)]
        for estimate in self.estimates:
            cells = [repr(estimate.time)]
            for name in names:
                parameter = estimate.parameters[name]
                cells += [_cell(parameter.value), _cell(parameter.std)]
            lines.append(",".join([*cells, str(estimate.health)]))
        return "\n".join(lines) + "\n"


def as_replayed(log: RunLog) -> RunLog:
    """The log as online estimators take it: without numbers that stand for no reading, thinned, and with its wrench
    written out where nobody pushes."""
    return with_known_wrench(without_sentinels(log).thinned())


def replay(
    log: RunLog,
    estimator: CartEstimator,
    progress: Callable[[float], None] | None = None,
    until: float | None = None,
) -> Replay:
    """Every row of the log in turn, its wrenches of the time when they happened, without numbers that stand for no
    reading, then on to `until` (s); `progress` is told the share done."""
    estimates = []
    known = without_sentinels(log)
    told = known if estimator.aligns else aligned(known, estimator.cart)
    for i, measurement in enumerate(told.measurements()):
        estimates.append(_updated(estimator, measurement, log.name))
        if progress is not None and i % 100 == 0:
            progress(i / len(log))
    if until is not None and until > log.time[-1]:
        estimates.append(_updated(estimator, Measurement(until), log.name))
    return Replay(tuple(estimates))


def estimated(
    log: RunLog,
    cart: CartModel,
    method: str = "filter",
    progress: Callable[[float], None] | None = None,
    until: float | None = None,
) -> Replay:
    """The replay to one of `ONLINE_ESTIMATORS`, which is told how loud the log is, and what it can't tell."""
    noise, prior = noise_of_log(without_repeats(log), cart), prior_of([log], cart)  # steps of held poses are no noise
    estimator = ONLINE_ESTIMATORS[method](cart, list(log.arms), noise=noise, prior=prior)
    return replay(log, estimator, progress, until)


def _updated(estimator: CartEstimator, measurement: Measurement, name: str) -> Estimate:
    """The next estimate; numbers that no estimator can work with are the log's fault."""
    try:
        with np.errstate(all="ignore"):
            estimate = estimator.update(measurement)
    except (np.linalg.LinAlgError, OverflowError, DataError) as error:
        raise _too_large(measurement, name) from error
    except UsageError as error:
        raise DataError(f"{name}: t = {measurement.time:.9g} s: {error}") from error
    finite = all(math.isfinite(p.value) and math.isfinite(p.std) for p in estimate.parameters.values())
    if not finite and estimate.health != DIVERGED:
        raise _too_large(measurement, name)
    return estimate


def _too_large(measurement: Measurement, name: str) -> DataError:
    why = "what is recorded up to here can't be estimated from"
    return DataError(f"{name}: t = {measurement.time:.9g} s: {why}; look for numbers that are not in SI units")


def _cell(value: float) -> str:
    return repr(value) if math.isfinite(value) else ""
