"""`cartgrasp identify LOG [LOG …] --cart cart.yaml`."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from estimation.batch import Identification
from estimation.batch import identify as fit

from ..errors import UsageError
from ..logs import read_log
from .estimate import cart_of, print_parameters
from .output import make_folder, print_json, progress, say


def run(paths: Sequence[Path], cart_path: Path | None, out: Path | None, as_json: bool) -> int:
    cart = cart_of(paths[0], cart_path)
    check_distinct(paths)
    if out is not None:
        make_folder(out)
    logs = [read_log(path) for path in paths]
    with progress(f"identifying {cart.name}") as tell:
        found = fit(logs, cart, progress=tell)
    if as_json:
        print_json(found.as_dict())
    else:
        _print(found)
    if out is not None:
        say(f"the cart with these values is {found.cart().save(out / 'cart.yaml')}")
    return 0


def check_distinct(paths: Sequence[Path]) -> None:
    """The same run twice would count as twice the evidence."""
    seen = set()
    for path in paths:
        if path.resolve() in seen:
            raise UsageError(f"{path}: is given twice; name each log once")
        seen.add(path.resolve())


def _print(found: Identification) -> None:
    title = f"{found.structure.name}, from {len(found.logs)} log{'s' * (len(found.logs) > 1)}"
    print_parameters(title, found.parameters, "taught by these motions")
    for log in found.logs:
        if log.noise_excess > 2:
            say(
                f"{log.name}: the model misses {log.noise_excess:.1f} times the noise variance; deviations allow for it"
            )
