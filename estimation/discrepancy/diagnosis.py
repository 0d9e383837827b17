"""The discrepancy workflow: logs and a cart in; what the cart's model lacks, with its proof, out."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from cartgrasp.errors import DataError, UsageError
from cartgrasp.inertia import Inertia
from cartgrasp.logs import RunLog
from cartgrasp.logs.coasting import without_idle_arms
from cartgrasp.model import CartModel
from cartgrasp.motion import ParameterEstimate

from ..end_stops import StopEstimate, end_stops
from ..glitches import without_glitches
from ..impacts import Impact, impacts
from ..sensor_check import check_sizes, of_wrenches, put_right
from ..weak_form.balances import Balances
from ..weak_form.band import Band, bands, consistent, is_narrower
from ..weak_form.flights import flights, unbroken
from ..weak_form.rows import wrench_noise
from .certainty import Certainty
from .clock_offset import clock_offsets
from .gap import Gap, held_out_rollouts, measured_gap
from .isolability import Isolability, isolability
from .laws import Law
from .log_check import LogCheck, check_rows, checked, is_long_enough, moves, with_clock_offsets, with_suspicions
from .model import Model
from .named import NamedEffect, faded, named, named_stops
from .next_experiments import next_experiments
from .refusal import is_worse, refused
from .residual import DIRECTIONS, Residual, residuals
from .residual_map import ResidualMap, residual_maps
from .rivals import undecided
from .rollouts import starts
from .search import Step, added, search
from .where import Disagreement, where

if TYPE_CHECKING:
    from .report import Report

BEYOND_NOISE = 2.0
"""Times what noise alone makes of rollouts, and of the rows: a larger gap is a disagreement."""
LONGEST_HOLE = 30.0
"""s without a pose, from which on a log is two: simulations across it would only cost time."""
CLOSED = 0.05
"""Of the squared gap above the noise floor: what may be left beyond noise where the effects explain it."""


@dataclass(frozen=True, eq=False)
class Diagnosis:
    """What came out. `nominal` is the cart refitted, `final` extended; `is_refused` says that the refit foretold unseen
    stretches worse than the file's values, which stay."""

    nominal_cart: CartModel
    checks: tuple[LogCheck, ...]
    bands: tuple[Band | None, ...]
    nominal: Model
    final: Model
    steps: tuple[Step, ...]
    shares: tuple[float, ...]
    gap: Gap
    is_refused: bool
    impacts: tuple[Impact, ...] = ()

    @cached_property
    def stops(self) -> tuple[StopEstimate, ...]:
        """What the cart ran against several times."""
        return end_stops(self.impacts)

    @cached_property
    def certainty(self) -> Certainty:
        return _certainty(self.final, self.steps, self.bands)

    @cached_property
    def cart(self) -> CartModel:
        """The extended model."""
        cart = self.nominal_cart if self.is_refused else self.certainty.cart
        for i, stop in enumerate(self.stops):
            cart = cart.with_effect(stop.effect(label=str(i + 1) if i else ""))
        return cart

    @cached_property
    def effects(self) -> tuple[NamedEffect, ...]:
        return (*named(self.steps, self.final, self.certainty, self.shares), *named_stops(self.stops))

    @property
    def laws(self) -> tuple[Law, ...]:
        return self.final.laws

    @cached_property
    def before(self) -> tuple[Residual, ...]:
        return residuals(self.nominal, self.final)

    @cached_property
    def after(self) -> tuple[Residual, ...]:
        return residuals(self.final, self.final)

    @cached_property
    def where(self) -> tuple[Disagreement, ...]:
        """Of what the refitted nominal model leaves; nowhere, where it agrees with the logs."""
        return tuple(where(self.before)) if self.disagrees else ()

    @cached_property
    def residual_maps(self) -> tuple[ResidualMap, ...]:
        """The residual against all that it may depend on, refitted and extended."""
        return residual_maps(self.before, self.after)

    @cached_property
    def isolability(self) -> dict[str, Isolability]:
        return isolability(self.nominal)

    @cached_property
    def disagrees(self) -> bool:
        """Whether the refitted nominal model is farther from the logs than noise, or follows something."""
        beyond = self.gap.refitted > BEYOND_NOISE * self.gap.noise_floor and self._is_noisy
        return bool(self.effects or self.laws or beyond)

    @property
    def _is_noisy(self) -> bool:
        """Whether rows scatter more than the sensors' noise makes them."""
        f = self.final.cart.constraints.n_free
        sensors = np.max([wrench_noise(balances, self.final.cart) for balances in self.final.logs], axis=0)
        return bool((self.final.noise.excess[:f] > BEYOND_NOISE * sensors).any())

    @cached_property
    def is_moved(self) -> bool:
        """Whether the cart does, anywhere in the logs."""
        return any(moves(balances) for balances in self.nominal.logs)

    @cached_property
    def verdict(self) -> str:
        if not self.disagrees:
            return "no_discrepancy"
        if not self.effects:
            return "unexplained"
        gap, noise = self.gap, BEYOND_NOISE * self.gap.noise_floor
        left, whole = gap.after**2 - noise**2, max(gap.refitted**2 - gap.noise_floor**2, 1e-12)
        return "partly_explained" if self.laws or left > CLOSED * whole else "explained"

    @cached_property
    def file_parameters(self) -> dict[str, tuple[float, ParameterEstimate]]:
        """Of the cart file: the value there, and what the logs say beside what was added."""
        found, body = self.certainty.parameters, self.nominal_cart.inertia
        nominal = {"mass": body.mass, "com_x": body.com[0], "com_y": body.com[1], "inertia": body.about_com}
        for effect in self.nominal_cart.effects:
            nominal |= dict(zip(effect.keys, effect.values.tolist(), strict=True))
        return {name: (float(value), found[name]) for name, value in nominal.items() if name in found}

    @property
    def parameter_mismatch(self) -> dict[str, dict[str, float]]:
        told = {
            name: {"nominal": nominal, "refitted": found.value, "std": found.std}
            for name, (nominal, found) in self.file_parameters.items()
        }
        if "viscous_drag.linear" in told:
            told["viscous_drag"] = told["viscous_drag.linear"]
        return told

    @cached_property
    def unexplained(self) -> dict[str, Any]:
        """What the final model leaves: root mean square size by coordinate, and what it depends on."""
        f = self.nominal_cart.constraints.n_free
        sizes = {}
        for residual in self.after:
            sizes[residual.coordinate] = residual.size if self.verdict in ("unexplained", "partly_explained") else 0.0
        for law in self.laws:
            coordinate = DIRECTIONS[f][f - 1 if law.is_moment else 0]
            sizes[coordinate] = max(sizes[coordinate], self.size_of(law))
        told: dict[str, Any] = {"size": sizes, "depends_on": [law.words for law in self.laws]}
        periods = [(law.period, law.unit) for law in self.laws if law.period is not None]
        if periods:
            told["period"], told["period_unit"] = periods[0]
        return told

    def size_of(self, law: Law) -> float:
        """Root mean square force (N) or moment (N·m) of a law of the final model."""
        return self.final.law_size(law)

    @property
    def warnings(self) -> tuple[str, ...]:
        """What the logs' sensors seem to do, in words, what makes estimates worthless first."""
        told = [(check.name, one) for check in self.checks for one in check.suspicions]
        return tuple(f"{name}: {one.words}" for name, one in sorted(told, key=lambda pair: not pair[1].is_refused))

    @property
    def sentence(self) -> str:
        """The verdict, for people."""
        wrong = [one.words for check in self.checks for one in check.suspicions if one.is_refused]
        return (
            f"{self._of_model} But nothing of this holds if sensors are wrong: {'; '.join(wrong)}."
            if wrong
            else self._of_model
        )

    @property
    def _of_model(self) -> str:
        gap, names = self.gap, ", ".join(effect.name for effect in self.effects)
        shrinks = f"the 1 s rollout error goes from {1e3 * gap.refitted:.1f} mm to {1e3 * gap.after:.1f} mm"
        floor = f"noise alone makes {1e3 * gap.noise_floor:.1f} mm"
        kept = (
            " The refit foretold unseen stretches worse than the file's values, which stay." if self.is_refused else ""
        )
        if not self.nominal.is_pushed:
            mass = self.nominal_cart.inertia.mass
            kept += f" Nobody pushes: the mass ({mass:g} kg) can't be learned and is as given; forces are told for it."
        follows = f" What is left follows {' and '.join(law.name for law in self.laws)}." if self.laws else ""
        if not self.is_moved:
            return f"Nothing moves, so nothing is learned and the file's values stay; {floor}.{kept}"
        if self.verdict == "no_discrepancy":
            return f"Simulation and measurement agree: {1e3 * gap.refitted:.1f} mm after 1 s, and {floor}.{kept}"
        if self.verdict == "unexplained":
            return (
                f"They disagree, and no known effect explains it: {1e3 * gap.refitted:.1f} mm after 1 s, while {floor}."
                f"{follows}{kept}"
            )
        them = "it" if len(self.effects) == 1 else "them"
        if self.verdict == "explained":
            return f"The model lacks {names}: with {them} {shrinks}; {floor}.{kept}"
        part = f"which {'explains' if len(self.effects) == 1 else 'explain'} a part"
        return f"The model lacks {names}, {part}: with {them} {shrinks}; {floor}.{follows}{kept}"

    @cached_property
    def next_experiments(self) -> tuple[str, ...]:
        """What to record next."""
        return next_experiments(self)

    @property
    def report(self) -> Report:
        from .report import Report

        return Report(self)


def diagnose(
    logs: RunLog | Sequence[RunLog], cart: CartModel, progress: Callable[[str], None] | None = None
) -> Diagnosis:
    """Finds where logs and the cart's model disagree, names what is missing, and adds it.

    Raises DataError for a log that can't be used.
    """
    logs = [logs] if isinstance(logs, RunLog) else list(logs)
    if not logs:
        raise UsageError("diagnose: no log is given; at least one is needed")
    try:
        return _diagnosed(logs, cart, progress or (lambda _: None))
    except np.linalg.LinAlgError as error:
        raise DataError(
            f"{', '.join(log.name for log in logs)}: the equations of a fit have no solution; look for long stretches "
            "without motion or wrenches, and for numbers that are not in SI units"
        ) from error


def _diagnosed(logs: Sequence[RunLog], cart: CartModel, tell: Callable[[str], None]) -> Diagnosis:
    parts, known, checks, hits = list[Balances](), list[Band | None](), [], list[Impact]()
    for log in (part for whole in logs for part in _without_holes(whole)):
        tell(f"reading {log.name}")
        check_rows(log)
        sound = without_glitches(without_idle_arms(log))
        check_sizes(sound)
        sensors = put_right(sound, cart)
        whole = Balances.of(sensors.log, cart)
        band = consistent(bands(whole, cart))
        found = impacts(log, _as_heavy(cart, band))
        check = checked(log, cart, whole)
        checks.append(with_suspicions(check, (*sensors.suspicions, *of_wrenches(whole, cart))))
        between = [part for part in flights(sensors.log, cart, found) if len(part.used)] if found else []
        parts += between or [whole]
        known += [consistent(bands(part, cart)) for part in between] or [band]
        hits += found
    is_moved = any(moves(balances) for balances in parts)
    found_in = _searched(parts, known, cart, tell) if is_moved else _at_rest(parts, cart)
    nominal, final, steps, widest = found_in
    final = _upheld(final, nominal, steps, widest)
    tell("measuring the gap")
    gap = measured_gap(cart, nominal, final)
    is_refused = is_moved and not added(final) and bool(refused(final, cart))
    if gap.refitted > gap.before:  # then the file's values are the better nominal model
        gap = gap.as_the_file_has_it("refitted", *(["after"] if is_refused or not (added(final) or final.laws) else []))
    offsets = clock_offsets(final)
    told = checks if hits else with_clock_offsets(checks, offsets)
    return Diagnosis(
        cart,
        tuple(told),
        widest,
        nominal,
        final,
        tuple(steps),
        _shares(steps, nominal, gap),
        gap,
        is_refused,
        tuple(hits),
    )


def _without_holes(log: RunLog) -> list[RunLog]:
    """Logs of what a recorder that paused, or whose clock jumped, left of one."""
    parts = unbroken(log, LONGEST_HOLE)
    if len(parts) == 1:
        return parts
    named = (replace(part, name=f"{log.name}, part {i + 1}") for i, part in enumerate(parts))
    return [part for part in named if is_long_enough(part)] or [log]


Searched = tuple[Model, Model, list[Step], tuple[Band | None, ...]]
"""Before and after a search, its steps, and the band of each log."""


def _searched(
    parts: Sequence[Balances], known: Sequence[Band | None], cart: CartModel, tell: Callable[[str], None]
) -> Searched:
    """In the widest band in which the model foretells the motion: with what it lacks, where that makes the mass the
    same in all bands, else without: in those that are `known` of the cart as it is."""
    if any(band is not None and is_narrower(band, b) for b, band in zip(parts, known, strict=True)):
        nominal, final, steps = _in_band(parts, cart, tell)
        again = (consistent(bands(balances, final.cart)) for balances in final.logs)
        if all(band and not is_narrower(band, b) for b, band in zip(parts, again, strict=True)):
            return nominal, final, steps, _extended(final, known)
    narrowed = [b if band is None else b.every(band.row_step) for b, band in zip(parts, known, strict=True)]
    long = [(b, band) for b, band in zip(narrowed, known, strict=True) if len(b.used)]
    nominal, final, steps = _in_band([b for b, _ in long], cart, tell)
    return nominal, final, steps, _extended(final, [band for _, band in long])


def _extended(final: Model, known: Sequence[Band | None]) -> tuple[Band | None, ...]:
    """Each log's band, with what was found."""
    again = (consistent(bands(balances, final.cart, final.guess)) for balances in final.logs)
    return tuple(new or old for new, old in zip(again, known, strict=True))


def _in_band(
    parts: Sequence[Balances], cart: CartModel, tell: Callable[[str], None]
) -> tuple[Model, Model, list[Step]]:
    tell("fitting the model as it is")
    nominal = Model.started(parts, cart)
    return nominal, *search(nominal, tell)


def _at_rest(parts: Sequence[Balances], cart: CartModel) -> Searched:
    """Whatever holds a cart has no name."""
    nominal = replace(Model.started(parts, cart), cart=cart)
    return nominal, nominal, [], (None,) * len(parts)


def _upheld(final: Model, nominal: Model, steps: Sequence[Step], known: Sequence[Band | None]) -> Model:
    """Without effects of which next to nothing is left, and without the last ones as long as they make unseen stretches
    worse; beside laws, which no rollout has, that can't be told."""
    for key in faded(final, _certainty(final, steps, known)):
        final = final.refitted(final.cart.without_effect(key)).settled()
    while added(final) and not final.laws and is_worse(final, nominal):
        final = final.refitted(final.cart.without_effect(added(final)[-1].key)).settled()
    return final


def _certainty(final: Model, steps: Sequence[Step], known: Sequence[Band | None]) -> Certainty:
    told = tuple(band for band in known if band is not None)
    return Certainty(final, told, undecided(steps, final, len(final.guess.parameters)))


def _as_heavy(cart: CartModel, band: Band | None) -> CartModel:
    """The cart with the mass that a log's band tells, and as much more inertia, for what a first guess should not
    decide."""
    if band is None:
        return cart
    body = cart.inertia
    return cart.with_inertia(Inertia(band.mass, body.com, body.about_com * band.mass / body.mass))


def _shares(steps: Sequence[Step], nominal: Model, gap: Gap) -> tuple[float, ...]:
    """Of the gap above the noise floor, what each step closed; of logs at rest, nothing."""
    if not any(len(starts(balances)) for balances in nominal.logs):
        return (0.0,) * len(steps)
    whole = max(gap.refitted**2 - gap.noise_floor**2, 1e-12)
    found, before = [], gap.refitted**2
    for step in steps:
        model = step.added.model if step.added is not None else None
        after = before if model is None else float(held_out_rollouts(model).gaps()[1]) ** 2
        found.append(float(np.clip((before - after) / whole, 0.0, 1.0)))
        before = after
    return tuple(found)
