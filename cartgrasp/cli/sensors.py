"""A look at logs before anything is learned from them: what they hold, and what their sensors seem to do."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from estimation.sensor_check import SUSPICION_KINDS, LogInspection, Suspicion, check_sizes, look_at
from estimation.whole_log.coasting import as_given

from ..effects.effect import SensorEffect
from ..errors import DataError, UsageError, printable
from ..logs import RunLog
from ..logs.coasting import without_idle_arms
from ..model import CartModel
from .output import say


def check_accepted(kinds: Iterable[str]) -> None:
    unknown = sorted(set(kinds) - set(SUSPICION_KINDS))
    if unknown:
        raise UsageError(f"--accept {unknown[0]}: is no kind of suspicion; they are {', '.join(SUSPICION_KINDS)}")


def checked_log(log: RunLog, cart: CartModel | None) -> LogInspection:
    """The look at a log, without wrenches where nobody pushes. Raises DataError where the log is too short, too long,
    or too odd to be looked at."""
    check_sizes(log)
    try:
        with np.errstate(all="ignore"):  # what sums up to more than a number holds is told as such
            return look_at(without_idle_arms(log), cart)
    except np.linalg.LinAlgError as error:
        raise DataError(f"{log.name}: can't be looked at; look for numbers that are not in SI units") from error


def refuse_suspicions(log: RunLog, suspicions: Iterable[Suspicion], accepted: Sequence[str]) -> None:
    """Raises DataError where something makes every estimate worthless, and isn't accepted."""
    for one in suspicions:
        if one.is_refused and one.kind not in accepted:
            raise DataError(f"{log.name}: {one.words}; or say --accept {one.kind} if it is as it should be")


def check_logs(
    logs: Sequence[RunLog], cart: CartModel, accepted: Sequence[str], is_told: bool = True
) -> list[dict[str, Any] | None]:
    """Before anything is learned: refuses what surely is wrong, and else tells each log in a few lines, unless JSON
    alone is asked for, and what is taken as given where nobody pushes. Each look as JSON has it, None of a log that
    can't be looked at: what learns from it says itself what it lacks."""
    found = [_look(log, cart) for log in logs]
    for log, look in zip(logs, found, strict=True):
        if isinstance(look, LogInspection):
            refuse_suspicions(log, look.suspicions, accepted)
    for log, look in zip(logs, found, strict=True) if is_told else ():
        _tell(log, look)
    if is_told:
        _report_unknown_arms(logs, cart)
    _report_assumed_values(logs, cart)
    return [look.as_dict() if isinstance(look, LogInspection) else None for look in found]


def _report_unknown_arms(logs: Sequence[RunLog], cart: CartModel) -> None:
    """Sensors of the cart file whose arms are in no log, so that they say nothing of it."""
    arms = {arm for log in logs for arm in log.arms}
    for effect in cart.effects:
        if isinstance(effect, SensorEffect) and effect.label and effect.label not in arms:
            known = f"there are {', '.join(map(printable, sorted(arms)))}" if arms else "nobody pushes"
            say(f"{cart.name}: {printable(effect.key)}: no log has that arm; {known}")


def _report_assumed_values(logs: Sequence[RunLog], cart: CartModel) -> None:
    """What can't be learned where nobody pushes."""
    if logs and (given := as_given(logs, cart)):
        mass = f"mass ({cart.inertia.mass:g} kg)"
        body = f"{mass}, CoM and inertia are" if len(given) > 1 else f"{mass} is"
        rest = "forces are told for them" if len(given) > 1 else "CoM, inertia and forces are told for it"
        say(f"{', '.join(log.name for log in logs)}: nobody pushes: {body} taken as given, and {rest}")


def _look(log: RunLog, cart: CartModel) -> LogInspection | DataError:
    try:
        return checked_log(log, cart)
    except DataError as error:
        return error


def _tell(log: RunLog, look: LogInspection | DataError) -> None:
    if isinstance(look, DataError):
        why = str(look).removeprefix(f"{log.name}: ")
        say(f"{log.name}: {len(log)} rows over {log.duration:.3g} s; its sensors were not judged: {why}")
        return
    seen = look.overview
    of_arms = [
        f"{printable(one.where)} up to {one.largest[0]:.3g} N (noise {one.noise[0] or 0.0:.2g} N)"
        for one in seen.sensors
        if one.where in seen.arms and one.largest[0] is not None
    ]
    say(f"{log.name}: {log_summary(look)}" + "".join(f"; {one}" for one in of_arms))
    for one in look.suspicions:
        say(f"  suspected with {one.probability:.2f}, {one.kind}: {one.words}")
    if look.unjudged:
        say(f"  signs, axes and units of its wrenches were not judged: {look.unjudged}")


def log_summary(look: LogInspection) -> str:
    """A log in one line."""
    seen = look.overview
    rate = "" if seen.rate is None else f" at {seen.rate:.4g} Hz"
    return (
        f"{seen.rows} rows over {seen.span:.1f} s{rate}, {seen.travelled:.1f} m at up to {seen.fastest:.2g} m/s and "
        f"{seen.hardest:.2g} m/s²"
    )
