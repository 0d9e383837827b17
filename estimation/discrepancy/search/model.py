"""A structure fitted to logs: whitened rows of all of them, and their score."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import accumulate, pairwise

import numpy as np

from cartgrasp.effects import ConstraintEffect, Effect
from cartgrasp.effects.effect import Gate
from cartgrasp.frames import Array
from cartgrasp.inertia import N_PHI
from cartgrasp.model import CartModel

from ...log_noise.log_noise import MAD_TO_STD
from ...prior import Prior, report_names
from ...weak_form.balances import Balances
from ...weak_form.coordinates import ParameterPrior, coordinates, jacobian
from ...weak_form.linearized import Nuisance, fit
from ...weak_form.motion import Motion
from ...weak_form.rows import Errors, excess_noise
from ...weak_form.score import Folds, Score, scored
from ...weak_form.wheel_tracks import touches
from ...weak_form.whitening import Whitening
from .candidates import amplitudes_of
from .laws import Law, labelled

LOG_MASS_PRIOR_STD, COM_PRIOR_STD = 1.5, 0.5
"""Prior standard deviations of the logarithms of mass and inertia, and of the CoM (m)."""
SCREENING_PRIOR_RATIO, AMPLITUDE_PRIOR_RATIO = 2.0, 10.0
"""Prior standard deviations of an amplitude where candidates are screened, and where a cart with one is fitted, in
multiples of the effect's usual size."""
FILE_PRIOR_VALUE_FRACTION, FILE_PRIOR_SIZE_FRACTION = 0.25, 0.05
"""Prior standard deviation of an effect of the cart file: share of its value there, and at least a share of its usual
size."""
FORCE_LEVER_STD = 0.05
"""Prior standard deviation (m) of where an effect's force acts, about where the model says."""
TIMING_STD_FRACTION = 0.3
"""Prior standard deviation of a lateness, as a share of a sample's step: some sensors hold a sample until the next,
others average."""
SETTLING_ROUNDS = 3
LONG_MEAN_INTERVAL, MIN_LONG_MEANS = 2.0, 8
"""Duration (s) of long means, as long as a push; and how many tell their usual size: shorter ones where a log has no
more."""


def structure_prior(
    cart: CartModel,
    guess: CartModel,
    wide: frozenset[str] = frozenset(),
    is_pushed: bool = True,
    believed: Prior | None = None,
) -> ParameterPrior:
    """Prior of a cart like the guess, broad unless one is `believed`. Effects are as large as the guess says, but for
    those that are `wide`; added ones may have any size. What the cart's file says of its first guess counts. The mass
    of a cart that nobody pushes is as given: motion tells CoM, inertia and forces by their shares of it."""
    mean, first = coordinates(cart), coordinates(guess)
    std, free = np.ones(len(mean)), np.ones(len(mean), dtype=bool)
    mean[:N_PHI] = first[:N_PHI]
    std[:N_PHI] = LOG_MASS_PRIOR_STD, COM_PRIOR_STD, COM_PRIOR_STD, LOG_MASS_PRIOR_STD
    parameters = [(p, key) for effect in cart.effects for p, key in zip(effect.parameters, effect.keys, strict=True)]
    known = {
        key: v for e in guess.effects if e.key not in wide for key, v in zip(e.keys, e.values.tolist(), strict=True)
    }
    for i, (p, key) in enumerate(parameters, N_PHI):
        if key in known and not (p.optional and known[key] == p.absent):
            mean[i], free[i] = known[key], p.estimated
            std[i] = max(FILE_PRIOR_VALUE_FRACTION * abs(known[key]), FILE_PRIOR_SIZE_FRACTION * p.typical)
            continue
        is_place = p.name in ("x", "y", "trail") and bool(p.grid)
        mean[i] = mean[i] if is_place else p.absent
        std[i] = 2 * p.typical if is_place else AMPLITUDE_PRIOR_RATIO * p.typical
        free[i] = p.estimated
    told = _prior_stds(guess, believed)
    for i, name in enumerate(report_names(cart)):
        if name in told and name.rpartition(".")[0] not in wide:
            std[i] = told[name]
    free &= ~(believed or Prior()).held(cart)
    if not is_pushed:
        free[0] = False
    return ParameterPrior(mean, std, free)


def _prior_stds(guess: CartModel, believed: Prior | None) -> dict[str, float]:
    """Standard deviations by name that are told, those of mass and inertia of the logarithm."""
    if believed is None:
        told = dict(guess.first_guess.std)
    else:
        told = dict(zip(report_names(guess), believed.deviations(guess).tolist(), strict=True))
    sizes = {"mass": guess.inertia.mass, "inertia": guess.inertia.about_com}
    return {name: std / sizes.get(name, 1.0) for name, std in told.items()}


@dataclass(frozen=True, eq=False)
class RowNoise:
    """What rows are whitened by: of the sensors, of a cart's inertia and friction, white noise (c,) beside them, the
    shares (c,) of what forms, and dry friction near standstill, may be wrong by; and, where models are compared, what
    neighbours share (`memory`, c,)."""

    cart: CartModel
    noise_scale: float
    excess: Array
    form: Array
    friction: Array
    memory: Array

    def whitenings(self, logs: Sequence[Balances]) -> tuple[Whitening, ...]:
        """Whitenings of rows that are not to be compared."""
        return tuple(self.whitening(Errors.of(balances, self.cart, False), False) for balances in logs)

    def beside(self, errors: Errors) -> Balances:
        """Rows with this cart as their reference, and this noise."""
        heard = errors.heard(self.excess, self.form, self.friction, self.noise_scale)
        return errors.balances.beside(self.cart, heard)

    def whitening(self, errors: Errors, compares: bool) -> Whitening:
        return errors.whitening(self.excess, self.form, self.friction, self.memory if compares else None)


# Many methods: what is derived of one fit to logs (rows, sums, colour, score), each kept once it was asked for, since
# hundreds of candidates ask for the same.
@dataclass(frozen=True, eq=False)
class Model:
    """A cart fitted to logs, to be compared with others on rows that are whitened alike; `laws` are what the logs
    follow and no effect of the vocabulary makes; `candidates` may be missing, too;
    `band_steps` (s) are those of the bands in which logs tell the mass; `clock_std` (s) is the standard deviation of
    what else wrenches may be late by, which an effect tells where one is looked for. Where models are compared, rows
    are told apart from what neighbours and balances share. To fit one they are not: that would weigh what changes fast,
    which models know least, and hand what is missing in one balance to another; the deviations of a fit allow for it
    (`certainty.py`)."""

    guess: CartModel
    cart: CartModel
    logs: tuple[Balances, ...]
    noise: RowNoise
    whitenings: tuple[Whitening, ...]
    laws: tuple[Law, ...] = ()
    wide: frozenset[str] = frozenset()
    believed: Prior | None = None
    at_bound: np.ndarray | None = None
    candidates: tuple[Effect, ...] = ()
    compares: bool = False
    band_steps: tuple[float | None, ...] = ()
    clock_std: float = 0.0

    @property
    def is_pushed(self) -> bool:
        """Whether any log has a wrench."""
        return any(balances.wrenches.arms for balances in self.logs)

    @cached_property
    def prior(self) -> ParameterPrior:
        """Prior of the coordinates, in which those at a bound are fixed."""
        known = self._prior_of(self.cart)
        return known if self.at_bound is None else replace(known, free=known.free & ~self.at_bound)

    def _prior_of(self, cart: CartModel) -> ParameterPrior:
        return structure_prior(cart, self.guess, self.wide, self.is_pushed, self.believed)

    @classmethod
    def started(
        cls, logs: Sequence[Balances], guess: CartModel, believed: Prior | None = None, clock_std: float = 0.0
    ) -> Model:
        """The guess refitted, with a prior that is broad unless one is believed; the noise is what it leaves."""
        whole = np.ones(logs[0].n_balances(guess))
        noise = RowNoise(guess, 1.0, 0.0 * whole, 0.0 * whole, whole, 0.0 * whole)
        own = tuple(balances.beside(guess) for balances in logs)
        return cls(guess, guess, own, noise, noise.whitenings(own), believed=believed, clock_std=clock_std).settled()

    def settled(self) -> Model:
        """The model fitted on rows whose noise is what this fit leaves."""
        model = self
        for _ in range(SETTLING_ROUNDS):
            model = model.refitted(model.cart).rewhitened()
        return model.refitted(model.cart)

    def rewhitened(self) -> Model:
        """The model on rows whose noise is what it leaves."""
        errors = (Errors.of(balances, self.cart, self.compares) for balances in self.logs)
        parts = list(zip(errors, by_log(self.residual, self.logs), strict=True))
        noise = RowNoise(self.cart, *excess_noise(parts, float(self.rows.shape[2] - 1)))
        whitenings = tuple(noise.whitening(own, self.compares) for own, _ in parts)
        logs = tuple(noise.beside(own) for own, _ in parts)
        return replace(self, logs=logs, noise=noise, whitenings=whitenings)

    def whitened(self, columns: Sequence[Array]) -> Array:
        """Whitened columns (k, c, q) of all logs together, from each log's raw ones."""
        return np.concatenate([whiten(own) for whiten, own in zip(self.whitenings, columns, strict=True)])

    @cached_property
    def nuisance(self) -> Nuisance:
        """Sizes of constraint effects, laws, levers of effects' forces, and how late each log's wrenches are."""
        cart, found = self.cart, []
        constraints = cart.constraint_effects
        forces = [e for e, _, _ in cart.force_effects] if cart.constraints.n_free > 1 else []
        for i, balances in enumerate(self.logs):
            parts = [balances.columns(cart.without_effect(e.key), e) for e in constraints]
            parts += [law.columns(balances, cart) for law in self.laws]
            parts += [balances.lever(cart, e) for e in forces]
            timing = np.zeros((len(balances.used), balances.n_balances(cart), len(self.logs)))
            timing[..., i] = balances.timing(cart)
            found.append(np.concatenate([*parts, timing], axis=2))
        std = [np.ones(len(constraints)), *(law.std for law in self.laws), np.full(len(forces), FORCE_LEVER_STD)]
        steps = np.array([balances.sample_step for balances in self.logs])
        std.append(np.hypot(TIMING_STD_FRACTION * steps, self.clock_std))
        return Nuisance(tuple(found), np.concatenate(std))

    @cached_property
    def _raw(self) -> list[Array]:
        prior = self.prior
        by, found = jacobian(self.cart), []
        for balances, beside in zip(self.logs, self.nuisance.columns, strict=True):
            left, slopes = balances.residual(self.cart)
            own = (slopes @ by)[..., prior.free]
            left = left + own @ self.moved
            found.append(np.concatenate([own, beside, left[..., None]], axis=2))
        return found

    @cached_property
    def moved(self) -> Array:
        """How far the free coordinates are from their priors' means."""
        prior = self.prior
        return np.asarray((coordinates(self.cart) - prior.mean)[prior.free])

    @cached_property
    def rows(self) -> Array:
        """Whitened rows (k, c, q + 1), last the residual where every coordinate is at its prior's mean."""
        return self.whitened(self._raw)

    @cached_property
    def residual(self) -> Array:
        """What is left of the raw rows (k, c) at the best linear fit."""
        return self._residual_of(self._raw)

    def residual_on(self, logs: tuple[Balances, ...]) -> Array:
        """What the same fit leaves on other rows (k, c) of the logs."""
        return self.residual if logs is self.logs else self._residual_of(replace(self, logs=logs)._raw)

    def _residual_of(self, raw: Sequence[Array]) -> Array:
        rows = np.concatenate(raw)
        return np.asarray(rows[..., -1] - rows[..., :-1] @ self.score.fit)

    @cached_property
    def variance_inflation(self) -> float:
        """How many times larger the variance of long means of what is left is than if rows were independent, in most of
        the log: what drifts looks like a push here and there."""
        return self.variance_inflation_beside(self.rows, self.score)

    def variance_inflation_beside(self, rows: Array, score: Score) -> float:
        """`variance_inflation` of rows (k, c, q + 1) with more columns, and their score."""
        standard = (rows[..., -1] - rows[..., :-1] @ score.fit) / score.scale
        size = max(min(round(LONG_MEAN_INTERVAL / self.logs[0].row_step), len(standard) // MIN_LONG_MEANS), 1)
        count = len(standard) // size
        means = standard[: count * size].reshape(count, size, -1).mean(axis=1) * size**0.5
        typical = MAD_TO_STD * np.median(np.abs(means), axis=0)
        return float(max(1.0, *(typical[: self.cart.constraints.n_free] ** 2)))

    def acts_once(self, effect: Effect) -> bool:
        """Whether an effect acts for one stretch of time alone, as a push does, or a patch of the floor that is crossed
        once. A load that changes stays, and every acceleration shows it."""
        if effect.gate is not Gate.INSIDE:
            return effect.gate.ends
        wheels, region = self.cart.wheel_set, effect.values[:4]
        inside = [np.diff(touches(b.motion.pose, region, wheels).astype(int), prepend=0) > 0 for b in self.logs]
        return sum(int(begins.sum()) for begins in inside) < 2

    def deviation(self, key: str) -> float:
        """Standard deviation of a free parameter of an effect, by its full name."""
        keys = [key for effect in self.cart.effects for key in effect.keys]
        place = int(self.prior.free[: N_PHI + keys.index(key)].sum())
        return float(self.score.covariance[place, place] ** 0.5)

    @cached_property
    def prior_std(self) -> Array:
        prior = self.prior
        return np.concatenate([prior.std[prior.free], self.nuisance.std])

    @cached_property
    def law_places(self) -> tuple[slice, ...]:
        """Where each law's numbers stand among the rows' columns."""
        first = int(self.prior.free.sum()) + len(self.cart.constraint_effects)
        edges = accumulate((law.size for law in self.laws), initial=first)
        return tuple(slice(begin, end) for begin, end in pairwise(edges))

    @property
    def motions(self) -> list[Motion]:
        return [balances.motion for balances in self.logs]

    @property
    def cart_with_laws(self) -> CartModel:
        """The cart with the laws as effects."""
        return self.with_laws(self.cart, self.score.fit)

    def with_laws(self, cart: CartModel, numbers: Array) -> CartModel:
        """A cart with the laws as effects, of such numbers (q,) of the rows' columns."""
        for law, place in zip(self.laws, self.law_places, strict=True):
            for effect in law.sized(numbers[place]):
                cart = cart.with_effect(labelled(effect, cart))
        return cart

    @cached_property
    def folds(self) -> Folds:
        return Folds.joined([Folds.of(balances.time, balances.row_step) for balances in self.logs])

    @cached_property
    def counts(self) -> Array:
        """How many rows each block has, by balance (c, b)."""
        return self.folds.counted(np.concatenate([whiten.counts for whiten in self.whitenings]))

    @cached_property
    def sums(self) -> Array:
        """Products of the rows' columns, by balance and block."""
        return self.folds.sums(self.rows)

    @cached_property
    def score(self) -> Score:
        start = np.ones(self.rows.shape[1])
        return scored(self.sums, self.counts, self.prior_std, self.folds, start)

    def rows_with(self, columns: Array) -> Array:
        """Rows with whitened columns (k, c, q) more."""
        return np.concatenate([self.rows[..., :-1], columns, self.rows[..., -1:]], axis=2)

    def with_columns(self, columns: Array, std: Array) -> Score:
        """The score with whitened columns (k, c, q) more."""
        whole = self.rows_with(columns)
        start, prior = self.score.scale, np.concatenate([self.prior_std, std])
        return scored(self.folds.sums(whole), self.counts, prior, self.folds, start)

    def columns_of(self, effect: Effect, share: Callable[[Array], Array] | None = None) -> tuple[Array, Array]:
        """Whitened columns (k, c, q) of an effect's amplitudes, and their prior standard deviations (q,); `share` of
        times (n,) says how much of it is there."""
        shares = [share and share(balances.motion.time) for balances in self.logs]
        raw = [balances.columns(self.cart, effect, own) for balances, own in zip(self.logs, shares, strict=True)]
        if isinstance(effect, ConstraintEffect):
            return self.whitened(raw), np.array([3.0])
        own = amplitudes_of(effect)
        std = np.array([SCREENING_PRIOR_RATIO * effect.parameters[i].typical for i in own])
        return self.whitened([each[..., own] for each in raw]), std

    def felt_by(self, cart: CartModel) -> Model:
        """The model with each arm's wrenches as late as a cart's sensors are."""
        late = (b.late(delays) for b, delays in zip(self.logs, _lateness(cart, self.logs), strict=True))
        return replace(self, logs=tuple(late))

    @property
    def wrench_delay(self) -> float:
        """Lateness (s) of the latest arm."""
        return max((late for of_log in _lateness(self.cart, self.logs) for late in of_log), default=0.0)

    def refitted(self, cart: CartModel) -> Model:
        """Another structure, fitted on rows that are whitened alike."""
        base = self if _lateness(cart, self.logs) == _lateness(self.cart, self.logs) else self.felt_by(cart)
        model = replace(base, cart=cart, at_bound=None)
        prior = self._prior_of(cart)
        found = fit(list(zip(base.logs, base.whitenings, strict=True)), cart, prior, model.nuisance)
        return replace(model, cart=found.resized(), at_bound=found.at_bound)


def by_log(rows: Array, logs: Sequence[Balances]) -> list[Array]:
    """What rows (k, ...) of all logs together have, by log."""
    return np.split(rows, np.cumsum([len(balances.used) for balances in logs])[:-1])


def _lateness(cart: CartModel, logs: Sequence[Balances]) -> list[list[float]]:
    """Lateness (s) of each log's arms."""
    return [[cart.lateness(arm) for arm in balances.wrenches.arms] for balances in logs]
