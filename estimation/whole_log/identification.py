"""A cart's parameters from whole logs, by the regression in weak form that the discrepancy workflow searches with.

Each log is learned from in the band in which the model foretells its motion; all logs' rows and the first guess add up,
in coordinates in which every cart is physical. A fit that foretells unseen stretches worse than the cart file's values
is refused, and they stay.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from cartgrasp.checks import brief, check_kind, listed
from cartgrasp.effects.time_delay import TimeDelay
from cartgrasp.errors import DataError, UsageError
from cartgrasp.frames import Array
from cartgrasp.inertia import N_PHI, Inertia
from cartgrasp.logs import RunLog
from cartgrasp.logs.alignment import aligned
from cartgrasp.model import CartModel
from cartgrasp.motion import ParameterEstimate

from ..discrepancy.findings.refusal import refused
from ..discrepancy.search.model import Model
from ..noise import FilterNoise
from ..prior import Prior, report_names, report_units
from ..weak_form.band import pooled
from ..weak_form.rows import Errors
from ..weak_form.standstill_forces import reversal_drag_errors
from .coasting import as_given
from .corrected_fit import corrected
from .log_parts import LogPart, NothingSaidError, learnable_parts

CLOCK_STD = 0.03
"""Standard deviation (s) of how late wrenches may be, by filters, drivers and clocks that nobody told: what comes late
looks like drag."""
MIN_REPORTED_DELAY, REPORTED_DELAY_SIGMAS = 0.01, 3.0
"""s, and standard deviations, beyond both of which it is told that wrenches are late."""


@dataclass(frozen=True)
class LogFit:
    """How a log fits: by what share of a step its wrenches act after they are recorded; how many times as large as its
    sensors' noise makes them the squares of what is left are; up to which frequency (Hz) it was learned from, None
    where nothing was; and what is to be said of it, in words."""

    name: str
    delay: float = 0.0
    noise_excess: float = 1.0
    band: float | None = None
    words: tuple[str, ...] = ()


@dataclass(frozen=True)
class Identification:
    """What logs say of a cart. `model_parameters` (p,) and `covariance` (p, p) are of `(phi | effects' values)`;
    `refused` says why a fit was refused, if one was."""

    structure: CartModel
    model_parameters: Array
    covariance: Array
    parameters: dict[str, ParameterEstimate]
    logs: tuple[LogFit, ...]
    refused: str = ""

    def __repr__(self) -> str:
        logs = f"{len(self.logs)} logs" + (f", refused: {self.refused}" if self.refused else "")
        told = "; ".join(f"{name} {one!r}" for name, one in self.parameters.items())
        return f"{brief('Identification', self.structure.name, logs)}\n  {told}"

    def cart(self) -> CartModel:
        """The cart with the values put in."""
        cart = self.structure.with_parameters(self.model_parameters)
        if not self.structure.constraints.no_rotation:
            return cart
        body = self.structure.inertia
        return cart.with_inertia(Inertia(cart.inertia.mass, body.com, body.about_com))

    def as_dict(self) -> dict[str, Any]:
        """The result as the command line gives it."""
        parameters = {name: asdict(parameter) for name, parameter in self.parameters.items()}
        return {"parameters": parameters, "logs": [asdict(log) for log in self.logs]}


def identify(
    logs: Sequence[RunLog],
    cart: CartModel,
    prior: Prior | None = None,
    noise: FilterNoise | None = None,
    progress: Callable[[float], None] | None = None,
) -> Identification:
    """Fits one cart to all logs at once.

    Args:
        logs: One or several, of one cart with one load.
        cart: Structure and first guess.
        prior: How sure the first guess is; `Prior()` and what the cart's file says unless given.
        noise: Of the sensors; read off each log unless given.
        progress: Is told the share done, 0 to 1.

    Raises:
        DataError: The logs can't be fitted.
        UsageError: No log, or an argument of the wrong kind.

    Example:
        >>> import cartgrasp as cg
        >>> from estimation import identify
        >>> found = identify([cg.read_log("run.csv")], cg.load_cart("cart.yaml"))
        >>> mass = found.parameters["mass"]
        >>> mass.identifiable, round(mass.value), mass.unit
        (True, 24, 'kg')
    """
    logs = listed("identify: logs", logs, RunLog, 'write [read_log("run.csv")]')
    check_kind("identify: cart", cart, CartModel, 'load it first: load_cart("cart.yaml")')
    if not logs:
        raise UsageError("identify: no log is given; at least one is needed")
    prior = prior or Prior()
    prior.free(cart)  # refuses names that the cart does not have
    tell, given = progress or (lambda _: None), cart
    logs, cart = [aligned(log, given) for log in logs], _in_time(given)
    parts, silent = list[LogPart](), dict[int, tuple[str]]()
    for i, log in enumerate(logs):
        try:
            parts += learnable_parts(i, log, cart, noise)
        except NothingSaidError as error:
            silent[i] = (str(error),)
        tell((i + 1) / (len(logs) + 2))
    if not parts:
        return _as_believed(logs, given, prior, silent)
    try:
        with np.errstate(over="raise", invalid="raise"):
            found = _fitted(logs, cart, prior, parts, silent)
        if not np.isfinite(found.model_parameters).all() or not np.isfinite(found.covariance).all():
            raise FloatingPointError("the fit is not finite")
    except (np.linalg.LinAlgError, FloatingPointError) as error:
        names = ", ".join(log.name for log in logs)
        raise DataError(f"{names}: can't be fitted; look for numbers that are not in SI units") from error
    return found if given is cart else _late_again(found, given)


def _in_time(cart: CartModel) -> CartModel:
    """The cart with sensors that are not late, for logs that are brought back in time."""
    late = [isinstance(effect, TimeDelay) for effect in cart.effects]
    effects = tuple(TimeDelay(0.0, label=e.label) if own else e for e, own in zip(cart.effects, late, strict=True))
    return replace(cart, effects=effects) if any(late) else cart


def _late_again(found: Identification, cart: CartModel) -> Identification:
    """The identification with the delays as they were given."""
    values, told = found.model_parameters.copy(), dict(found.parameters)
    for i, name in enumerate(report_names(cart)):
        if name.startswith(f"{TimeDelay.name}."):
            values[i] = cart.parameters[i]
            told[name] = replace(told[name], value=float(values[i]))
    return replace(found, structure=cart, model_parameters=values, parameters=told)


def _fitted(
    logs: Sequence[RunLog], cart: CartModel, prior: Prior, parts: Sequence[LogPart], silent: dict[int, tuple[str]]
) -> Identification:
    model = _as_loud(Model.started([part.balances for part in parts], cart, prior, CLOCK_STD))
    found = corrected(replace(model, at_bound=None))
    fits = _log_fits(logs, found.model, parts, silent)
    why = refused(found.model, cart)
    if why:
        fits = tuple(replace(fit, words=(*fit.words, why)) for fit in fits)
        return replace(_as_believed(logs, cart, prior, {}), logs=fits, refused=why)
    found = found.between(pooled([(part.band, part.band.open_share) for part in parts if part.band is not None]))
    told = _told(logs, cart, prior, *found.physical(), found.taught(prior.deviations(cart)))
    return Identification(cart, found.model.cart.parameters, found.parameter_covariance, told, fits)


def _as_loud(model: Model) -> Model:
    """Refitted to rows whose noise is alike throughout, but where the cart nearly stands, and as large as what is left
    of them: were it as large as sensors look, or a search is cautious, the first guess would count for too much."""
    for _ in range(2):
        none = np.zeros_like(model.noise.form)
        errors = [replace(Errors.of(b, model.cart), friction=reversal_drag_errors(b, model.cart)) for b in model.logs]
        own = tuple(one.whitening(model.noise.excess, none, np.ones_like(none)) for one in errors)
        model = replace(model, whitenings=own)
        scale = model.score.scale
        model = replace(model, whitenings=tuple(w.louder(scale) for w in model.whitenings)).refitted(model.cart)
    return model


def _as_believed(
    logs: Sequence[RunLog], cart: CartModel, prior: Prior, silent: dict[int, tuple[str]]
) -> Identification:
    """The first guess."""
    body = cart.inertia
    values = np.array([body.mass, *body.com, body.about_com, *cart.parameters[N_PHI:]])
    told = _told(logs, cart, prior, values, prior.deviations(cart), np.zeros(len(values), dtype=bool))
    covariance, free = np.zeros((len(cart.parameters),) * 2), prior.free(cart)
    covariance[np.ix_(free, free)] = prior.covariance(cart)[np.ix_(free, free)]
    fits = tuple(LogFit(log.name, words=silent.get(i, ())) for i, log in enumerate(logs))
    return Identification(cart, cart.parameters.copy(), covariance, told, fits)


def _told(
    logs: Sequence[RunLog], cart: CartModel, prior: Prior, values: Array, std: Array, taught: np.ndarray
) -> dict[str, ParameterEstimate]:
    """The parameters (p,) by name: what is known, or taken as given where nobody pushes, has no deviation."""
    names, held, given = report_names(cart), prior.held(cart), as_given(logs, cart)
    if cart.constraints.no_rotation:
        held[1:N_PHI] = False
    std = np.where(held | [name in given for name in names], 0.0, std)
    rows = zip(values.tolist(), std.tolist(), report_units(cart), taught.tolist(), strict=True)
    return {name: ParameterEstimate(*row) for name, row in zip(names, rows, strict=True)}


def _log_fits(
    logs: Sequence[RunLog], model: Model, parts: Sequence[LogPart], silent: dict[int, tuple[str]]
) -> tuple[LogFit, ...]:
    """The fit of each log; of a log that is cut, the longest part tells."""
    excess, delays = _excess(model), model.score.fit[-len(parts) :]
    deviations = np.sqrt(np.diagonal(model.score.covariance)[-len(parts) :])
    found = []
    for i, log in enumerate(logs):
        own = [k for k, part in enumerate(parts) if part.log == i]
        if not own:
            found.append(LogFit(log.name, words=silent.get(i, ())))
            continue
        k = max(own, key=lambda k: len(parts[k].balances.used))
        delay = -float(delays[k]) / parts[k].balances.sample_step
        words = _late(log, float(delays[k]), float(deviations[k]) * math.sqrt(max(1.0, excess[k])))
        found.append(LogFit(log.name, delay, float(excess[k]), 0.5 / parts[k].balances.row_step, words))
    return tuple(found)


def _late(log: RunLog, lag: float, std: float) -> tuple[str, ...]:
    """What is said of wrenches that are late by a lag (s)."""
    if abs(lag) < max(MIN_REPORTED_DELAY, REPORTED_DELAY_SIGMAS * std):
        return ()
    words = (
        f"{log.name}: its wrenches come {abs(lag):.3f} ± {std:.3f} s {'after' if lag > 0 else 'before'} the motion: "
        "allowed for here, and by filters; mend the clocks, or give the cart file a time_delay"
    )
    return (words,)


def _excess(model: Model) -> list[float]:
    """The mean square residual of each part, whitened by its sensors' noise alone, in the balance with most."""
    found, at = [], 0
    for balances in model.logs:
        left = model.residual[at : at + len(balances.used)]
        at += len(balances.used)
        none, whole = np.zeros(left.shape[1]), np.ones(left.shape[1])
        whiten = Errors.of(balances, model.cart).whitening(none, none, whole)
        found.append(float(((whiten(left) ** 2).sum(axis=0) / whiten.counts.sum(axis=0)).max()))
    return found
