"""What a report of the discrepancy workflow says, as numbers that can be held against a truth."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from .truths import downhill

GRAVITY = 9.81
Report = Mapping[str, Any]
Number = tuple[float, float]
"""A value and its standard deviation."""


@dataclass(frozen=True)
class Name:
    """An effect that is told, how sure it is, and what it is said not to be told apart from."""

    name: str
    probability: float
    confusable: frozenset[str]

    @property
    def either(self) -> frozenset[str]:
        return self.confusable | {self.name}


def names(report: Report) -> tuple[Name, ...]:
    """In the report's order."""
    return tuple(
        Name(e["name"], e["probability"], frozenset(e.get("confusable_with", ()))) for e in report.get("effects", ())
    )


def mass(report: Report) -> Number | None:
    return number(report.get("parameter_mismatch", {}).get("mass"), "refitted")


def rolling_force(report: Report) -> Number | None:
    """N, of the named effect on the refitted mass; its share of uncertainty is the coefficient's."""
    told, of_cart = parameters(report, "rolling_resistance"), mass(report)
    force = number(told.get("force"))
    if force is not None:
        return force
    coefficient = number(told.get("coefficient"))
    if coefficient is None or of_cart is None:
        return None
    weight = of_cart[0] * GRAVITY
    return coefficient[0] * weight, coefficient[1] * weight


def slope(report: Report) -> Number | None:
    """Degrees downhill along the world's x."""
    grade = number(parameters(report, "floor_slope").get("grade_x"))
    return None if grade is None else (downhill(grade[0]), math.degrees(grade[1] / (1 + grade[0] ** 2)))


def end_stop(report: Report) -> Number | None:
    return number(parameters(report, "end_stop").get("position"))


VALUES: dict[str, Callable[[Report], Number | None]] = {
    "rolling force": rolling_force,
    "slope": slope,
    "end stop": end_stop,
}
"""By the names that truths give them."""


def parameters(report: Report, name: str) -> Mapping[str, Any]:
    """Of the first effect of that name; none where it is not told."""
    return next((e["parameters"] for e in report.get("effects", ()) if e["name"] == name), {})


def number(told: Mapping[str, Any] | None, key: str = "value") -> Number | None:
    """None where there is no value; a deviation that is not told is none."""
    if told is None or told.get(key) is None:
        return None
    return float(told[key]), float(told.get("std") or 0.0)
