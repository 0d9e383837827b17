"""`cartgrasp identify LOG [LOG …] --cart cart.yaml`."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from estimation.identification import Identification
from estimation.identification import identify as fit

from .estimate import print_parameters, tell_given
from .log_inputs import cart_and_logs
from .output import print_json, progress, say


def run(
    paths: Sequence[Path],
    cart_path: Path | None,
    out: Path | None,
    topics: Path | None,
    as_json: bool,
    coasting: bool = False,
) -> int:
    cart, logs = cart_and_logs(paths, cart_path, out, topics, coasting)
    tell_given(logs, cart)
    with progress(f"identifying {cart.name}") as tell:
        found = fit(logs, cart, progress=tell)
    if as_json:
        print_json(found.as_dict())
    else:
        _print(found)
    if found.refused:
        say(f"{found.structure.name}: {found.refused}")
    if out is not None:
        say(f"the cart with these values is {found.cart().save(out / 'cart.yaml')}")
    return 0


def _print(found: Identification) -> None:
    title = f"{found.structure.name}, from {len(found.logs)} log{'s' * (len(found.logs) > 1)}"
    print_parameters(title, found.parameters, "taught by these motions")
    for log in found.logs:
        for words in log.words:
            print(f"- {words}")
        if log.noise_excess > 2:
            say(
                f"{log.name}: the model misses {log.noise_excess:.1f} times the noise variance; deviations allow for it"
            )
