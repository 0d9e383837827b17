"""A residual against all that it may depend on: means in bins, with their standard deviations."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from cartgrasp.frames import Array, wrap_angle

from .circumstances import Circumstances
from .residual import Residual

HEADING = "heading"
PROFILE_BINS = 8
HALF_HEADING_BIN = np.pi / PROFILE_BINS
"""Half of a heading's bin, rad: the floor's axes are in the middle of theirs."""
MIN_STRETCHES_PER_BIN = 3
"""Fewest stretches in a bin that has a number."""


@dataclass(frozen=True)
class Profile:
    """A residual against a variable, in bins (k,): the variable's means, and the residual's weighed means and their
    standard deviations; of bins with too few stretches no number."""

    variable: str
    unit: str
    at: Array
    mean: Array
    std: Array


@dataclass(frozen=True)
class ResidualMap:
    """What the refitted model leaves of a coordinate, in its unit, against a variable, and what the extended one leaves
    in the same bins."""

    coordinate: str
    unit: str
    refitted: Profile
    extended: Profile

    @property
    def variable(self) -> str:
        return self.refitted.variable

    def as_dict(self) -> dict[str, Any]:
        one, other = self.refitted, self.extended
        told = {"coordinate": self.coordinate, "unit": self.unit, "variable": one.variable, "variable_unit": one.unit}
        numbers = {"at": one.at, "refitted": one.mean, "refitted_std": one.std}
        numbers |= {"extended": other.mean, "extended_std": other.std}
        return told | {key: values.tolist() for key, values in numbers.items()}


def residual_maps(before: Sequence[Residual], after: Sequence[Residual]) -> tuple[ResidualMap, ...]:
    """Maps of each coordinate against every variable that changes, in the bins of what was left before."""
    return tuple(
        ResidualMap(first.coordinate, first.unit, *both)
        for first, last in zip(before, after, strict=True)
        for both in zip(profiles(first), profiles(last, first.circumstances), strict=True)
    )


def profiles(residual: Residual, bins: Circumstances | None = None) -> Iterator[Profile]:
    """Profiles of a residual against every variable that changes; in bins of other circumstances, where these are
    given."""
    own = variables(residual.circumstances)
    for (name, unit), values in variables(bins or residual.circumstances).items():
        edges = _edges(name, values)
        if len(edges) > 2 and (_sums(values, edges) > 0).sum() > 1:
            yield Profile(name, unit, *means(residual, own[name, unit], edges))


def means(residual: Residual, place: Array, edges: Array) -> tuple[Array, Array, Array]:
    """Means of a variable (b,) and of a residual over it, in bins (k,), and the standard deviations of the latter."""
    count, weight = _sums(place, edges), residual.std**-2.0
    whole = np.where(count >= MIN_STRETCHES_PER_BIN, _sums(place, edges, weight), np.nan)
    at = _sums(place, edges, place) / np.where(count > 0, count, np.nan)
    return at, _sums(place, edges, weight * residual.value) / whole, whole**-0.5


def strongest_dependence(residual: Residual, but: str = "nothing") -> tuple[float, Profile | None]:
    """Share of the disagreement that goes with the variable that a residual follows most, and the profile. Variables
    whose name begins with `but` are left out."""
    whole = max(float(residual.beyond.sum()), 1e-12)
    known = (one for one in profiles(residual) if not one.variable.startswith(but))
    found = [(float(np.nansum((one.mean / one.std) ** 2 - 1.0)) / whole, one) for one in known]
    share, best = max(found, key=lambda each: each[0], default=(0.0, None))
    return min(share, 1.0), best


def variables(found: Circumstances) -> dict[tuple[str, str], Array]:
    """Values (b,) of variables by name and unit; what is not known is not finite. Clocks of several logs have nothing
    in common."""
    course, several = found.covariates, len(found.names) > 1
    known = {
        ("time since the log's begin" if several else "time", "s"): course.time if several else found.time,
        ("way travelled", "m"): course.travelled,
        ("distance since a reversal", "m"): course.since_reversal,
        ("speed", "m/s"): course.speed,
        ("yaw rate", "rad/s"): course.yaw_rate,
        ("floor's x", "m"): course.x,
        ("floor's y", "m"): course.y,
        (HEADING, "rad"): wrap_angle(course.heading + HALF_HEADING_BIN) - HALF_HEADING_BIN,
    }
    if found.wrenches:
        known |= {
            ("forward force of the arms", "N"): found.total[:, 0],
            ("moment of the arms", "N·m"): found.total[:, 2],
        }
    if len(found.wrenches) > 1:
        known |= {(f"force of arm {arm}", "N"): found.strength(arm) for arm in found.wrenches}
    return known


def _edges(name: str, values: Array) -> Array:
    """Edges of bins that hold as much each; headings have bins of one width."""
    if name == HEADING:
        return np.linspace(-np.pi, np.pi, PROFILE_BINS + 1) - HALF_HEADING_BIN
    known = values[np.isfinite(values)]
    return np.unique(np.quantile(known, np.linspace(0, 1, PROFILE_BINS + 1))) if len(known) else known


def _sums(values: Array, edges: Array, weight: Array | None = None) -> Array:
    """Sums of weights (b,), or else counts, in bins of the values (b,) that are known; the outer bins have no end."""
    known = np.isfinite(values)
    inside = np.clip(values[known], edges[0], edges[-1])
    return np.histogram(inside, edges, weights=np.ones(len(inside)) if weight is None else weight[known])[0]
