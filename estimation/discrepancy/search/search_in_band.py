"""Search for what is missing in a band of frequencies: up to where the model foretells the motion."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

from cartgrasp.effects import Effect
from cartgrasp.model import CartModel

from ...weak_form.balances import Balances
from ...weak_form.band import Band, bands, consistent, is_narrower
from .model import Model
from .scored_candidates import SearchStep
from .search import ClosesGap, search

SearchResult = tuple[Model, Model, list[SearchStep], tuple[Band | None, ...]]
"""Models before and after a search, its steps, and the band of each log."""


def searched(
    parts: Sequence[Balances],
    known: Sequence[Band | None],
    cart: CartModel,
    candidates: tuple[Effect, ...],
    tell: Callable[[str], None],
    closes: ClosesGap,
) -> SearchResult:
    """Search in the widest band in which the model foretells the motion. That is judged with what it lacks, laws
    included, where that makes the mass the same in all bands. Else it is judged by the bands `known` of the cart as it
    is."""

    def in_band(chosen: Sequence[Balances]) -> tuple[Model, Model, list[SearchStep]]:
        tell("fitting the model as it is")
        nominal = replace(Model.started(chosen, cart), candidates=candidates)
        return nominal, *search(nominal, tell, closes)

    if any(band is not None and is_narrower(band, b) for b, band in zip(parts, known, strict=True)):
        nominal, final, steps = in_band(parts)
        again = _predicted_bands(final)
        if all(band and not is_narrower(band, b) for b, band in zip(parts, again, strict=True)):
            return _search_result(nominal, final, steps, again)
    narrowed = [b if band is None else b.every(band.row_step) for b, band in zip(parts, known, strict=True)]
    long = [(b, band) for b, band in zip(narrowed, known, strict=True) if len(b.used)]
    nominal, final, steps = in_band([b for b, _ in long])
    return _search_result(
        nominal, final, steps, [new or old for new, (_, old) in zip(_predicted_bands(final), long, strict=True)]
    )


def _predicted_bands(final: Model) -> list[Band | None]:
    """Each log's band, in which a model foretells the motion with what was found."""
    return [consistent(bands(balances, final.cart_with_laws, final.guess)) for balances in final.logs]


def _search_result(nominal: Model, final: Model, steps: list[SearchStep], found: Sequence[Band | None]) -> SearchResult:
    row_steps = tuple(None if band is None else band.row_step for band in found)
    return replace(nominal, band_steps=row_steps), replace(final, band_steps=row_steps), steps, tuple(found)


def at_rest(parts: Sequence[Balances], cart: CartModel) -> SearchResult:
    """Result without a search, of logs at rest: whatever holds a cart has no name."""
    nominal = replace(Model.started(parts, cart), cart=cart)
    return nominal, nominal, [], (None,) * len(parts)
