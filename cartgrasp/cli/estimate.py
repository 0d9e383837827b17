"""`cartgrasp estimate LOG --cart cart.yaml`."""

from __future__ import annotations

from pathlib import Path

from estimation import Prior, identifiability
from estimation.sensor_check.repeated_rows import with_measured_wrenches
from estimation.whole_log.agreement import against_identify
from estimation.whole_log.coasting import prior_of
from estimation.whole_log.replay import Replay, as_replayed, estimated

from ..errors import DataError
from ..logs import RunLog
from ..logs.coasting import check_pushed
from ..model import CartModel
from ..writing import write_atomically
from .log_inputs import Sources, cart_and_logs
from .output import check_writable, print_json, progress, say
from .run_tables import print_health, print_parameters
from .sensors import check_logs


def run(sources: Sources, method: str, out: Path | None, as_json: bool) -> int:
    if out is not None:
        check_writable(out, *sources.files)
    cart, (log,) = cart_and_logs(sources)
    if method == "paper":
        check_pushed(log, "and the paper's filter learns the whole body; --method filter takes the mass as given")
    looks = check_logs([log], cart, sources.accepted, is_told=not as_json)
    with progress(f"estimating from {sources.logs[0].name}") as tell:
        told = as_replayed(with_measured_wrenches(log))
        result = estimated(told, cart, method, tell, until=float(log.time[-1]))
    if out is not None:
        write_atomically(out, result.series_csv())
    if as_json:
        print_json({**result.as_dict(), "checked": looks})
    else:
        _print(result, prior_of([log], cart))
    if method == "filter":
        _report_disagreements(result, log, cart)
    return 0


def _report_disagreements(result: Replay, log: RunLog, cart: CartModel) -> None:
    """With what `identify` says of the log. One that it can't fit tells nothing."""
    try:
        told = against_identify(result.last.parameters, str(result.last.health), log, cart)
    except DataError:
        return
    for words in told:
        say(f"{log.name}: {words}")


def _print(result: Replay, prior: Prior) -> None:
    spent = result.last.time - result.estimates[0].time
    title = f"After {spent:.2f} s, health: {result.last.health}"
    print_parameters(title, result.last.parameters, "taught by this motion", result.last.health)
    for one in result.last.suspicions:
        print(f"- {one.words}")
    if not result.last.suspicions:
        print_health(result.last.health)
    if result.last.covariance is not None:
        for one in identifiability(result.last, prior).untaught:
            print(f"- {one}")
