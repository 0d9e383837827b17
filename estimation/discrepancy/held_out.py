"""The gap between simulation and measurement on stretches that no fit saw."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from functools import cached_property
from typing import NamedTuple

import numpy as np

from cartgrasp.effects import Effect
from cartgrasp.effects.effect import Gate
from cartgrasp.errors import DataError
from cartgrasp.frames import Array
from cartgrasp.model import CartModel
from cartgrasp.wheels import WheelSet

from ..batch.wrench_regression import WrenchRegression
from .fitted import Fitted
from .manoeuvres import held_out, manoeuvres
from .rollouts import Rollouts, noise_floor, roll_out, starts

BEYOND_NOISE = 1.5
"""Times the noise floor: a larger gap is a disagreement. Of 30 rollouts a gap is known to 15 %, and noise to 10 %."""
LEAST_WHOLE = 0.3
"""Of the squared gap: counted as disagreement even where noise could be all of it."""
EVERYWHERE = 0.8
HORIZON, EVERY = 1.0, 0.5
"""s."""


class Gain(NamedTuple):
    """By how much the squared gap shrinks: as a share of what the nominal model's was above the noise floor, with the
    standard deviation of that share; and as a share of what is left above the floor, 0 where that is no more than
    noise."""

    share: float
    noise: float
    of_rest: float


class HeldOut:
    """Of the logs of a nominal fit; `whole` are its regressions with the rows at standstill, which fits leave out."""

    def __init__(self, nominal: Fitted, whole: Sequence[WrenchRegression], everywhere: bool = False) -> None:
        """`everywhere`: every row is in the proof, and in the fits."""
        self.nominal, self.whole, self._is_everywhere = nominal, tuple(whole), everywhere
        self._kept = [np.ones(len(r.motion.time), dtype=bool) if everywhere else _stretches(r) for r in whole]
        self._trained: dict[Fitted, Fitted] = {}
        self._rolled: dict[Fitted, Rollouts] = {}
        if not any(len(starts(r, kept, HORIZON, EVERY)) for r, kept in zip(whole, self._kept, strict=True)):
            raise DataError(
                f"{', '.join(r.name for r in whole)}: no {HORIZON:g} s of what is set aside for the proof has every "
                "wrench and no gap; record longer, with a wrench in each row"
            )

    @cached_property
    def rolling(self) -> tuple[WheelSet, float]:
        """The cart's wheels, and the fastest speed of all logs (m/s)."""
        fastest = max(float(regression.motion.speed.max()) for regression in self.whole)
        return self.nominal.prior_cart.wheel_set, fastest

    @cached_property
    def training(self) -> tuple[WrenchRegression, ...]:
        if self._is_everywhere:
            return self.nominal.regressions
        return tuple(r.within(~kept) for r, kept in zip(self.nominal.regressions, self._kept, strict=True))

    def trained(self, fitted: Fitted) -> Fitted:
        """The same structure, fitted to training stretches, once; an effect that acts for a while only, to all."""
        if any(effect.gate.ends for effect in fitted.added):
            return fitted
        if fitted not in self._trained:
            self._trained[fitted] = fitted.on(self.training)
        return self._trained[fitted]

    def without(self, fitted: Fitted, key: str) -> Fitted:
        """Of a structure without one effect, which is trained from where the whole one is."""
        less, trained = fitted.without(key), self.trained(fitted)
        if trained is not fitted:
            self._trained[less] = trained.without(key)
        return less

    @cached_property
    def everywhere(self) -> HeldOut:
        """With every row in the proof and in the fits: what passes once can't be learned where it is held out."""
        return HeldOut(self.nominal, self.whole, everywhere=True)

    def rollouts(self, cart: CartModel, delays: tuple[float, ...], horizon: float = HORIZON) -> tuple[Rollouts, ...]:
        found = []
        for regression, kept, delay in zip(self.whole, self._kept, delays, strict=True):
            first = starts(regression, kept, horizon, EVERY)
            found.append(roll_out(regression, cart, delay, first, horizon))
        return tuple(found)

    def gap(self, fitted: Fitted) -> float:
        """Root mean square distance (m) of a structure trained elsewhere."""
        return self._of(fitted).gap

    def _of(self, fitted: Fitted) -> Rollouts:
        """Worked out once."""
        if fitted not in self._rolled:
            trained = self.trained(fitted)
            self._rolled[fitted] = joined(self.rollouts(trained.cart, trained.delays))
        return self._rolled[fitted]

    def floor(self, fitted: Fitted) -> float:
        return joined(self.floor_rollouts(fitted, HORIZON)).gap

    def floor_rollouts(self, fitted: Fitted, horizon: float = HORIZON) -> tuple[Rollouts, ...]:
        generator = np.random.default_rng(0)
        found = []
        for regression, kept, colour in zip(self.whole, self._kept, fitted.colours, strict=True):
            first, own = starts(regression, kept, horizon, EVERY), regression.coloured(colour)
            found.append(noise_floor(own, fitted, first, horizon, generator))
        return tuple(found)

    def gain(self, fitted: Fitted, better: Fitted) -> Gain:
        floor, before, nominal = self.floor(better), self.gap(fitted), self.gap(self.nominal)
        closed, left = self._of(fitted).closed(self._of(better)), before**2 - floor**2
        whole = max(nominal**2 - floor**2, LEAST_WHOLE * nominal**2)
        share, of_rest = float(closed.mean()) / whole, float(closed.mean()) / left if left > 0 else 0.0
        return Gain(share, deviation_of_mean(closed) / whole, of_rest if before > BEYOND_NOISE * floor else 0.0)

    def likelihood(self, fitted: Fitted, better: Fitted) -> float:
        """Log of the ratio of likelihoods of the wrenches that no fit saw, both at the usual delay of samples: at
        another, rows are mixed otherwise and their noise is another. Effects that both have may have other forms."""
        both = {effect.key for effect in fitted.added} & {effect.key for effect in better.added}
        (before, rows), (after, left) = (self._surprise(each, both) for each in (fitted, better))
        return 0.5 * (before * left / rows - after) / better.excess if rows else 0.0

    def _surprise(self, fitted: Fitted, loose: Collection[str]) -> tuple[float, int]:
        """And of how many rows: where sensors are late, those of lost samples are others."""
        trained, total, rows = self.trained(fitted), 0.0, 0
        for regression, kept in zip(fitted.regressions, self._kept, strict=True):
            own = regression.within(kept).with_cart(trained.cart)
            line = own.linearised(trained.cart.parameters, own.usual_delay[0])
            total += line.chi_squared - trained.forms(own, line, loose).taken(line)
            rows += len(line.time)
        return total, rows

    def covers(self, effect: Effect) -> bool:
        """Whether a place holds nearly all of the motion."""
        if effect.gate is not Gate.INSIDE:
            return False
        x, y = np.concatenate([regression.motion.pose[:, :2] for regression in self.whole]).T
        low_x, high_x, low_y, high_y = effect.values[:4]
        return bool(((x > low_x) & (x < high_x) & (y > low_y) & (y < high_y)).mean() > EVERYWHERE)


def deviation_of_mean(numbers: Array) -> float:
    """Of rollouts (r,), neighbours of which share half of their rows."""
    off = numbers - numbers.mean()
    return float(np.sqrt(max(off @ off + 2 * (off[1:] @ off[:-1]), 0.0)) / len(off))


def _stretches(regression: WrenchRegression) -> np.ndarray:
    turns = not regression.cart.constraints.no_rotation
    return held_out(manoeuvres(regression.motion, turns))


def joined(rollouts: tuple[Rollouts, ...]) -> Rollouts:
    return Rollouts(
        np.concatenate([r.first for r in rollouts]), rollouts[0].horizon, np.concatenate([r.error for r in rollouts])
    )
