"""The gap between simulation and measurement on stretches that no fit saw."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numpy as np

from cartgrasp.effects import Effect
from cartgrasp.effects.effect import Gate
from cartgrasp.model import CartModel

from ..batch.wrench_regression import WrenchRegression
from .fitted import Fitted
from .manoeuvres import held_out, manoeuvres
from .rollouts import Rollouts, noise_floor, roll_out, starts

HORIZON, EVERY = 1.0, 0.25
"""s."""


class HeldOut:
    """Of the logs of a nominal fit; `whole` are its regressions with the rows at standstill, which fits leave out."""

    def __init__(self, nominal: Fitted, whole: Sequence[WrenchRegression]) -> None:
        self.nominal, self.whole = nominal, tuple(whole)
        self._kept = [self._stretches(r) for r in whole]

    def _stretches(self, regression: WrenchRegression) -> np.ndarray:
        turns = not regression.cart.constraints.no_rotation
        return held_out(manoeuvres(regression.motion, turns))

    @cached_property
    def training(self) -> tuple[WrenchRegression, ...]:
        return tuple(r.within(~kept) for r, kept in zip(self.nominal.regressions, self._kept, strict=True))

    def trained(self, fitted: Fitted) -> Fitted:
        """The same structure, fitted to training stretches; an effect that acts for a while only, to all."""
        passing = any(effect.gate in (Gate.FROM, Gate.WHILE) for effect in fitted.added)
        return fitted if passing else fitted.on(self.training)

    def rollouts(self, cart: CartModel, delays: tuple[float, ...], horizon: float = HORIZON) -> tuple[Rollouts, ...]:
        found = []
        for regression, kept, delay in zip(self.whole, self._kept, delays, strict=True):
            first = starts(regression, kept, horizon, EVERY)
            found.append(roll_out(regression, cart, delay, first, horizon))
        return tuple(found)

    def gap(self, fitted: Fitted, horizon: float = HORIZON) -> float:
        """Root mean square distance (m) of a structure trained elsewhere."""
        trained = self.trained(fitted)
        return joined(self.rollouts(trained.cart, trained.delays, horizon)).gap

    @cached_property
    def nominal_gap(self) -> float:
        return self.gap(self.nominal)

    def floor(self, fitted: Fitted) -> float:
        return joined(self.floor_rollouts(fitted, HORIZON)).gap

    def floor_rollouts(self, fitted: Fitted, horizon: float = HORIZON) -> tuple[Rollouts, ...]:
        generator = np.random.default_rng(0)
        found = []
        for regression, kept in zip(self.whole, self._kept, strict=True):
            first = starts(regression, kept, horizon, EVERY)
            found.append(noise_floor(regression, fitted, first, horizon, generator))
        return tuple(found)

    def gain(self, fitted: Fitted, better: Fitted, effect: Effect) -> float:
        """By how much the gap shrinks, as a share of what the nominal model's was above the noise floor."""
        floor = self.floor(better)
        before = self.gap(fitted)
        whole = max(self.nominal_gap**2 - floor**2, 1e-12)
        return (before**2 - self.gap(better) ** 2) / whole


def joined(rollouts: tuple[Rollouts, ...]) -> Rollouts:
    return Rollouts(
        np.concatenate([r.first for r in rollouts]), rollouts[0].horizon, np.concatenate([r.error for r in rollouts])
    )
