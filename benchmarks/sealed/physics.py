"""The nominal model as a linear regression, and what a report says of a fit of it with terms beside."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from .columns import Candidate, body_columns, drag_columns
from .recorded import Cart, Recorded


def nominal_columns(log: Recorded, cart: Cart) -> np.ndarray:
    body = body_columns(log)
    return body if cart.drag is None else np.hstack([body, drag_columns(log)])


def measured(log: Recorded) -> np.ndarray:
    """(3 n,)."""
    return np.concatenate([*log.sum.T, log.v])


def weights(nominal: np.ndarray, target: np.ndarray) -> np.ndarray:
    """(3 n, 1): residuals of the refitted nominal model get the same size in each third."""
    residual = target - nominal @ np.linalg.lstsq(nominal, target, rcond=1e-9)[0]
    sizes = np.sqrt((residual.reshape(3, -1) ** 2).mean(axis=1))
    return np.repeat(1 / np.maximum(sizes, 1e-9), len(target) // 3)[:, None]


def report(
    cart: Cart, nominal: np.ndarray, target: np.ndarray, terms: Sequence[tuple[Candidate, np.ndarray]]
) -> dict[str, Any]:
    """Of a fit of nominal columns (m, k) and those of terms to a target (m,)."""
    value, deviation = fitted(np.hstack([nominal, *(columns for _, columns in terms)]), target)
    effects: dict[tuple[str, str], dict[str, Any]] = {}
    at = nominal.shape[1]
    for term, columns in terms:
        own = slice(at, at + columns.shape[1])
        effects.setdefault((term.name, term.label), entry(term, value[own], deviation[own]))
        at = own.stop
    return {
        "verdict": "explained" if effects else "no_discrepancy",
        "effects": list(effects.values()),
        "parameter_mismatch": mismatch(cart, value, deviation),
        "unexplained": {"depends_on": []},
    }


def fitted(design: np.ndarray, target: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Coefficients and their standard deviations, as if rows were independent."""
    inverse = np.linalg.pinv(design, rcond=1e-9)
    value = inverse @ target
    left = target - design @ value
    variance = float(left @ left) / max(len(target) - len(value), 1)
    return value, np.sqrt(variance * (inverse**2).sum(axis=1))


def entry(term: Candidate, value: np.ndarray, deviation: np.ndarray) -> dict[str, Any]:
    told = zip(term.parameters, value + term.base, deviation, strict=False)
    parameters = {name: {"value": float(v), "std": float(s), "unit": ""} for name, v, s in told}
    parameters |= {name: {"value": v, "std": None, "unit": ""} for name, v in term.settings.items()}
    return {"name": term.name, "label": term.label, "parameters": parameters, "confusable_with": []}


def mismatch(cart: Cart, value: np.ndarray, deviation: np.ndarray) -> dict[str, Any]:
    """Of what the refit moved; standard deviations of quotients as if masses were exact."""
    m, mx, my, yaw = value[:4]
    x, y = mx / m, my / m
    moved = {"mass": m, "com_x": x, "com_y": y, "inertia": yaw - m * (x**2 + y**2)}
    deviations = {"mass": 1.0, "com_x": 1 / m, "com_y": 1 / m, "inertia": 1.0}
    before = {"mass": cart.mass, "com_x": cart.com[0], "com_y": cart.com[1], "inertia": cart.inertia}
    found = {
        name: {"nominal": before[name], "refitted": float(moved[name]), "std": float(deviation[i] * deviations[name])}
        for i, name in enumerate(moved)
    }
    if cart.drag is not None:
        for i, name in enumerate(("linear", "angular")):
            said = {"nominal": cart.drag[i], "refitted": float(value[4 + i]), "std": float(deviation[4 + i])}
            found[f"viscous_drag.{name}"] = said
    return found
