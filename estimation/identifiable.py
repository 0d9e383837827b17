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
    cart, parameters, prior = estimate.structure, estimate.model_parameters, prior or Prior()
    free = prior.free(cart)
    names, first = [report_names(cart)[k] for k in free], prior.deviations(cart)[free]
    to_report = np.eye(len(parameters))
    to_report[:N_PHI, :N_PHI] = physical_jacobian(parameters[:N_PHI])
    to_report = to_report[free]  # takes a change of the model's parameters (p,) to the free ones as they are reported
    covariance = to_report @ estimate.covariance @ to_report.T
    std = np.sqrt(np.maximum(np.diagonal(covariance), np.finfo(float).tiny))
    report = ParameterReport(cart, prior).of_free(
        parameters, estimate.covariance, free, np.diagonal(prior.covariance(cart))[free]
    )
    of_sensors = {key for effect, _ in cart.sensor_effects for key in effect.keys}
    untaught = []
    for group in _groups(
        [i for i, name in enumerate(names) if not report[name].identifiable], covariance / np.outer(std, std)
    ):
        together = tuple(names[i] for i in group)
        cure: str | None = REST_REMEDY
        if not of_sensors & set(together):  # it is for the combination that is known least, in shares of the first
            scale = 1 / first[group]
            _, directions = np.linalg.eigh(covariance[np.ix_(group, group)] * np.outer(scale, scale))
            cure = remedy(estimate, free, (directions[:, -1] * scale) @ to_report[group], WrenchNoise())
        untaught.append(Unidentifiable(together, cure))
    shares = np.minimum(std / first, 1.0)
    return Identifiability(dict(zip(names, shares.tolist(), strict=True)), tuple(untaught))


def _groups(members: list[int], correlation: Array) -> list[list[int]]:
    """The members in groups that large correlations connect."""
    group = {i: {i} for i in members}
    for i, j in combinations(members, 2):
        if abs(correlation[i, j]) > CONFOUNDED_CORRELATION:
            whole = group[i] | group[j]
            group.update(dict.fromkeys(whole, whole))
    return sorted(map(list, {tuple(sorted(one)) for one in group.values()}))
