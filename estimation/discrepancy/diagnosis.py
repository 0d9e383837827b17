"""The discrepancy workflow: logs and a cart in; what the cart's model lacks, with its proof, out."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from cartgrasp.effects import Effect
from cartgrasp.effects.effect import Gate
from cartgrasp.errors import DataError, UsageError
from cartgrasp.logs import RunLog
from cartgrasp.model import CartModel

from ..batch.wrench_regression import WrenchRegression
from ..glitches import without_glitches
from .certainty import Certainty, proven
from .fitted import SURE
from .gap import Gap, measured_gap
from .generic import Dependence
from .held_out import BEYOND_NOISE
from .holes import without_holes
from .left_over import beyond_noise, followed, missing_push
from .log_check import LogCheck, check_rows, checked
from .next_experiments import next_experiments
from .residual import DIRECTIONS, Residual, lateral_residual, wrench_residuals
from .residual_map import ResidualMap, residual_maps
from .selection import Selection, Step, select
from .stale import without_stale
from .where import Disagreement, where

if TYPE_CHECKING:
    from .report import Report

SETTING_STD = {"s": 0.003, "rad": 0.001}
SETTING_SHARE, EDGE_STD = 0.1, 0.02
"""Of settings that no search or linear fit found: delays, angles; trails, stiffnesses; edges of places (m)."""
LEAST_SHARE, LEAST_SMOOTH = 0.05, 0.15
"""Of the squares of the residual, for a dependence that is told: on what is periodic, and on what any other form of the
model would follow a little."""
RATE, ENOUGH = 45.0, 2000
"""Rows a second, and rows, that are as good as more: of a log with twice as many, pairs are looked at, with four times
as many, pairs of means of two."""
WHOLE = 0.98
"""Of the rows: so many must be whole for that."""
CLOSED, NEARLY_CLOSED, FAR = 0.25, 0.05, 2.0
"""Of the squared nominal gap above the noise floor: what may be left where the effects explain it; and where the gap is
still so many times the floor."""
LEAST_NAMELESS = 50.0
"""Log of the Bayes factor of what is there, and has no name: it has another size in another part of the log, or is not
proven."""
TRIFLE = 0.02
"""Of the squares of the nominal residual: what follows something and is smaller leaves a log explained."""


@dataclass(frozen=True)
class NamedEffect:
    """An effect that was added: how sure that it is this one; parameters' values, standard deviations and units; what
    the log can't tell it apart from; the share of the held-out gap above the noise floor that it closed."""

    name: str
    label: str
    probability: float
    parameters: dict[str, tuple[float, float, str]]
    confusable_with: tuple[str, ...]
    gap_share: float

    def as_dict(self) -> dict[str, Any]:
        parameters = {k: {"value": v, "std": s, "unit": u} for k, (v, s, u) in self.parameters.items()}
        return {
            "name": self.name,
            "label": self.label,
            "probability": self.probability,
            "parameters": parameters,
            "confusable_with": list(self.confusable_with),
            "gap_share": self.gap_share,
        }


@dataclass(frozen=True)
class Diagnosis:
    """What came out. `cart` is the extended model."""

    nominal_cart: CartModel
    selection: Selection
    checks: tuple[LogCheck, ...]
    before: tuple[Residual, ...]
    after: tuple[Residual, ...]
    remaining: tuple[Dependence, ...]
    gap: Gap
    certainty: Certainty

    @cached_property
    def cart(self) -> CartModel:
        return self.certainty.cart

    @cached_property
    def effects(self) -> tuple[NamedEffect, ...]:
        kept = (s for s in self.selection.steps if s.added is not None and s.added.key not in self.selection.removed)
        return tuple(_named(self, step) for step in kept)

    @cached_property
    def where(self) -> tuple[Disagreement, ...]:
        """Of what the refitted nominal model leaves; nowhere, where it agrees with the logs."""
        return tuple(where(self.before)) if self.disagrees else ()

    @cached_property
    def residual_maps(self) -> tuple[ResidualMap, ...]:
        """The residual against all that it may depend on, refitted and extended."""
        return residual_maps(self.before, self.after)

    @property
    def disagrees(self) -> bool:
        """Whether the refitted nominal model is farther from the logs than noise, or something is there without a
        name."""
        last = self.selection.steps[-1].attempts if self.selection.steps else ()
        nameless = self.selection.nameless or (
            self._is_left and any(a.is_there and a.log_factor > LEAST_NAMELESS for a in last)
        )
        beyond = self.gap.refitted > BEYOND_NOISE * self.gap.noise_floor
        return bool(self.effects or self.remaining or beyond or nameless)

    @property
    def verdict(self) -> str:
        if not self.disagrees:
            return "no_discrepancy"
        if not self.effects:
            return "unexplained"
        floor = self.gap.noise_floor**2
        left = self.gap.after**2 - BEYOND_NOISE**2 * floor
        whole = max(self.gap.refitted**2 - floor, 1e-12)
        most = NEARLY_CLOSED if self.gap.after > FAR * self.gap.noise_floor else CLOSED
        return "partly_explained" if left > most * whole or self._much_remains else "explained"

    @property
    def _is_left(self) -> bool:
        """Whether the residual is more than noise: what takes away a part of less is no thing without a name."""
        return bool(beyond_noise(self.selection.final.scatter).any())

    @property
    def _much_remains(self) -> bool:
        """Whether what the rest depends on is no trifle beside what the nominal model left."""
        nominal, final = self.selection.nominal, self.selection.final
        return any(d.share * final.misfit(d.direction) > TRIFLE * nominal.misfit(d.direction) for d in self.remaining)

    @cached_property
    def parameter_mismatch(self) -> dict[str, dict[str, float]]:
        found = self.certainty.parameters
        body, told = self.nominal_cart.inertia, {}
        nominal = {"mass": body.mass, "com_x": body.com[0], "com_y": body.com[1], "inertia": body.about_com}
        for effect in self.nominal_cart.effects:
            nominal |= dict(zip(effect.keys, effect.values.tolist(), strict=True))
        for name, value in nominal.items():
            if name in found:
                told[name] = {"nominal": float(value), "refitted": found[name].value, "std": found[name].std}
        if "viscous_drag.linear" in told:
            told["viscous_drag"] = told["viscous_drag.linear"]
        return told

    @property
    def unexplained(self) -> dict[str, Any]:
        """What the final model leaves: root mean square size beyond noise by coordinate, of the residual, of what
        it follows, or of what pushes rollouts away, whatever is the most; and what it depends on."""
        size, f = beyond_noise(self.selection.final.scatter), self.nominal_cart.constraints.n_free
        if self.verdict in ("unexplained", "partly_explained"):
            dependences = followed(self.selection.final.polygon, self.remaining)
            size = np.max([size, dependences, missing_push(self.gap, self.cart)], axis=0)
        sizes = dict(zip(DIRECTIONS[f], size.tolist(), strict=True))
        told: dict[str, Any] = {"size": sizes, "depends_on": [_phrase(d, f) for d in self.remaining]}
        periods = [(d.period, d.unit) for d in self.remaining if d.period is not None]
        if periods:
            told["period"], told["period_unit"] = periods[0]
        return told

    @property
    def sentence(self) -> str:
        """The verdict, for people."""
        gap, names = self.gap, ", ".join(effect.name for effect in self.effects)
        shrinks = f"the 1 s rollout error goes from {1e3 * gap.refitted:.1f} mm to {1e3 * gap.after:.1f} mm"
        floor = f"noise alone makes {1e3 * gap.noise_floor:.1f} mm"
        if self.verdict == "no_discrepancy":
            return f"Simulation and measurement agree: {1e3 * gap.refitted:.1f} mm after 1 s, refitted, and {floor}."
        if self.verdict == "unexplained" and gap.refitted <= BEYOND_NOISE * gap.noise_floor:
            return f"Rollouts agree ({1e3 * gap.refitted:.1f} mm after 1 s, and {floor}), but {self._follows}."
        if self.verdict == "unexplained":
            return (
                f"They disagree, and no known effect explains it: {1e3 * gap.refitted:.1f} mm after 1 s, while {floor}."
            )
        if self.verdict == "explained":
            return f"The model lacks {names}: with it {shrinks}; {floor}."
        return f"The model lacks {names}, which explains a part: with it {shrinks}; {floor}."

    @property
    def _follows(self) -> str:
        told = self.unexplained["depends_on"]
        return f"what is left follows something: {told[0]}" if told else "something is there that has no name"

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
    try:
        return _diagnosed(logs, cart, progress or (lambda _: None))
    except np.linalg.LinAlgError as error:
        raise DataError(
            f"{', '.join(log.name for log in logs)}: the equations of a fit have no solution; look for long stretches "
            "without motion or wrenches, and for numbers that are not in SI units"
        ) from error


def _diagnosed(logs: Sequence[RunLog], cart: CartModel, tell: Callable[[str], None]) -> Diagnosis:
    arms = _arms(logs)
    whole, checks = [], []
    for log in logs:
        tell(f"smoothing {log.name}")
        check_rows(log, cart)
        regression = smoothed(log, cart)
        checks.append(checked(log, cart, regression))
        whole.append(regression)
    selection, certainty = _proven(select(whole, cart, arms, tell))
    tell("measuring the gap")
    before, after = (
        (*wrench_residuals(fitted), *lateral_residual(fitted, selection.final))
        for fitted in (selection.nominal, selection.final)
    )
    remaining = [
        d
        for d in selection.final.dependences
        if d.log_factor > SURE and d.share > (LEAST_SHARE if d.is_periodic else LEAST_SMOOTH)
    ]
    gap = measured_gap(cart, selection)
    return Diagnosis(cart, selection, tuple(checks), before, after, tuple(remaining), gap, certainty)


def smoothed(log: RunLog, cart: CartModel) -> WrenchRegression:
    """A log as the search sees it."""
    log = without_holes(without_glitches(without_stale(log)))
    if _is_dense(log, 4.0):
        log = log.thinned().paired()
    return WrenchRegression(log, cart, None, _is_dense(log, 2.0)).wary()


def _proven(selection: Selection) -> tuple[Selection, Certainty]:
    """Without what is not sure, and without what passes that nobody would call so when it is told whole."""
    certainty, removed = proven(selection.final)
    final = selection.final.without_all(removed)
    added = {effect.key for effect in final.added}
    odd = tuple(
        effect.key
        for effect in certainty.cart.effects
        if effect.key in added and effect.gate.ends and effect.implausible(*selection.held_out.rolling)
    )
    gone, nameless = (*selection.removed, *removed, *odd), (*selection.nameless, *odd)
    selection = replace(selection, final=final.without_all(odd), removed=gone, nameless=nameless)
    return _proven(selection) if odd else (selection, certainty)


def _arms(logs: Sequence[RunLog]) -> list[str]:
    if not logs:
        raise UsageError("diagnose: no log is given; at least one is needed")
    return list(dict.fromkeys(arm for log in logs for arm in log.arms))


def _is_dense(log: RunLog, times: float) -> bool:
    """Whether it has so many times the rows that are enough, and nearly all of them whole."""
    rows = log.thinned()
    whole = np.isfinite(np.column_stack([rows.pose, *(arm.wrench for arm in rows.arms.values())])).all(axis=1)
    return len(rows) > times * max(ENOUGH, RATE * log.duration) and bool(whole.mean() > WHOLE)


def _named(diagnosis: Diagnosis, step: Step) -> NamedEffect:
    attempt = step.added
    assert attempt is not None
    found, settings = diagnosis.certainty.parameters, diagnosis.certainty.settings
    effect = next(e for e in diagnosis.cart.effects if e.key == attempt.key)
    parameters = {
        p.name: (
            float(value),
            found[key].std if p.estimated else settings.get(key, _usual_std(effect, i)),
            p.unit,
        )
        for i, (p, key, value) in enumerate(zip(effect.parameters, effect.keys, effect.values, strict=True))
    }
    share = float(np.clip(attempt.held_out_gain or 0.0, 0.0, 1.0))
    return NamedEffect(effect.name, effect.label, step.probability, parameters, step.confusable, share)


def _usual_std(effect: Effect, i: int) -> float:
    if effect.gate is Gate.INSIDE and i < effect.gate.n_parameters:
        return EDGE_STD
    return SETTING_STD.get(effect.parameters[i].unit, SETTING_SHARE * abs(float(effect.values[i])))


def _phrase(dependence: Dependence, f: int) -> str:
    coordinate = DIRECTIONS[f][dependence.direction].replace("_", " ")
    period = f" with a period of {dependence.period:.3g} {dependence.unit}" if dependence.period else ""
    return f"{coordinate}: {dependence.name}{period} ({100 * dependence.share:.0f} % of what is left)"
