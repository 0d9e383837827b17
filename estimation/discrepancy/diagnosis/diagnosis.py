"""The discrepancy workflow: logs and a cart in; what the cart's model lacks, with its proof, out."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from cartgrasp.checks import check_kind, listed
from cartgrasp.effects import Effect, EndStop, LearnedForce
from cartgrasp.errors import DataError, UsageError
from cartgrasp.inertia import Inertia
from cartgrasp.logs import RunLog
from cartgrasp.logs.coasting import without_idle_arms
from cartgrasp.model import CartModel
from cartgrasp.motion import ParameterEstimate
from cartgrasp.reference_file import StoredReference

from ...experiments.manoeuvres import Limits
from ...impacts.end_stops import StopEstimate, end_stops
from ...impacts.impacts import Impact, impacts
from ...log_noise.glitches import without_glitches
from ...sensor_check import check_sizes, corrected_log, wheel_suspicions, wrench_suspicions
from ...sensor_check.jumps import jump_times
from ...weak_form.balances import Balances
from ...weak_form.band import Band, bands, consistent
from ...weak_form.log_segments import MAX_SEGMENT_POSE_GAP, segments, split_at_gaps
from ..clock_offset import clock_offsets
from ..findings.certainty import Certainty
from ..findings.gap import MAX_GAP_LEFT_FRACTION, Gap, reported_gap
from ..findings.held_out import held_out_rollouts
from ..findings.isolability import Isolability, isolability
from ..findings.named_effects import NamedEffect, doubtful_names, named_effects, named_stops
from ..findings.rollouts import check_comparable, starts
from ..findings.validation import certainty_of, closes_most, rollout_error, validated, without
from ..findings.verdicts import may_follow
from ..log_check import LogCheck, check_rows, checked, is_long_enough, moves, with_clock_offsets, with_suspicions
from ..search.candidates import free_label
from ..search.gains import added
from ..search.laws import Law, row_values
from ..search.model import Model
from ..search.scored_candidates import SearchStep
from ..search.search_in_band import at_rest, searched
from ..where.residual import Residual, fine_residuals, residuals, with_fine_rows
from ..where.residual_map import ResidualMap, residual_maps
from ..where.where import Disagreement, effect_disagreements, repeats, where
from .next_experiments import NextExperiment, next_experiment
from .sentence import sentence

if TYPE_CHECKING:
    from .report import Report

MASS_DIFFERENCE_SIGMAS = 3.0
"""Standard deviations between masses of logs: they are of different loads."""


# Many methods: each is one entry of the contract's report, worked out when it is asked for and in three lines.
@dataclass(frozen=True, eq=False)
class Diagnosis:
    """What came out. `nominal` is the cart refitted, `final` extended; `is_refused` says that the refit foretold unseen
    stretches worse than the file's values, which stay; `withdrawn` are laws that did; `limits` are those of a next
    motion."""

    nominal_cart: CartModel
    checks: tuple[LogCheck, ...]
    bands: tuple[Band | None, ...]
    nominal: Model
    final: Model
    steps: tuple[SearchStep, ...]
    shares: tuple[float, ...]
    gap: Gap
    is_refused: bool
    impacts: tuple[Impact, ...] = ()
    withdrawn: tuple[Law, ...] = ()
    limits: Limits = field(default_factory=Limits)

    def __repr__(self) -> str:
        return f"Diagnosis({self.verdict}: {self.sentence})"

    @cached_property
    def stops(self) -> tuple[StopEstimate, ...]:
        """What the cart ran against several times, but for what its file knows."""
        known = [effect for effect in self.nominal_cart.effects if isinstance(effect, EndStop)]
        return tuple(stop for stop in end_stops(self.impacts) if not any(map(stop.is_at, known)))

    @cached_property
    def certainty(self) -> Certainty:
        return certainty_of(self.final, self.steps, self.bands)

    @cached_property
    def cart(self) -> CartModel:
        """The extended model."""
        cart = self.nominal_cart if self.is_refused else self.certainty.cart
        for _, law in self.certainty.laws:
            cart = cart.with_effect(law.effect)
        for stop in self.stops:
            cart = cart.with_effect(stop.effect(label=free_label(EndStop, cart)))
        return cart

    @cached_property
    def effects(self) -> tuple[NamedEffect, ...]:
        stops = named_stops(self.stops, self.nominal_cart)
        return (*named_effects(self.steps, self.final, self.certainty, self.shares), *stops)

    @cached_property
    def before(self) -> tuple[Residual, ...]:
        return residuals(self.nominal, self.final)

    @cached_property
    def after(self) -> tuple[Residual, ...]:
        return residuals(self.final, self.final)

    @cached_property
    def where(self) -> tuple[Disagreement, ...]:
        """Disagreements in what the refitted nominal model leaves; none where it agrees with the logs."""
        first = [*effect_disagreements(self.final, self.before), *self._repeating()] if self.disagrees else []
        return tuple(where(self.before, first)) if self.disagrees else ()

    def _repeating(self) -> Iterator[Disagreement]:
        """What repeats with the period of a law, of the coordinate that it acts on."""
        laws = [law for law in (*self.final.laws, *self.withdrawn) if law.period]
        fine = fine_residuals(self.nominal, self.final) if laws else ()
        for law in laws:
            turns = law.effects[0].acts_on == "yaw_moment" and self.final.cart.constraints.n_free > 1
            residual = fine[self.final.cart.constraints.n_free - 1 if turns else 0]
            yield from repeats(residual, row_values(law.effects[0], with_fine_rows(self.final.logs)), law)

    @cached_property
    def residual_maps(self) -> tuple[ResidualMap, ...]:
        """The residual against all that it may depend on, refitted and extended."""
        return residual_maps(self.before, self.after)

    @cached_property
    def isolability(self) -> dict[str, Isolability]:
        return isolability(self.nominal)

    @cached_property
    def disagrees(self) -> bool:
        """Whether the refitted nominal model is farther from the logs than one that is right, or follows something."""
        return bool(self.effects) or self.gap.refitted > self.gap.allowed

    @cached_property
    def is_moved(self) -> bool:
        """Whether the cart moves anywhere in the logs."""
        return any(moves(balances) for balances in self.nominal.logs)

    @cached_property
    def verdict(self) -> str:
        if not self.disagrees:
            return "no_discrepancy"
        if not self.effects:
            return "unexplained"
        gap = self.gap
        left, whole = gap.after**2 - gap.allowed**2, max(gap.refitted**2 - gap.noise_floor**2, 1e-12)
        return "partly_explained" if left > MAX_GAP_LEFT_FRACTION * whole else "explained"

    @cached_property
    def file_parameters(self) -> dict[str, tuple[float, ParameterEstimate]]:
        """Parameters of the cart file by name: the value there, and what the logs say beside what was added."""
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
        """What the final model leaves: root mean square size by coordinate, and what it may follow, though that made
        unseen stretches no better."""
        told: dict[str, Any] = {
            "size": {residual.coordinate: residual.size if self._is_left else 0.0 for residual in self.after},
            "depends_on": [law.words for law in self.may_follow],
        }
        for law in self.may_follow:
            if law.period is not None:
                told.setdefault("period", law.period)
                told.setdefault("period_unit", law.unit)
        return told

    @cached_property
    def may_follow(self) -> tuple[Law, ...]:
        """Laws that what is left may follow: withdrawn ones, or else, where something is left, one that was refused."""
        return self.withdrawn or (may_follow(self.steps) if self._is_left else ())

    @property
    def _is_left(self) -> bool:
        """Whether there is a gap that neither names nor laws explain."""
        return self.verdict in ("unexplained", "partly_explained")

    @property
    def warnings(self) -> tuple[str, ...]:
        """What the logs' sensors seem to do, in words, what makes estimates worthless first."""
        told = [(check.name, one) for check in self.checks for one in check.suspicions]
        sensors = (f"{name}: {one.words}" for name, one in sorted(told, key=lambda pair: not pair[1].is_refused))
        return (*sensors, *self._of_several_carts, *self.unlisted_wheels)

    @property
    def unlisted_wheels(self) -> tuple[str, ...]:
        """What would tell names and masses better, where a cart on an axle lists no wheels."""
        cart = self.nominal_cart
        if cart.wheels or cart.constraints.n_rows != 1 or not (self.effects or self.withdrawn):
            return ()
        return (
            f"{cart.name} lists no wheels, so what they drag is one force at {{b}}, and the moment that it lacks may "
            "pass for another effect: list them, and compare again",
        )

    @property
    def _of_several_carts(self) -> Iterator[str]:
        """Logs whose masses are not those of one cart."""
        known = [(b.name, band) for b, band in zip(self.final.logs, self.bands, strict=True) if band is not None]
        if len(known) > 1:
            (light, least), (heavy, most) = (end(known, key=lambda one: one[1].mass) for end in (min, max))
            if most.mass - least.mass > MASS_DIFFERENCE_SIGMAS * float(np.hypot(least.deviation, most.deviation)):
                told = (f"{b.mass:.3g} ± {b.deviation:.2g} kg" for b in (least, most))
                yield (
                    f"{light} and {heavy} tell of {' and of '.join(told)}: if the cart carried different loads, "
                    "compare each log alone"
                )

    @property
    def sentence(self) -> str:
        return sentence(self)

    @cached_property
    def named_share(self) -> float:
        """Share of the held-out gap above the noise floor that names alone close (0 to 1)."""
        whole = self.gap.refitted**2 - self.gap.noise_floor**2
        if whole <= 0.0 or all(effect.law is not None for effect in self.effects):
            return 0.0
        bare = replace(self.final, laws=()).refitted(self.final.cart) if self.final.laws else self.final
        left = rollout_error(held_out_rollouts(bare)) if self.final.laws else self.gap.after
        return float(np.clip((self.gap.refitted**2 - left**2) / whole, 0.0, 1.0))

    @cached_property
    def next_experiment(self) -> NextExperiment:
        return next_experiment(self)

    @property
    def next_reference(self) -> StoredReference | None:
        """The motion that best tells what is still open, to be simulated or run; None where nothing is, or where none
        would tell (`next_experiment.why_none`)."""
        proposal = self.next_experiment.proposal
        return None if proposal is None else proposal.reference

    @property
    def report(self) -> Report:
        from .report import Report

        return Report(self)


def diagnose(
    logs: RunLog | Sequence[RunLog],
    cart: CartModel,
    progress: Callable[[str], None] | None = None,
    candidates: Sequence[Effect] = (),
    limits: Limits | None = None,
) -> Diagnosis:
    """Finds where logs and the cart's model disagree, names what is missing, and adds it.

    Args:
        logs: One or several, of one cart with one load.
        cart: The model that is asked about, with its first guess.
        progress: Is told in words what is being done.
        candidates: Effects that are tried beside the vocabulary, of classes of one's own, too, and laws
            (`LearnedForce`) at their settings; their amplitudes are fitted.
        limits: Within which the motion that it proposes keeps: speed (m/s) and duration (s).

    Raises:
        DataError: A log can't be used.
        UsageError: An argument is of the wrong kind, or the cart has a candidate already.

    Example:
        >>> import cartgrasp as cg
        >>> from estimation import diagnose
        >>> diagnosis = diagnose(cg.read_log("run.csv"), cg.load_cart("cart.yaml"))
        >>> diagnosis.verdict, [effect.name for effect in diagnosis.effects]
        ('no_discrepancy', [])
    """
    check_kind("diagnose: cart", cart, CartModel, 'load it first: load_cart("cart.yaml")')
    logs = [logs] if isinstance(logs, RunLog) else listed("diagnose: logs", logs, RunLog, 'write [read_log("run.csv")]')
    listed("diagnose: candidates", candidates, Effect, "write candidates=[RollingResistance()]")
    has = {effect.key for effect in cart.effects}
    for one in candidates:
        if one.key in has and not isinstance(one, LearnedForce):
            raise UsageError(f"diagnose: candidates: the cart has {one.key} already; give another label")
    if not logs:
        raise UsageError("diagnose: no log is given; at least one is needed")
    try:
        found = _diagnosed(logs, cart, progress or (lambda _: None), tuple(candidates))
    except np.linalg.LinAlgError as error:
        raise DataError(
            f"{', '.join(log.name for log in logs)}: the equations of a fit have no solution; look for long stretches "
            "without motion or wrenches, and for numbers that are not in SI units"
        ) from error
    return found if limits is None else replace(found, limits=limits)


def _diagnosed(
    logs: Sequence[RunLog], cart: CartModel, tell: Callable[[str], None], candidates: tuple[Effect, ...]
) -> Diagnosis:
    parts, known, checks, hits = list[Balances](), list[Band | None](), [], list[Impact]()
    for log in (part for whole in logs for part in _without_holes(whole)):
        tell(f"reading {log.name}")
        check_rows(log)
        sound = without_glitches(without_idle_arms(log))
        check_sizes(sound)
        sensors = corrected_log(sound, cart)
        whole = Balances.of(sensors.log, cart)
        band = consistent(bands(whole, cart))
        found = impacts(log, _with_band_mass(cart, band))
        check = checked(log, cart, whole)
        seem = (*sensors.suspicions, *wrench_suspicions(whole, cart), *wheel_suspicions(whole, cart))
        checks.append(with_suspicions(check, seem))
        lost = jump_times(sensors.log)
        cut = segments(sensors.log, cart, found, lost) if found or len(lost) else ()
        between = [part for part in cut if len(part.used)]
        parts += between or [whole]
        known += [consistent(bands(part, cart)) for part in between] or [band]
        hits += found
    is_moved = any(moves(balances) for balances in parts)
    if is_moved and not end_stops(hits):
        check_comparable(parts)
    found_in = searched(parts, known, cart, candidates, tell, closes_most) if is_moved else at_rest(parts, cart)
    nominal, final, steps, widest = found_in
    final, withdrawn = validated(final, nominal, widest)
    tell("measuring the gap")
    gap, stays = reported_gap(nominal, final)
    shares = _shares(steps, final, gap)
    if keys := doubtful_names(steps, final, shares):
        final = without(final, keys)
        gap, stays = reported_gap(nominal, final)
    offsets = clock_offsets(final)
    told = checks if len(offsets) > len(checks) else with_clock_offsets(checks, offsets)
    is_refused = is_moved and stays
    return Diagnosis(
        cart, tuple(told), widest, nominal, final, tuple(steps), shares, gap, is_refused, tuple(hits), withdrawn
    )


def _without_holes(log: RunLog) -> list[RunLog]:
    """Logs of what a recorder that paused, or whose clock jumped, left of one."""
    parts = split_at_gaps(log, MAX_SEGMENT_POSE_GAP)
    if len(parts) == 1:
        return parts
    named = (replace(part, name=f"{log.name}, part {i + 1}") for i, part in enumerate(parts))
    return [part for part in named if is_long_enough(part)] or [log]


def _with_band_mass(cart: CartModel, band: Band | None) -> CartModel:
    """The cart with the mass that a log's band tells, and as much more inertia, for what a first guess should not
    decide."""
    if band is None:
        return cart
    body = cart.inertia
    return cart.with_inertia(Inertia(band.mass, body.com, body.about_com * band.mass / body.mass))


def _shares(steps: Sequence[SearchStep], final: Model, gap: Gap) -> tuple[float, ...]:
    """Share of the gap above the noise floor that each step closed; of logs at rest, nothing. What was added alone
    closed what all of it closes."""
    if not any(len(starts(balances)) for balances in final.logs):
        return (0.0,) * len(steps)
    whole = max(gap.refitted**2 - gap.noise_floor**2, 1e-12)
    found, before = [], gap.refitted**2
    is_alone = sum(step.added is not None for step in steps) == 1 and bool(added(final) or final.laws)
    for step in steps:
        model = step.added.model if step.added is not None else None
        told = final if model and is_alone else model and replace(model, band_steps=final.band_steps)
        after = before if told is None else float(held_out_rollouts(told).gaps()[1]) ** 2
        found.append(float(np.clip((before - after) / whole, 0.0, 1.0)))
        before = after
    return tuple(found)
