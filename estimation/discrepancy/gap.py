"""The gap between simulation and measurement on stretches that no fit saw, beside what noise alone would do."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from cartgrasp.effects import ConstraintEffect
from cartgrasp.errors import DataError
from cartgrasp.inertia import N_PHI
from cartgrasp.model import CartModel

from ..weak_form.balances import Balances
from ..weak_form.fit import coordinates, with_coordinates
from .fast_noise import fast_noise
from .model import Model
from .rollouts import HORIZONS, Rollouts, joined, noise_rollouts, rollouts, starts

FOLDS = 3
"""Every third stretch is simulated with what the others teach, in turn."""
DRAWS = 3
BEYOND_NOISE = 2.0
"""Times what noise alone makes of rollouts, and of the rows: a larger gap is a disagreement."""
MOST_MOVED = 1.0
"""Of a logarithm of mass or inertia: what a fold says beyond is no linear matter any more."""
COORDINATES = ("along", "across", "heading")


@dataclass(frozen=True)
class Gap:
    """Root mean square error (m) of 1 s rollouts on stretches that no fit saw: of the nominal model, of the same
    refitted, with the effects added, and what noise alone would do; by coordinate (m, m, rad) and by horizon."""

    before: float
    refitted: float
    after: float
    noise_floor: float
    per_coordinate: dict[str, dict[str, float]]
    per_horizon: dict[str, dict[str, float]]

    def as_the_file_has_it(self, *kinds: str) -> Gap:
        """With the errors of the cart as it was believed for those of such kinds, of which it foretells better."""

        def told(table: dict[str, dict[str, float]]) -> dict[str, dict[str, float]]:
            return {of: one | dict.fromkeys(kinds, one["before"]) for of, one in table.items()}

        horizons = told(self.per_horizon)
        return Gap(**horizons["1 s"], per_coordinate=told(self.per_coordinate), per_horizon=horizons)

    def as_dict(self) -> dict[str, Any]:
        return {"metric": "root mean square distance after a 1 s rollout on held-out stretches, m", **asdict(self)}


def file_rollouts(model: Model) -> Rollouts:
    """With the first guess."""
    return joined([rollouts(balances, model.guess, starts(balances)) for balances in model.logs])


def held_out_rollouts(model: Model) -> Rollouts:
    """Each stretch with a cart that was fitted to the others."""
    carts = fold_carts(model)
    return joined([rollouts(balances, carts[k], first) for balances, k, first in fold_starts(model)])


def fold_carts(model: Model) -> list[CartModel]:
    """The cart as it is fitted without each fold."""
    return [_without(model, fold) for fold in range(FOLDS)]


def fold_starts(model: Model) -> Iterator[tuple[Balances, int, np.ndarray]]:
    """Of each log, by fold, the points from which rollouts begin in its stretches."""
    ends = np.cumsum([len(balances.used) for balances in model.logs])[:-1]
    for balances, block in zip(model.logs, np.split(model.folds.block, ends), strict=True):
        own, first = model.folds.stretches[block], starts(balances)
        middle = balances.motion.time[first] + HORIZONS[1] / 2
        fold = own[np.clip(np.searchsorted(balances.time, middle), 0, len(own) - 1)] % FOLDS if len(own) else first * 0
        yield from ((balances, k, first[fold == k]) for k in range(FOLDS) if (fold == k).any())


def floor_rollouts(model: Model) -> Rollouts:
    """What noise alone would do to a right model."""
    generator, found, whole = np.random.default_rng(0), [], model.whole
    for balances in model.logs:
        noise = fast_noise(balances, whole)
        found += [noise_rollouts(balances, model.cart, noise, generator) for _ in range(DRAWS)]
    return joined(found)


def measured_gap(nominal: Model, final: Model) -> Gap:
    """Of the cart as it was believed, refitted and extended. Where nothing moves, all is noise."""
    if not any(len(starts(balances)) for balances in nominal.logs):
        return _at_rest(nominal)
    rolled = {
        "before": file_rollouts(nominal),
        "refitted": held_out_rollouts(nominal),
        "after": held_out_rollouts(final),
        "noise_floor": min(floor_rollouts(nominal), floor_rollouts(final), key=lambda one: float(one.gaps()[1])),
    }
    gaps = {name: one.gaps() for name, one in rolled.items()}
    horizons = {
        f"{horizon:g} s": {name: float(gap[i]) for name, gap in gaps.items()}
        for i, horizon in enumerate(HORIZONS)
        if all(np.isfinite(gap[i]) for gap in gaps.values())
    }
    if "1 s" not in horizons:
        names = ", ".join(balances.name for balances in nominal.logs)
        raise DataError(f"{names}: simulations run away from it; look for numbers that are not in SI units")
    by = {name: one.by_coordinate()[1].tolist() for name, one in rolled.items()}
    by_coordinate = {c: {name: each[i] for name, each in by.items()} for i, c in enumerate(COORDINATES)}
    return Gap(**horizons["1 s"], per_coordinate=by_coordinate, per_horizon=horizons)


def _at_rest(model: Model) -> Gap:
    std = np.max([balances.motion.noise.pose for balances in model.logs], axis=0)
    names = ("before", "refitted", "after", "noise_floor")
    alike = dict.fromkeys(names, float(np.hypot(std[0], std[1])))
    by = {c: dict.fromkeys(names, float(s)) for c, s in zip(COORDINATES, std, strict=True)}
    return Gap(**alike, per_coordinate=by, per_horizon={"1 s": alike})


def _without(model: Model, fold: int) -> CartModel:
    """The model's cart, with its laws, as the stretches of other folds teach it; what happens once stays as it is."""
    z, q, free = coordinates(model.cart), len(model.prior_std), np.flatnonzero(model.prior.free)
    kept = model.sums[:, model.folds.stretches % FOLDS != fold].sum(axis=1)
    joint = np.tensordot(model.score.scale**-2.0, kept, (0, 0))
    information, here = joint[:q, :q] + np.diag(model.prior_std**-2.0), np.zeros(q)
    here[: len(free)] = model.moved
    own = np.flatnonzero(np.append(~_once(model.cart)[free], np.ones(q - len(free), dtype=bool)))
    step = np.zeros(q)
    step[own] = np.linalg.solve(information[np.ix_(own, own)], (joint[:q, q] - information @ here)[own])
    far = np.abs(step[: len(free)])[free < N_PHI].max(initial=0.0)
    step /= max(far / MOST_MOVED, 1.0)
    z[free] += step[: len(free)]
    cart = with_coordinates(model.cart, z)
    sizes = zip(model.cart.constraint_effects, step[len(free) :], strict=False)
    changed = {effect.key: effect.scaled(1.0 + float(more)) for effect, more in sizes}
    cart = replace(cart, effects=tuple(changed.get(effect.key, effect) for effect in cart.effects))
    return model.with_laws(cart, step)


def _once(cart: CartModel) -> np.ndarray:
    """Parameters (p,) of what happens once: held out, it can't be learned."""
    once = [False] * N_PHI
    for effect in cart.effects:
        passes = effect.gate.passes and not isinstance(effect, ConstraintEffect)
        once += [passes] * len(effect.parameters)
    return np.array(once)
