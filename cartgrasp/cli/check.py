"""`cartgrasp check LOG [--cart cart.yaml]`: what a log holds, and what its sensors seem to do, before anything is
learned from it."""

from __future__ import annotations

from pathlib import Path

from estimation.sensor_check import REFUSAL_PROBABILITY, REFUSED_KINDS, LogInspection

from ..cart_file import load_cart
from ..errors import UsageError, printable
from ..logs import RunLog, read_log
from .log_inputs import Sources
from .output import check_writable, print_json, print_table, say
from .sensors import check_accepted, checked_log, log_summary, refuse_suspicions

COLUMN_UNITS = {"pose": ("m", "rad"), "velocity": ("m/s", "rad/s")}
WRENCH_UNITS = "N", "N·m"
PICTURE_SUFFIXES = ".png", ".svg", ".pdf"


def run(sources: Sources, out: Path | None, as_json: bool) -> int:
    """Raises DataError where something makes every estimate worthless, and isn't accepted."""
    check_accepted(sources.accepted)
    (path,) = sources.logs
    cart = None if sources.cart is None else load_cart(sources.cart)
    if out is not None:
        if out.suffix.lower() not in PICTURE_SUFFIXES:
            raise UsageError(f"--out {out}: name a picture, {', '.join(PICTURE_SUFFIXES)}")
        check_writable(out, path, sources.cart, sources.topics)
    log = read_log(path, sources.topics)
    look = checked_log(log, cart)
    if out is not None:
        _draw(log, look, out)
    if as_json:
        print_json(look.as_dict())
    else:
        _print(look)
    refuse_suspicions(log, look.suspicions, sources.accepted)
    return 0


def _draw(log: RunLog, look: LogInspection, out: Path) -> None:
    from ..view.figures import figure_log, save_figure

    save_figure(figure_log(log, [(one.kind, one.where, one.probability) for one in look.suspicions]), out)
    say(f"the picture is {out}")


def _print(look: LogInspection) -> None:
    say(log_summary(look))
    rows = [
        [
            printable(one.where),
            *("" if value is None else f"{value:.4g}" for value in (one.rate, 100 * one.missing, one.gap)),
            _sized(one.where, one.noise, is_small=True),
            _sized(one.where, one.largest),
        ]
        for one in look.overview.sensors
    ]
    columns = ["sensor", "rate, Hz", "missing, %", "gap, s", "noise", "largest"]
    print_table("What the log holds", columns, rows)
    if look.unjudged:
        say(f"signs, axes and units of its wrenches were not judged: {look.unjudged}")
    if not look.suspicions:
        say("nothing is suspected of its sensors")
        return
    rows = [[one.kind, one.where, f"{one.probability:.2f}"] for one in look.suspicions]
    print_table(
        f"suspicions (from {REFUSAL_PROBABILITY:g} on {', '.join(REFUSED_KINDS)} stop)",
        ["kind", "where", "probability"],
        rows,
    )
    for one in look.suspicions:
        say(one.words)


def _sized(where: str, values: tuple[float | None, float | None], is_small: bool = False) -> str:
    """With units; small ones of motion in thousandths."""
    scale, milli = (1e3, "m") if is_small and where in COLUMN_UNITS else (1.0, "")
    pairs = zip(values, COLUMN_UNITS.get(where, WRENCH_UNITS), strict=True)
    return ", ".join(f"{scale * value:.2g} {milli}{unit}" for value, unit in pairs if value is not None)
