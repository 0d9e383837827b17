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
    at = count = nominal.shape[1]
    for term, columns in terms:
        own = slice(at, at + columns.shape[1])
        effects.setdefault((term.name, term.label), entry(term, value[own], deviation[own]))
        at = own.stop
    return told(cart, list(effects.values()), found_body(value[:count], deviation[:count]))


def fitted(design: np.ndarray, target: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Coefficients and their standard deviations, as if rows were independent."""
    inverse = np.linalg.pinv(design, rcond=1e-9)
    value = inverse @ target
    left = target - design @ value
    variance = float(left @ left) / max(len(target) - len(value), 1)
    return value, np.sqrt(variance * (inverse**2).sum(axis=1))


def entry(term: Candidate, value: np.ndarray, deviation: np.ndarray) -> dict[str, Any]:
    coefficients = zip(term.parameters, value + term.base, deviation, strict=False)
    parameters = {name: {"value": float(v), "std": float(s), "unit": ""} for name, v, s in coefficients}
    parameters |= {name: {"value": v, "std": None, "unit": ""} for name, v in term.settings.items()}
    return {"name": term.name, "label": term.label, "parameters": parameters, "confusable_with": []}


def found_body(value: np.ndarray, deviation: np.ndarray) -> list[tuple[float, float]]:
    """Mass, CoM and inertia with their standard deviations, those of quotients as if the mass were exact; what comes
    after the body's four values as it is."""
    m, mx, my, yaw = value[:4]
    x, y = mx / m, my / m
    values = [m, x, y, yaw - m * (x**2 + y**2), *value[4:6]]
    deviations = deviation[:6] / np.array([1.0, m, m, 1.0, 1.0, 1.0])[: len(deviation)]
    return [(float(one), float(std)) for one, std in zip(values, deviations, strict=True)]


def told(cart: Cart, effects: Sequence[dict[str, Any]], found: Sequence[tuple[float, float]]) -> dict[str, Any]:
    """A report, with what was found of mass, CoM, inertia and both drags, where the cart file has these."""
    before = {"mass": cart.mass, "com_x": cart.com[0], "com_y": cart.com[1], "inertia": cart.inertia}
    if cart.drag is not None:
        before |= {"viscous_drag.linear": cart.drag[0], "viscous_drag.angular": cart.drag[1]}
    return {
        "verdict": "explained" if effects else "no_discrepancy",
        "effects": list(effects),
        "parameter_mismatch": {
            name: {"nominal": nominal, "refitted": value, "std": std}
            for (name, nominal), (value, std) in zip(before.items(), found, strict=False)
        },
        "unexplained": {"depends_on": []},
    }
