"""How sure a model's numbers are: by the noise of its rows, by how whole stretches scatter, and by what the band leaves
open."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np

from cartgrasp.effects import ConstraintEffect, Effect, SensorEffect
from cartgrasp.effects.effect import Gate
from cartgrasp.effects.time_delay import TimeDelay
from cartgrasp.first_guess import PHYSICAL_NAMES
from cartgrasp.frames import Array
from cartgrasp.inertia import N_PHI
from cartgrasp.model import CartModel
from cartgrasp.motion import ParameterEstimate

from ...prior import Prior, report_names, report_units
from ...weak_form.band import Band
from ...weak_form.coordinates import bounds, coordinates, with_coordinates
from ...weak_form.score import Score
from ...whole_log.corrected_fit import CorrectedFit
from ..search.gains import added, without_amplitudes
from ..search.laws import Law
from ..search.model import FORCE_LEVER_STD, Model
from ..search.refine import is_open, moves, refined
from ..search.screening import Screen
from .half_sine_push import as_half_sine, half_sine_gain, with_impulse_of
from .learned_laws import LearnedLaw, learned
from .reported_mass import reported_mass

IDENTIFIED_STD_RATIO = 0.25
"""Share of a usual first guess's standard deviation (`Prior`): what is known better was taught."""
MAX_LOG_MASS_CHANGE = 1.0
"""Largest change of the mass's logarithm: what goes farther with the middle of a bracket is no linear matter any
more."""
NEGLIGIBLE_NATS = 6.0
"""Nats below the best: what is less likely counts for nothing."""
MAX_RANGE_DOUBLINGS, SETTING_GRID_POINTS = 9, 17
MIN_TIME_STD, MIN_PLACE_STD, LENGTH_FORM_FRACTION = 0.005, 0.02, 0.05
"""Least standard deviations: half a sample (s); what an edge is (m); and the share of a length that its effect's form
leaves open."""
MIN_RESIDUAL_FRACTION = 0.05
"""Least share of a stretch's residual that a fit leaves: what it tells alone scatters no more."""
PERIOD_STEP_FRACTION = 1e-4
"""Share of a period with which a search for how well it is known begins."""
SETTING_STEP, RELATIVE_SETTING_STEP = {"s": 0.02, "m": 0.02}, 0.02
"""Steps of differences by a setting: by its unit, else as a share of its value."""
SIZE_FORM_FRACTION = 0.02
"""Share of an effect's size that its form leaves open, which no length of a log makes less."""


# Many methods: covariances of a model's numbers by steps that share one joint covariance, which is costly.
@dataclass(frozen=True, eq=False)
class Certainty:
    """How sure a model's numbers are. `bands` are those of logs that somebody pushed. `between_model` is a covariance
    of its first guess's coordinates beside, for what explains about as much as what it has. `corrected` is the same
    model's fit without what noise in the motion does to it, where that is taken off."""

    model: Model
    bands: tuple[Band, ...] = ()
    between_model: Array | None = None
    corrected: CorrectedFit | None = None

    @cached_property
    def _mass(self) -> tuple[float, float]:
        """Logarithm of the mass, and its standard deviation."""
        return reported_mass(float(np.log(self.model.cart.inertia.mass)), self._covariance[0, 0] ** 0.5, self.bands)

    @cached_property
    def cart(self) -> CartModel:
        """The model's cart with the mass that is told, and all else as it goes with that."""
        cart, free = self._with_spans(self.model.cart), np.flatnonzero(self.model.prior.free)
        z = coordinates(cart)
        z[free] += self._moved[: len(free)]
        return with_coordinates(cart, z)

    @cached_property
    def _moved(self) -> Array:
        """Change of the amplitudes of the rows' columns (q,) with the mass that is told, and where noise in the motion
        is taken off."""
        score = self.model.score
        moved = 0.0 * score.fit
        if self.corrected is not None:
            off = self.corrected.beside_mass(self.model.cart)
            moved[: len(off)] = off
        if not self.model.prior.free[0]:
            return moved
        along = score.covariance[:, 0] / score.covariance[0, 0]
        change = self._mass[0] - coordinates(self.model.cart)[0]
        return np.asarray(moved + along * np.clip(change, -MAX_LOG_MASS_CHANGE, MAX_LOG_MASS_CHANGE))

    @cached_property
    def laws(self) -> tuple[tuple[str, LearnedLaw], ...]:
        """The model's laws as forces, each with the law's key."""
        model, cart, found = self.model, self.cart, list[tuple[str, LearnedLaw]]()
        numbers, motions = model.score.fit + self._moved, model.motions
        for law, place in zip(model.laws, model.law_places, strict=True):
            of, std = self.covariance[place, place], self._period_std(law)
            for force in learned(law, numbers[place], of, cart, std, motions):
                cart = cart.with_effect(force.effect)
                found.append((law.key, force))
        return tuple(found)

    def _period_std(self, law: Law) -> float:
        """Standard deviation of a law's period, in the variable's unit; 0 of what does not repeat."""
        if law.period is None:
            return 0.0
        period, rest = law.period, tuple(one for one in self.model.laws if one is not law)
        screen = Screen(replace(self.model, laws=rest).refitted(self.model.cart))

        def gain(distance: float) -> float:
            return screen.of_law(law.repeating(period + distance)) if period + distance > period / 2 else -np.inf

        return _spread(gain, PERIOD_STEP_FRACTION * period)

    def _with_spans(self, cart: CartModel) -> CartModel:
        """The cart with pushes that begin and end where they most likely do."""
        spans = {key: effect for key, (effect, _) in self._set.items() if effect.gate is Gate.WHILE}
        effects = tuple(with_impulse_of(e, spans[e.key]) if e.key in spans else e for e in cart.effects)
        return replace(cart, effects=effects)

    @cached_property
    def covariance(self) -> Array:
        """Covariance (q, q) of the amplitudes of the rows' columns, with the mass as uncertain as it is told."""
        found = self._covariance
        if self.model.prior.free[0]:
            more = max(self._mass[1] ** 2 - found[0, 0], 0.0)
            found = found + np.outer(found[0], found[0]) / found[0, 0] ** 2 * more
        if self.between_model is None:
            return found
        free = np.flatnonzero(self.model.prior.free[: len(self.between_model)])
        beside = np.zeros_like(found)
        beside[: len(free), : len(free)] = self.between_model[np.ix_(free, free)]
        return np.asarray(found + beside)

    @property
    def _covariance(self) -> Array:
        """Covariance (q, q) of the amplitudes of the rows' columns, whatever the settings of added effects are. What
        noise in the motion hides is as unsure as the fit without it says."""
        q, stretch = len(self.model.score.fit), np.ones(len(self.model.score.fit))
        found = self._joint[0][:q, :q]
        if self.corrected is not None:
            unsure = self.corrected.deviations
            stretch[: len(unsure)] = np.maximum(unsure / np.sqrt(np.diagonal(found)[: len(unsure)]), 1.0)
        return np.asarray(found * np.outer(stretch, stretch))

    @cached_property
    def _joint(self) -> tuple[Array, dict[str, float]]:
        """Covariance of the rows' columns and of the settings that the logs tell, and these settings' standard
        deviations by full name: what a setting does to the rows is one column more (Gauss-Newton)."""
        model, found = self.model, dict[str, tuple[Array, float]]()
        for effect in (one for one in self._new if not isinstance(one, SensorEffect)):
            for which in dict.fromkeys(move.which for move in moves(effect)):
                share = RELATIVE_SETTING_STEP * abs(float(effect.values[which]))
                step = SETTING_STEP.get(effect.parameters[which].unit, share)
                ends = [effect.values + sign * step * np.eye(len(effect.values))[which] for sign in (-1.0, 1.0)]
                if step and all(is_open(effect, end) for end in ends):
                    bare = model.cart.without_effect(effect.key)
                    low, high = (bare.with_effect(effect.with_values(end)) for end in ends)
                    raw = [balances.between(low, high) / (2 * step) for balances in model.logs]
                    found[effect.keys[which]] = model.whitened(raw), effect.parameters[which].typical
        if not found:
            return sandwich(model.sums, model.score, model.folds.stretches), {}
        columns = np.concatenate([one for one, _ in found.values()], axis=2)
        sums = model.folds.sums(model.rows_with(columns))
        score = model.with_columns(columns, np.array([std for _, std in found.values()]))
        whole = sandwich(sums, score, model.folds.stretches)
        std = np.sqrt(np.diagonal(whole)[-len(found) :]).tolist()
        return whole, dict(zip(found, std, strict=True))

    @property
    def _new(self) -> list[Effect]:
        """Added effects but those of constraints."""
        return [effect for effect in added(self.model) if not isinstance(effect, ConstraintEffect)]

    @cached_property
    def parameters(self) -> dict[str, ParameterEstimate]:
        """Estimates of parameters by the names under which they are reported; at a bound, nothing is taught."""
        model, cart = self.model, self.cart
        prior = model.prior
        free = np.flatnonzero(prior.free)
        std = prior.std.copy()
        std[free] = np.sqrt(np.diagonal(self.covariance)[: len(free)])
        std = np.hypot(std, self._left_open)
        std[_given(model)] = 0.0
        body = cart.inertia
        values = np.concatenate([[body.mass, *body.com, body.about_com], cart.parameters[N_PHI:]])
        scale = np.ones(len(values))
        scale[[0, 3]] = body.mass, body.about_com
        usual = np.minimum(Prior().deviations(cart), prior.std * scale)
        (lower, upper), z = bounds(cart), coordinates(cart)
        taught = prior.free & (std * scale < IDENTIFIED_STD_RATIO * usual) & (lower < z) & (z < upper)
        rows = zip(report_names(cart), report_units(cart), values, std * scale, taught, strict=True)
        return {n: ParameterEstimate(float(v), float(s), unit, bool(known)) for n, unit, v, s, known in rows}

    @property
    def _left_open(self) -> Array:
        """Standard deviations (p,) that forms of added effects leave open: a share of how far these are from absent."""
        known, found = {effect.key for effect in self.model.guess.effects}, [0.0] * N_PHI
        for effect in self.cart.effects:
            for parameter, value in zip(effect.parameters, effect.values.tolist(), strict=True):
                is_new = effect.key not in known and parameter.estimated
                found.append(SIZE_FORM_FRACTION * abs(value - parameter.absent) if is_new else 0.0)
        return np.array(found)

    @cached_property
    def settings(self) -> Mapping[str, float]:
        """Standard deviations of what enters nonlinearly, by full name."""
        found: dict[str, float] = {}
        prior = self.model.prior
        first = int(prior.free.sum())
        for i, constraint in enumerate(self.model.cart.constraint_effects):
            share = float(np.hypot(np.sqrt(self.covariance[first + i, first + i]), SIZE_FORM_FRACTION))
            found[constraint.keys[0]] = share * abs(float(constraint.values[0]))
        for _, own in self._set.values():
            found |= own
        return found

    @cached_property
    def _set(self) -> dict[str, tuple[Effect, dict[str, float]]]:
        """Added effects by key, at their most likely settings, with these settings' standard deviations."""
        return {effect.key: self._of(effect) for effect in self._new if moves(effect)}

    def _of(self, effect: Effect) -> tuple[Effect, dict[str, float]]:
        less = self.model.refitted(self.model.cart.without_effect(effect.key))
        screen, none = Screen(less), effect if isinstance(effect, TimeDelay) else without_amplitudes(effect)
        gain: Callable[[Effect], float] = screen.gain
        if effect.gate is Gate.WHILE:
            softly = partial(half_sine_gain, screen)
            whole = refined(as_half_sine(none), softly)
            if softly(whole) > gain(none):
                gain, none, effect = softly, whole, with_impulse_of(effect, whole)
        found = dict[str, float]()
        for which in dict.fromkeys(move.which for move in moves(effect)):
            unit = effect.parameters[which].unit
            size = 0.02 * abs(float(effect.values[which])) if unit not in ("s", "m") else 0.01
            alone = _spread(partial(_gain_at, gain, none, which), size)
            spread = max(alone, self._joint[1].get(effect.keys[which], 0.0))
            least = {"s": MIN_TIME_STD, "m": MIN_PLACE_STD}.get(unit, 0.0)
            if effect.gate.n_parameters <= which:
                name = effect.parameters[which].name
                form = LENGTH_FORM_FRACTION * abs(float(effect.values[which]))
                least = FORCE_LEVER_STD if name in "xy" else min(least, form)
            found[effect.keys[which]] = float(np.hypot(spread, least))
        return effect, found


def _given(model: Model) -> np.ndarray:
    """Which parameters (p,) are as given: known by the cart's file, and the mass where nobody pushes."""
    known = model.guess.first_guess.known
    found = [name in known for name in PHYSICAL_NAMES]
    found[0] |= not model.is_pushed
    for effect in model.cart.effects:
        found += [effect.key in known or key in known for key in effect.keys]
    return np.array(found)


def sandwich(sums: Array, score: Score, groups: np.ndarray) -> Array:
    """Covariance (q, q) of columns whose sums of products (c, b, q + 1, q + 1) have the residual last: the larger of
    what noise makes of them, and what groups of blocks (b,) scatter (a sandwich estimator with clusters, whose
    residuals are as much larger as the fit makes them smaller: CR2, Bell and McCaffrey 2002)."""
    kept = np.tensordot(score.scale**-2.0, sums, (0, 0))
    q = len(score.fit)
    pulls = kept[:, :q, q] - kept[:, :q, :q] @ score.fit
    steps, root = [], np.linalg.cholesky(score.covariance)
    for group in np.unique(groups):
        own = groups == group
        share, axes = np.linalg.eigh(root.T @ kept[own, :q, :q].sum(axis=0) @ root)
        pull = axes.T @ root.T @ pulls[own].sum(axis=0)
        steps.append(root @ axes @ (pull / np.sqrt(np.maximum(1.0 - share, MIN_RESIDUAL_FRACTION))))
    scatter = np.array(steps).T @ np.array(steps)
    stretch = np.sqrt(np.maximum(np.diagonal(scatter) / np.diagonal(score.covariance), 1.0))
    return np.asarray(score.covariance * np.outer(stretch, stretch))


def _gain_at(gain: Callable[[Effect], float], effect: Effect, which: int, distance: float) -> float:
    """Gain of an effect with one setting farther by a distance."""
    values = effect.values.copy()
    values[which] += distance
    return gain(effect.with_values(values)) if is_open(effect, values) else -np.inf


def _spread(gain: Callable[[float], float], size: float) -> float:
    """Root of the mean square distance of a setting from the best, weighed by how likely it is there: a log in which
    nothing happens for a while does not tell when it began."""
    best = gain(0.0)

    def reach(step: float) -> float:
        for _ in range(MAX_RANGE_DOUBLINGS):
            if gain(step) < best - NEGLIGIBLE_NATS:
                break
            step *= 2
        return step

    offsets = np.linspace(reach(-size), reach(size), SETTING_GRID_POINTS)
    gains = np.array([gain(offset) for offset in offsets])
    likely = np.exp(gains - max(best, gains.max()))
    total = float(likely.sum())
    return float(np.sqrt((likely * offsets**2).sum() / total)) if total > 0 else size
