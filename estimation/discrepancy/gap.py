"""The gap between simulation and measurement, before, refitted and after, beside what noise alone would do."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from cartgrasp.errors import DataError
from cartgrasp.model import CartModel

from .held_out import HeldOut, joined
from .selection import Selection


@dataclass(frozen=True)
class Gap:
    """Root mean square error (m) of 1 s rollouts on held-out stretches: of the nominal model, of the same refitted,
    with the effects added, and what noise alone would do; the same by coordinate (m, m, rad) and by horizon."""

    before: float
    refitted: float
    after: float
    noise_floor: float
    per_coordinate: dict[str, dict[str, float]]
    per_horizon: dict[str, dict[str, float]]

    def as_dict(self) -> dict[str, Any]:
        return {
            "metric": "root mean square distance after a 1 s rollout on held-out stretches, m",
            "before": self.before,
            "refitted": self.refitted,
            "after": self.after,
            "noise_floor": self.noise_floor,
            "per_coordinate": self.per_coordinate,
            "per_horizon": self.per_horizon,
        }


def measured_gap(cart: CartModel, selection: Selection) -> Gap:
    """Of the cart as it was believed, and of the selection's models."""
    held_out: HeldOut = selection.held_out
    nominal, final = held_out.trained(selection.nominal), held_out.trained(selection.final)
    horizons: dict[str, dict[str, float]] = {}
    for horizon in (0.5, 1.0, 2.0):
        rolled = {
            "before": joined(held_out.rollouts(cart, nominal.delays, horizon)),
            "refitted": joined(held_out.rollouts(nominal.cart, nominal.delays, horizon)),
            "after": joined(held_out.rollouts(final.cart, final.delays, horizon)),
            "noise_floor": joined(held_out.floor_rollouts(selection.final, horizon)),
        }
        if not len(rolled["after"].first):  # no stretch that is set aside is so long
            continue
        horizons[f"{horizon:g} s"] = {name: r.gap for name, r in rolled.items()}
        if horizon == 1.0:
            per_coordinate = {
                c: {name: r.by_coordinate[c] for name, r in rolled.items()} for c in rolled["after"].by_coordinate
            }
    if not np.isfinite(list(horizons["1 s"].values())).all():
        names = ", ".join(regression.name for regression in held_out.whole)
        raise DataError(f"{names}: simulations run away from it; look for numbers that are not in SI units")
    return Gap(**horizons["1 s"], per_coordinate=per_coordinate, per_horizon=horizons)
