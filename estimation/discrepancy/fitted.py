"""A structure fitted to logs: its values, what was believed of them, and how its residuals scatter."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.linalg import block_diag

from cartgrasp.effects import Effect
from cartgrasp.frames import Array
from cartgrasp.model import CartModel
from cartgrasp.wheels import FIXED

from ..batch.identification import Identification, fit
from ..batch.linearisation import Linearisation
from ..batch.noise_colour import NoiseColour, colour_of
from ..batch.wrench_regression import WrenchRegression
from ..prior import Prior, report_names
from .dictionary import Dictionary, build_dictionary
from .evidence import Base
from .forms import BLUR, Forms
from .generic import Course, Dependence, dependences
from .polygon import Polygon
from .scatter import Scatter, noise_excess

SURE = 12.0
"""Log of the Bayes factor of a dependence that is told."""
SETTLED, ROUGH = 0.03, 0.1
"""Standard deviations: by what a fit's last round moves a parameter; and that of an effect which is only tried."""
LISTENING, HEARD = 6, 5e-4
"""Rounds, and s: to read how late wrenches are."""
UNUSUAL = 2.0
"""Deviations of what is believed of a delay."""
DRAWS = 4
"""Of the smoothed motion's errors."""
EFFECTS_SHARE = 1.0
ADDED_SHARE = 10.0
"""Of its typical size: the standard deviation of an added effect before data, which tell nearly all."""


@dataclass(frozen=True, eq=False)
class Fitted:
    """`prior_cart` is what was believed; `added` the effects that a search has put on it; `start` parameters near the
    best ones; `moves` what the last round of the fit may move (standard deviations)."""

    regressions: tuple[WrenchRegression, ...]
    prior_cart: CartModel
    added: tuple[Effect, ...] = ()
    start: Array | None = None
    moves: float = SETTLED

    @cached_property
    def prior(self) -> Prior:
        std = {
            key: ADDED_SHARE * p.typical
            for effect in self.added
            for key, p in zip(effect.keys, effect.parameters, strict=True)
        }
        return Prior(effects=EFFECTS_SHARE, std=std)

    @cached_property
    def structure(self) -> CartModel:
        return replace(self.prior_cart, effects=(*self.prior_cart.effects, *self.added))

    @cached_property
    def identification(self) -> Identification:
        return fit(self.structure, self.prior, self.regressions, self.start, self.moves)

    @cached_property
    def cart(self) -> CartModel:
        return self.identification.cart()

    @property
    def delays(self) -> tuple[float, ...]:
        return tuple(log.delay for log in self.identification.logs)

    @property
    def is_late(self) -> bool:
        """Whether wrenches of a log fit best at a share of a step that is not usual."""
        usual = (regression.usual_delay for regression in self.regressions)
        return any(abs(delay - mean) > UNUSUAL * std for delay, (mean, std) in zip(self.delays, usual, strict=True))

    @cached_property
    def linearised(self) -> tuple[tuple[WrenchRegression, Linearisation, float], ...]:
        found = []
        for regression, delay in zip(self.regressions, self.delays, strict=True):
            own = regression.with_cart(self.cart)
            found.append((own, own.linearised(self.cart.parameters, delay), delay))
        return tuple(found)

    @cached_property
    def free(self) -> np.ndarray:
        """Slopes that make the base: of the free parameters, and of the delay."""
        return np.append(self.prior.free(self.structure), len(self.structure.parameters))

    @cached_property
    def base(self) -> Base:
        own = self.free[:-1]
        information = np.zeros((len(own) + 1, len(own) + 1))
        information[:-1, :-1] = np.linalg.inv(self.prior.covariance(self.structure)[np.ix_(own, own)])
        delay, std = np.mean([regression.usual_delay for regression, _, _ in self.linearised], axis=0)
        information[-1, -1] = std**-2
        first = np.append(self.structure.parameters[own], delay)
        now = np.append(self.cart.parameters[own], np.mean(self.delays))
        return Base(information, information @ (first - now))

    def dictionary(self, effects: Sequence[Effect]) -> Dictionary:
        return build_dictionary(self.linearised, effects, self.loose_columns)

    @cached_property
    def shares(self) -> Array:
        """Of each added effect, what it adds to the free parameters and the delay (p + 1, effects)."""
        places = {name: i for i, name in enumerate(report_names(self.cart))}
        whole = np.zeros((len(self.cart.parameters) + 1, len(self.added)))
        for k, effect in enumerate(self.added):
            for key, parameter in zip(effect.keys, effect.parameters, strict=True):
                whole[places[key], k] = self.cart.parameters[places[key]] - parameter.absent
        return np.asarray(whole[self.free])

    def forms(self, regression: WrenchRegression, line: Linearisation, keys: Collection[str] | None = None) -> Forms:
        """Of added effects, or of those among them with `keys`, on rows of a log around this fit."""
        traces = line.by[..., self.free] @ self.shares
        chosen = [k for k, effect in enumerate(self.added) if keys is None or effect.key in keys]
        return Forms.of(regression, line, [(self.added[k], traces[..., k]) for k in chosen])

    @cached_property
    def other_forms(self) -> tuple[Forms, ...]:
        """Of all added effects, on each log."""
        return tuple(self.forms(regression, line) for regression, line, _ in self.linearised)

    @cached_property
    def loose_columns(self) -> tuple[Array, ...]:
        """Of each log, slopes (m, f, b) by the base's parameters, and what other forms of all logs' effects add."""
        forms = [each.columns for each in self.other_forms]
        count, found, at = sum(each.shape[2] for each in forms), [], 0
        for (_, line, _), own in zip(self.linearised, forms, strict=True):
            beside = np.zeros((*line.residual.shape, count))
            beside[..., at : at + own.shape[2]] = own
            found.append(np.concatenate([line.by[..., self.free], beside], axis=2))
            at += own.shape[2]
        return tuple(found)

    @cached_property
    def loose(self) -> Base:
        """The base, with other forms of the added effects as unknowns beside its parameters."""
        known, n = self.base, self.loose_columns[0].shape[2]
        p = len(known.pull)
        information = np.eye(n)
        information[:p, :p] = known.information
        return Base(information, np.append(known.pull, np.zeros(n - p)))

    def with_added(self, effect: Effect) -> Fitted:
        start = np.append(self.cart.parameters, effect.values)
        return replace(self, added=(*self.added, effect), start=start)

    def with_changed(self, effect: Effect, changed: Effect) -> Fitted:
        """With another setting of an effect that was added."""
        if np.array_equal(changed.values, effect.values):
            return self
        added = tuple(changed if one is effect else one for one in self.added)
        known = tuple(changed if one.key == changed.key else one for one in self.cart.effects)
        return replace(self, added=added, start=replace(self.cart, effects=known).parameters)

    def on(self, regressions: tuple[WrenchRegression, ...]) -> Fitted:
        """The same structure, fitted to other rows."""
        return replace(self, regressions=regressions, start=self.cart.parameters)

    def coloured(self) -> Fitted:
        """With the colour of all that is left where wrenches' noise is: errors of the smoothed motion are in it, and
        what the model leaves out."""
        found = []
        for regression, line, _ in self.linearised:
            standard = (np.swapaxes(np.linalg.cholesky(line.weights), 1, 2) @ line.residual[..., None])[..., 0]
            found.append(regression.coloured(colour_of(line.time, standard, regression.size)))
        return replace(self, regressions=tuple(found), start=self.cart.parameters)

    @cached_property
    def colours(self) -> tuple[NoiseColour | None, ...]:
        """Of the wrenches' own noise in each log, without what errors of the smoothed motion are in the residuals."""
        found, generator = [], np.random.default_rng(0)
        for regression, line, _ in self.linearised:
            root = np.linalg.cholesky(regression.wrench_covariance[line.nodes // regression.size])
            missed = [line.missed(regression.motion.drawn(generator)) for _ in range(DRAWS)]
            parts = np.linalg.solve(root, np.stack([line.residual, *missed], axis=2))
            known = parts[..., 1:].reshape(len(parts), -1)
            found.append(colour_of(line.time, parts[..., 0], regression.size, known))
        return tuple(found)

    @cached_property
    def own_excess(self) -> float:
        """As `excess`, where noise has these colours."""
        found = []
        for (regression, _, delay), colour in zip(self.linearised, self.colours, strict=True):
            own = regression.coloured(colour)
            found.append((own, own.linearised(self.cart.parameters, delay), delay))
        return noise_excess(found)

    def settled(self) -> Fitted:
        """Fitted once more, from where the fit ended, and to the end."""
        return replace(self, start=self.cart.parameters, moves=SETTLED)

    def tried(self, effect: Effect) -> Fitted:
        """With another effect, as far as a comparison needs."""
        return replace(self.with_added(effect), moves=ROUGH).listening()

    def listening(self) -> Fitted:
        """With the lateness of an added effect where the log has it, round by round: its wrenches are aligned by whole
        samples, and what is left is read beside all else. Between two alignments, each of which asks for the other, it
        stays."""
        found, known = self, list[float]()
        while len(known) < LISTENING:
            late = next((e for e in found.added if e.lateness > 0), None)
            if late is None:
                break
            known.append(late.lateness)
            aim = late.with_values(np.maximum(late.values + found._unheard, 0.0))
            if min(abs(aim.lateness - one) for one in known) < HEARD:
                break
            found = found.with_changed(late, aim)
        return found

    @property
    def _unheard(self) -> float:
        """By how much later (s) than the cart's sensors say wrenches are recorded. To take a wrench between two rows
        smooths it, and is not quite a shift, so the second and third differences are unknowns beside it."""
        p = len(self.base.pull)
        information, pull = block_diag(self.loose.information, np.ones((1, 1))), np.append(self.loose.pull, 0.0)
        information[p - 1, p - 1] = pull[p - 1] = 0.0
        for (regression, line, _), known in zip(self.linearised, self.loose_columns, strict=True):
            columns = np.concatenate([known, BLUR * regression.skews()[..., None]], axis=2)
            taught, drawn = line.taught(columns)
            information, pull = information + taught, pull + drawn
        for regression, _, delay in self.linearised:
            pull[:p] += regression.evidence(self.cart.parameters, delay).drag.sum(axis=0)[self.free]
        share = float(np.linalg.solve(information, pull)[p - 1])
        logs = [(r.usual_delay[0] - d - share) * r.step * r.size for r, _, d in self.linearised]
        return float(np.mean(logs))

    def without(self, key: str) -> Fitted:
        left, known = (tuple(e for e in effects if e.key != key) for effects in (self.added, self.cart.effects))
        return replace(self, added=left, start=replace(self.cart, effects=known).parameters)

    def without_all(self, keys: Iterable[str]) -> Fitted:
        """One after the other."""
        found = self
        for key in keys:
            found = found.without(key)
        return found

    @property
    def n_rows(self) -> int:
        """That have every wrench: where sensors are late, those of lost samples are others."""
        return sum(len(line.time) for _, line, _ in self.linearised)

    def chi_squared(self, keys: Collection[str] = ()) -> float:
        """Of the residuals, beside other forms of added effects with `keys`, and of the parameters and delays against
        what was believed of them."""
        total = sum(line.chi_squared - self.forms(r, line, keys).taken(line) for r, line, _ in self.linearised)
        for regression, _, delay in self.linearised:
            usual, std = regression.usual_delay
            total += ((delay - usual) / std) ** 2
        own = self.free[:-1]
        moved = (self.cart.parameters - self.structure.parameters)[own]
        return total + float(moved @ self.base.information[:-1, :-1] @ moved)

    @cached_property
    def polygon(self) -> Polygon:
        """Of the residual, in which a dependence is looked for."""
        return Polygon.of([line for _, line, _ in self.linearised])

    @cached_property
    def dependences(self) -> list[Dependence]:
        """What the residual follows, the most probable first."""
        tracks = sorted({0.0, *(wheel.y for wheel in self.cart.wheels if wheel.kind == FIXED)})
        motions = [regression.motion for regression in self.regressions]
        return dependences(self.polygon, Course.of(self.polygon.time, self.polygon.log, motions, tracks))

    def follows(self, lasts: bool) -> Dependence | None:
        """The most probable dependence, where it is sure; against what lasts, none unless it has a period or is of the
        floor: motion that is repeated makes all that follows the speed come again with the way."""
        known = (d for d in self.dependences if d.log_factor > SURE and not (lasts and d.is_drag))
        first = next(known, None)
        return first if first is not None and (first.is_periodic or first.is_of_the_floor or not lasts) else None

    def misfit(self, direction: int) -> float:
        """The weighed squares of the residual's polygon along one free direction."""
        return float(np.square(self.polygon.standard(direction)).sum())

    @cached_property
    def scatter(self) -> Scatter:
        return Scatter.of(self.linearised, self.excess)

    @cached_property
    def excess(self) -> float:
        """How many times too small the noise variance of long means is believed to be."""
        return noise_excess(self.linearised)
