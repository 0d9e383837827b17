"""Logs in which nobody pushes, for what learns from wrenches: the wrench is zero, and known to be.

Motion then tells forces, CoM and inertia per mass only, so the mass is taken as given, and all else is told for it.
On a rail nothing tells of CoM and inertia.
"""

from __future__ import annotations

from collections.abc import Sequence

from cartgrasp.first_guess import PHYSICAL_NAMES
from cartgrasp.logs import RunLog, coasts
from cartgrasp.logs.coasting import with_zero_wrench
from cartgrasp.model import CartModel

from ..prior import Prior


def with_known_wrench(log: RunLog) -> RunLog:
    """The log, with its wrench written out where nobody pushes."""
    return with_zero_wrench(log) if coasts(log) else log


def as_given(logs: Sequence[RunLog], cart: CartModel) -> tuple[str, ...]:
    """Names of the body's parameters that nothing tells where nobody pushes in any of the logs."""
    if not all(coasts(log) for log in logs):
        return ()
    return PHYSICAL_NAMES if cart.constraints.no_rotation else PHYSICAL_NAMES[:1]


def prior_of(logs: Sequence[RunLog], cart: CartModel) -> Prior:
    """The usual prior, with what nothing tells known. Where nobody pushes floors are as the cart has them: on a way
    that goes straight on, nothing tells a slope from drag."""
    known = frozenset(as_given(logs, cart))
    return Prior(slope=0.0, known=known) if known else Prior()
