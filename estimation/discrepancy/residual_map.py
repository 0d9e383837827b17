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
BINS = 8
HALF = np.pi / BINS
"""Of a heading's bin, rad: the floor's axes are in the middle of theirs."""
FEWEST = 3
"""Stretches in a bin."""


@dataclass(frozen=True)
class Binned:
    """Of some bins (k,) the weighed means, and their standard deviations; of bins with too few stretches no number."""

    mean: Array
    std: Array


@dataclass(frozen=True)
class Profile:
    """A residual against a variable: the variable's means in bins (k,), and the residual there."""

    variable: str
    unit: str
    at: Array
    residual: Binned


@dataclass(frozen=True)
class ResidualMap:
    """Of a coordinate against a variable, each in its unit: the variable's means in bins (k,); what the refitted model
    leaves there, and the extended one."""

    coordinate: str
    unit: str
    variable: str
    variable_unit: str
    at: Array
    refitted: Binned
    extended: Binned

    def as_dict(self) -> dict[str, Any]:
        """With numbers alone."""
        told: dict[str, Any] = {key: getattr(self, key) for key in ("coordinate", "unit", "variable", "variable_unit")}
        told["at"] = self.at.tolist()
        for key, one in (("refitted", self.refitted), ("extended", self.extended)):
            told |= {key: one.mean.tolist(), f"{key}_std": one.std.tolist()}
        return told


def residual_maps(before: Sequence[Residual], after: Sequence[Residual]) -> tuple[ResidualMap, ...]:
    """Of each coordinate one against every variable that changes, in the bins of what was left before."""
    return tuple(
        ResidualMap(first.coordinate, first.unit, one.variable, one.unit, one.at, one.residual, other.residual)
        for first, last in zip(before, after, strict=True)
        for one, other in zip(profiles(first), profiles(last, first.circumstances), strict=True)
    )


def profiles(residual: Residual, bins: Circumstances | None = None) -> Iterator[Profile]:
    """Against every variable that changes; in bins of other circumstances, where these are given."""
    own = _variables(residual.circumstances)
    for (name, unit), values in _variables(bins or residual.circumstances).items():
        edges = _edges(name, values)
        if len(edges) > 2 and np.isfinite(_means(values, edges)).sum() > 1:
            yield Profile(name, unit, _means(own[name, unit], edges), _binned(residual, own[name, unit], edges))


def _variables(found: Circumstances) -> dict[tuple[str, str], Array]:
    """By name and unit (b,); what is not known is not finite."""
    course = found.course
    known = {
        **_times(found),
        ("way travelled", "m"): course.travelled,
        ("distance since a reversal", "m"): course.since_reversal,
        ("speed", "m/s"): course.speed,
        ("yaw rate", "rad/s"): course.yaw_rate,
        (HEADING, "rad"): wrap_angle(course.heading + HALF) - HALF,
    }
    if found.wrenches:
        known |= {
            ("forward force of the arms", "N"): found.total[:, 0],
            ("moment of the arms", "N·m"): found.total[:, 2],
        }
    if len(found.wrenches) > 1:
        known |= {(f"force of arm {arm}", "N"): found.strength(arm) for arm in found.wrenches}
    return known


def _times(found: Circumstances) -> dict[tuple[str, str], Array]:
    """Clocks of several logs have nothing in common."""
    several = len(found.names) > 1
    return {("time since the log's begin", "s"): found.course.time} if several else {("time", "s"): found.time}


def _edges(name: str, values: Array) -> Array:
    """Of bins that hold as much each; headings have bins of one width."""
    if name == HEADING:
        return np.linspace(-np.pi, np.pi, BINS + 1) - HALF
    known = values[np.isfinite(values)]
    return np.unique(np.quantile(known, np.linspace(0, 1, BINS + 1))) if len(known) else known


def _means(values: Array, edges: Array) -> Array:
    count, total = _sums(values, edges, np.ones(len(values)), values)
    return np.asarray(total / np.where(count > 0, count, np.nan))


def _binned(residual: Residual, values: Array, edges: Array) -> Binned:
    weight = residual.std**-2.0
    count, whole, total = _sums(values, edges, np.ones(len(values)), weight, weight * residual.value)
    whole = np.where(count >= FEWEST, whole, np.nan)
    return Binned(np.asarray(total / whole), np.asarray(whole**-0.5))


def _sums(values: Array, edges: Array, *columns: Array) -> list[Array]:
    """Of columns (b,) where values (b,) are known, in bins."""
    known = np.isfinite(values)
    number = np.clip(np.searchsorted(edges, values[known], "right") - 1, 0, len(edges) - 2)
    return [np.bincount(number, column[known], len(edges) - 1).astype(float) for column in columns]
