"""What a run has taught so far, and what not: parameters that are known, those that no motion has excited, those that
only move together, and the motion that would tell them apart."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np

from cartgrasp.errors import UsageError
from cartgrasp.frames import Array
from cartgrasp.inertia import N_PHI, physical_jacobian
from cartgrasp.information import WrenchNoise
from cartgrasp.motion import Estimate

from .experiments.exciting_motions import remedy
from .parameter_report import ParameterReport
from .prior import Prior, report_names

CONFOUNDED_CORRELATION = 0.8
"""Correlation from which two parameters are said to move together."""
REST_REMEDY = "record the arms at rest, and hold at another point"


@dataclass(frozen=True)
class Unidentifiable:
    """Parameters that this motion has not taught; several where only combinations of them are known. `remedy` is a
    motion that would, None where none of the usual ones would."""

    parameters: tuple[str, ...]
    remedy: str | None

    def __str__(self) -> str:
        names = " and ".join((", ".join(self.parameters[:-1]), self.parameters[-1])[len(self.parameters) < 2 :])
        cure = f"{self.remedy} to tell" if self.remedy else "none of the usual motions would tell"
        if len(self.parameters) > 1:
            return f"{names} move together: {cure} them apart"
        return f"{names} is not identifiable on this motion: {cure}"

    def as_dict(self) -> dict[str, Any]:
        return {"parameters": list(self.parameters), "remedy": self.remedy, "text": str(self)}


@dataclass(frozen=True)
class Identifiability:
    """Parameters with what is left of their first standard deviations, and those that were not taught."""

    left: dict[str, float]
    untaught: tuple[Unidentifiable, ...]

    def as_dict(self) -> dict[str, Any]:
        return {"left": self.left, "untaught": [one.as_dict() for one in self.untaught]}


def identifiability(estimate: Estimate, prior: Prior | None = None) -> Identifiability:
    """Identifiability of an estimate with a covariance, against the prior that it began with. It judges by what the
    motion could teach, even where the model does not fit it."""
    if estimate.covariance is None:
        raise UsageError("identifiability: this estimate has no covariance")
    known = _Known.of(estimate, estimate.covariance, prior or Prior())
    untaught = tuple(
        Unidentifiable(tuple(known.names[i] for i in group), known.remedy(group)) for group in known.groups()
    )
    shares = np.minimum(known.std / known.first, 1.0)
    return Identifiability(dict(zip(known.names, shares.tolist(), strict=True)), untaught)


@dataclass(frozen=True)
class _Known:
    """The q free ones, as they are reported: `names`, `first` standard deviations and `covariance` (q, q); `to_report`
    (q, p) takes a change of the model's parameters to them; whether each was `taught`."""

    estimate: Estimate
    names: tuple[str, ...]
    free: np.ndarray
    first: Array
    to_report: Array
    covariance: Array
    taught: tuple[bool, ...]

    @classmethod
    def of(cls, estimate: Estimate, covariance: Array, prior: Prior) -> _Known:
        cart = estimate.structure
        names, free = report_names(cart), prior.free(cart)
        to_report = np.eye(len(names))
        to_report[:N_PHI, :N_PHI] = physical_jacobian(estimate.model_parameters[:N_PHI])
        to_report = to_report[free]
        first = prior.deviations(cart)[free]
        report = ParameterReport(cart, prior).of_free(
            estimate.model_parameters, covariance, free, np.diagonal(prior.covariance(cart))[free]
        )
        own = tuple(names[k] for k in free)
        taught = tuple(report[name].identifiable for name in own)
        return cls(estimate, own, free, first, to_report, to_report @ covariance @ to_report.T, taught)

    @property
    def std(self) -> Array:
        return np.sqrt(np.maximum(np.diagonal(self.covariance), np.finfo(float).tiny))

    def groups(self) -> list[tuple[int, ...]]:
        """Groups (indices) of parameters that were not taught, each connected by large correlations."""
        members = [i for i, taught in enumerate(self.taught) if not taught]
        correlation = self.covariance / np.outer(self.std, self.std)
        group = {i: {i} for i in members}
        for i, j in combinations(members, 2):
            if abs(correlation[i, j]) > CONFOUNDED_CORRELATION:
                whole = group[i] | group[j]
                group.update(dict.fromkeys(whole, whole))
        return sorted({tuple(sorted(one)) for one in group.values()})

    def remedy(self, group: tuple[int, ...]) -> str | None:
        """The remedy for the combination of the group that is known least, in shares of the first deviations."""
        cart, here = self.estimate.structure, list(group)
        of_sensors = {key for effect, _ in cart.sensor_effects for key in effect.keys}
        if of_sensors & {self.names[i] for i in here}:
            return REST_REMEDY
        scale = 1 / self.first[here]
        _, directions = np.linalg.eigh(self.covariance[np.ix_(here, here)] * np.outer(scale, scale))
        return remedy(self.estimate, self.free, (directions[:, -1] * scale) @ self.to_report[here], WrenchNoise())
