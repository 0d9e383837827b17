"""What a log's sensors seem to do, asked by every command that learns from logs, before it begins."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from estimation.glitches import without_glitches
from estimation.sensor_check import KINDS, Suspicion, check_sensors, check_sizes

from ..errors import DataError, UsageError
from ..logs import RunLog
from ..logs.coasting import without_idle_arms
from ..model import CartModel


def check_accepted(kinds: Iterable[str]) -> None:
    unknown = sorted(set(kinds) - set(KINDS))
    if unknown:
        raise UsageError(f"--accept {unknown[0]}: is no kind of suspicion; they are {', '.join(KINDS)}")


def suspected(log: RunLog, cart: CartModel | None) -> tuple[Suspicion, ...]:
    """Of a log without what stands alone among its neighbours, and of no wrenches where nobody pushes. Raises DataError
    where it is too short, too long, or too odd to be looked at."""
    check_sizes(log)
    try:
        with np.errstate(all="ignore"):  # what sums up to more than a number holds is told as such
            return check_sensors(without_glitches(without_idle_arms(log)), cart)
    except np.linalg.LinAlgError as error:
        raise DataError(f"{log.name}: can't be looked at; look for numbers that are not in SI units") from error


def refuse(log: RunLog, suspicions: Iterable[Suspicion], accepted: Sequence[str]) -> None:
    """Raises DataError where something makes every estimate worthless, and isn't accepted."""
    for one in suspicions:
        if one.is_refused and one.kind not in accepted:
            raise DataError(f"{log.name}: {one.words}; or say --accept {one.kind} if it is as it should be")


def refuse_wrong_sensors(logs: Iterable[RunLog], cart: CartModel, accepted: Sequence[str]) -> None:
    """Before anything is learned. Of a log that can't be looked at nothing is suspected: what learns from it says
    itself what it lacks."""
    for log in logs:
        try:
            found = suspected(log, cart)
        except DataError:
            continue
        refuse(log, found, accepted)
