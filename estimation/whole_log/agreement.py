"""`identify`, least squares over the whole log, and the online filter held against each other: they stand on unlike
ground, so where they agree both are believed, and where they don't somebody should look."""

from __future__ import annotations

import math
from collections.abc import Mapping

from cartgrasp.logs import RunLog
from cartgrasp.model import CartModel
from cartgrasp.motion import ParameterEstimate

from .identification import identify
from .replay import as_replayed, estimated

DISAGREEMENT_SIGMAS, DISAGREEMENT_RATIO = 3.0, 0.05
"""Combined standard deviations, and share of the larger value, beyond both of which two values are not one."""
MAX_TWICE_FITTED_ROWS = 30_000
"""Largest number of rows of a log that is looked at twice, which takes some seconds: five minutes at 100 Hz."""


def against_filter(parameters: Mapping[str, ParameterEstimate], log: RunLog, cart: CartModel) -> tuple[str, ...]:
    """Where the online filter says something else of a log than `identify` did; of no log that is long."""
    thinned = as_replayed(log)
    if len(thinned) > MAX_TWICE_FITTED_ROWS:
        return ()
    last = estimated(thinned, cart, until=float(log.time[-1])).last
    return disagreements(parameters, last.parameters, str(last.health))


def against_identify(
    parameters: Mapping[str, ParameterEstimate], health: str, log: RunLog, cart: CartModel
) -> tuple[str, ...]:
    """Where `identify` says something else of a log than an online filter did, and what it has to say of the log; of no
    log that is long."""
    if len(log) > MAX_TWICE_FITTED_ROWS:
        return ()
    found = identify([log], cart)
    said = (words.removeprefix(f"{log.name}: ") for one in found.logs if one.band for words in one.words)
    return *said, *disagreements(found.parameters, parameters, health)


def disagreements(
    whole: Mapping[str, ParameterEstimate], online: Mapping[str, ParameterEstimate], health: str
) -> tuple[str, ...]:
    """Disagreements, in words, about parameters that at least one of the two says it was taught."""
    return tuple(
        f"{name}: identify, by least squares over the whole log, says {_words(whole[name])}, "
        f"the online filter {_words(one)} with health {health}; "
        "ask `cartgrasp discrepancy` what the model lacks; where it finds nothing, believe identify, which allows for "
        "what is left"
        for name, one in online.items()
        if name in whole and (one.identifiable or whole[name].identifiable) and _apart(whole[name], one)
    )


def _apart(one: ParameterEstimate, other: ParameterEstimate) -> bool:
    """Whether two values are not one; what is no number is none that another confirms."""
    off = abs(one.value - other.value)
    within_noise = off <= DISAGREEMENT_SIGMAS * math.hypot(one.std, other.std)
    return not (within_noise or off <= DISAGREEMENT_RATIO * max(abs(one.value), abs(other.value)))


def _words(one: ParameterEstimate) -> str:
    return f"{one.value:.4g} ± {one.std:.2g} {one.unit}"
