"""`cartgrasp identify LOG [LOG …] --cart cart.yaml`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from estimation.whole_log.agreement import against_filter
from estimation.whole_log.identification import Identification
from estimation.whole_log.identification import identify as fit

from ..errors import DataError
from ..logs import RunLog
from ..model import CartModel
from .log_inputs import CART_FILE_NAME, Sources, cart_and_logs
from .output import print_json, progress, say
from .run_tables import print_parameters
from .sensors import check_logs


def run(sources: Sources, out: Path | None, as_json: bool) -> int:
    cart, logs = cart_and_logs(sources, out)
    looks = check_logs(logs, cart, sources.accepted, is_told=not as_json)
    with progress(f"identifying {cart.name}") as tell:
        found = fit(logs, cart, progress=tell)
        found = _held_against_filter(found, logs, cart)
    if as_json:
        print_json({**found.as_dict(), "checked": looks})
    else:
        _print(found)
    if out is not None:
        say(f"the cart with these values is {found.cart().save(out / CART_FILE_NAME)}")
    return 0


def _held_against_filter(found: Identification, logs: Sequence[RunLog], cart: CartModel) -> Identification:
    """With what the online filter says of a log that is another thing. A log that it can't follow tells nothing."""
    told = []
    for log, fitted in zip(logs, found.logs, strict=True):
        try:
            words = against_filter(found.parameters, log, cart)
        except DataError:
            words = ()
        told.append(replace(fitted, words=(*fitted.words, *words)))
    return replace(found, logs=tuple(told))


def _print(found: Identification) -> None:
    title = f"{found.structure.name}, from {len(found.logs)} log{'s' * (len(found.logs) > 1)}"
    print_parameters(title, found.parameters, "taught by these motions")
    for log in found.logs:
        for words in log.words:
            print(f"- {words}")
        if log.noise_excess > 2:
            left = f"{log.noise_excess:.1f} times the noise variance is left; deviations allow for it"
            print(f"- {log.name}: {left}, and `cartgrasp discrepancy` looks for what is missing")
