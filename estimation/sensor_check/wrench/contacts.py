"""Contact points in another unit: nobody holds a cart hundreds of metres from its axle."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from cartgrasp.errors import printable
from cartgrasp.logs import RunLog
from cartgrasp.logs.run_log import ArmLog

from ..evidence import log_normal_density, probabilities
from ..prior import CONTACT_UNITS, REACH, REACH_SPREAD
from ..suspicion import SURE, TOLD, Suspicion


def contact_units(log: RunLog) -> tuple[Suspicion, ...]:
    """`unit` of the contact points of each arm."""
    told = []
    for name in log.arms:
        judged = _judged(log, name)
        if judged is None or 1 - judged[0] < TOLD:
            continue
        unit, factor, _ = CONTACT_UNITS[1 + int(judged[1:].argmax())]
        words = (
            f"{printable(name)}: contact points seem to be in {unit}, they are {_reach(log, name):.3g} from the "
            f"cart's origin; multiply px, py and pz by {factor:g}"
        )
        told.append(Suspicion("unit", name, 1 - float(judged[0]), factor, words))
    return tuple(told)


def contacts_put_right(log: RunLog) -> RunLog:
    """The log with contact points in metres, as far as they are sure."""
    arms = dict(log.arms)
    for name, arm in log.arms.items():
        judged = _judged(log, name)
        if judged is not None and judged.max() >= SURE:
            arms[name] = ArmLog(arm.contact * CONTACT_UNITS[int(judged.argmax())][1], arm.wrench)
    return replace(log, arms=arms)


def _reach(log: RunLog, name: str) -> float | None:
    """The median distance of an arm's contact points from {b}'s origin; None where they are not told, or all 0."""
    contact = log.arms[name].contact
    whole = contact[np.isfinite(contact).all(axis=1)]
    reach = float(np.median(np.linalg.norm(whole, axis=1))) if len(whole) else 0.0
    return reach if reach > 0 else None


def _judged(log: RunLog, name: str) -> np.ndarray | None:
    """Probabilities of `CONTACT_UNITS`."""
    reach = _reach(log, name)
    if reach is None:
        return None
    off = np.array([math.log(reach * factor / REACH) for _, factor, _ in CONTACT_UNITS])
    return probabilities(log_normal_density(off, REACH_SPREAD), np.array([prior for *_, prior in CONTACT_UNITS]))
