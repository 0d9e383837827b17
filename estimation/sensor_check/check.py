"""What a log's sensors seem to do, and the log with what is safe to mend put right, before anything is fitted.

Late or scaled velocities are put on the poses' clock and scale, and rows that repeat or lie between others are left
out. Signs, axes, frames and units are told with the cure and never mended unasked: a log with a wrong one says
something else, and only who recorded it knows.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

from cartgrasp.constraints import RollingConstraints
from cartgrasp.inertia import Inertia
from cartgrasp.logs import RunLog
from cartgrasp.model import CartModel

from ..weak_form.balances import Balances
from ..weak_form.flights import LONGEST_HOLE, unbroken
from ..weak_form.motion import FEWEST_ROWS, motion_of
from .heading import of_headings
from .recorder import frozen, interpolated, quantised, repeated, slow
from .stale import without_stale
from .suspicion import Suspicion
from .velocities import of_velocities
from .wrenches import of_wrenches


@dataclass(frozen=True, eq=False)
class Sensors:
    """The log with what is safe to mend put right, and what was found on the way."""

    log: RunLog
    suspicions: tuple[Suspicion, ...]


def put_right(log: RunLog, cart: CartModel | None) -> Sensors:
    """Of poses, velocities and recorders; what wrenches do is seen in balances of that log (`of_wrenches`)."""
    fresh = without_stale(log)
    clean, between = interpolated(fresh)
    right, of_speeds = of_velocities(clean)
    headed = () if cart is None else (*of_headings(clean, cart), *frozen(log, cart))
    told = (*headed, *of_speeds, *repeated(log, fresh), *between, *quantised(log), *slow(log))
    return Sensors(right, told)


def check_sensors(log: RunLog, cart: CartModel | None) -> tuple[Suspicion, ...]:
    """All that is suspected of a log's sensors, what stops a command first; without a cart nothing of wrenches, nor of
    headings. Of a log with holes its longest part is looked at."""
    parts = unbroken(log, LONGEST_HOLE)
    longest = max(parts, key=len)
    sensors = put_right(longest, cart)
    of_arms = () if cart is None else of_wrenches(Balances.of(sensors.log, cart), cart)
    found = (*sensors.suspicions, *of_arms, *_holes(parts))
    return tuple(sorted(found, key=lambda one: not one.is_refused))


def _holes(parts: Sequence[RunLog]) -> Iterator[Suspicion]:
    """A clock that jumped, or a recorder that paused."""
    for before, after in pairwise(parts):
        begins, ends = float(before.time[-1]), float(after.time[0])
        words = (
            f"from t = {begins:g} s to {ends:g} s nobody saw the cart: a recorder that paused, or a clock that jumped; "
            "parts are judged apart, so split the log there, or mend its clock"
        )
        yield Suspicion("holes", "time", 0.99, ends - begins, words)


def travelled(log: RunLog) -> float:
    """How far {b}'s origin goes (m), as any cart may."""
    anything = CartModel(Inertia(1.0, (0.0, 0.0), 1.0), RollingConstraints(axle_x=None))
    parts = (part for part in unbroken(log, LONGEST_HOLE) if len(part) >= FEWEST_ROWS)
    return sum(float(motion_of(put_right(part, None).log, anything).way[-1]) for part in parts)
