"""The gap that is left when somebody tells which effects act: a measure of what a search for them could reach.

The structure is fitted as the search fits its own, on the same rows, and judged on the same rollouts.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from cartgrasp.effects import Effect
from cartgrasp.logs import RunLog
from cartgrasp.model import CartModel
from estimation.discrepancy.findings.held_out import held_out_rollouts
from estimation.discrepancy.search.backward_elimination import retuned
from estimation.discrepancy.search.model import Model
from estimation.discrepancy.search.search import resized
from estimation.impacts.impacts import impacts
from estimation.log_noise.glitches import without_glitches
from estimation.sensor_check import corrected_log
from estimation.weak_form.balances import Balances
from estimation.weak_form.band import bands, consistent
from estimation.weak_form.log_segments import segments


@dataclass(frozen=True)
class KnownStructure:
    """The cart with its effects, all values fitted to all rows, and the `gap` of its report: m, after 1 s."""

    cart: CartModel
    gap: float


def refit(logs: Sequence[RunLog], cart: CartModel, effects: Sequence[Effect]) -> KnownStructure:
    """Of the cart with effects near these values, at which the search for times, places and frequencies begins."""
    parts = [part for log in logs for part in _parts(log, cart)]
    model = Model.started([part for part, _ in parts], cart)
    if effects:
        whole = model.cart
        for effect in effects:
            whole = whole.with_effect(effect)
        model = retuned(model.refitted(whole).rewhitened())
    model = replace(resized(model), band_steps=tuple(step for _, step in parts))
    return KnownStructure(model.cart, float(held_out_rollouts(model).gaps()[1]))


def _parts(log: RunLog, cart: CartModel) -> list[tuple[Balances, float | None]]:
    """Between impacts, each in the widest band in which the model foretells its motion, with the band's step (s)."""
    found, known = impacts(log, cart), corrected_log(without_glitches(log), cart).log
    parts = segments(known, cart, found) if found else [Balances.of(known, cart)]
    widest = [consistent(bands(part, cart)) for part in parts]
    return [
        (part, None) if band is None else (part.every(band.row_step), band.row_step)
        for part, band in zip(parts, widest, strict=True)
    ]
