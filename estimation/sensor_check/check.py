"""What a log's sensors seem to do, and the log with what is safe to mend put right, before anything is fitted.

Late or scaled velocities are put on the poses' clock and scale, and rows that repeat or lie between others are left
out. Signs, axes, frames and units are told with the cure and never mended unasked: a log with a wrong one says
something else, and only who recorded it knows.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass
from itertools import pairwise
from typing import Any

from cartgrasp.constraints import RollingConstraints
from cartgrasp.errors import DataError
from cartgrasp.inertia import Inertia
from cartgrasp.logs import RunLog
from cartgrasp.model import CartModel

from ..log_noise.glitches import without_glitches
from ..log_noise.sentinel_values import without_sentinels
from ..weak_form.balances import Balances
from ..weak_form.log_segments import MAX_SEGMENT_POSE_GAP, split_at_gaps
from ..weak_form.motion import motion_of
from .fixed_wheels import wheel_suspicions
from .heading import drift_suspicions, heading_drift, heading_suspicions, without_drift
from .jumps import jumps
from .overview import Overview
from .recording_artefacts import frozen, interpolated, quantised, repeated, slow, unreadable_columns
from .repeated_rows import without_repeats
from .sizes import length_unit_suspicions
from .suspicion import Suspicion
from .velocities import corrected_velocities
from .wrenches import judged_wrenches

UNCONSTRAINED_CART = CartModel(Inertia(1.0, (0.0, 0.0), 1.0), RollingConstraints(axle_x=None))
"""A cart that may go any way."""
NO_CART = "no cart was given; say --cart cart.yaml"
ODD_POSES = "mend the poses first"


@dataclass(frozen=True, eq=False)
class CorrectedLog:
    """The log with what is safe to mend put right, and what was found on the way."""

    log: RunLog
    suspicions: tuple[Suspicion, ...]


def corrected_log(log: RunLog, cart: CartModel | None) -> CorrectedLog:
    """Mends and judges poses, velocities and recorders; what wrenches do is seen in balances of the mended log
    (`wrench_suspicions`)."""
    fresh = without_repeats(log)
    clean, between = interpolated(fresh)
    drift = None if cart is None else heading_drift(clean, cart)
    clean = without_drift(clean, drift)
    right, of_speeds = corrected_velocities(clean)
    told = (
        *length_unit_suspicions(log),
        *(() if cart is None else (*heading_suspicions(clean, cart), *frozen(log, cart))),
        *drift_suspicions(drift),
        *of_speeds,
        *repeated(log, fresh),
        *between,
        *quantised(log),
        *slow(log),
        *jumps(fresh),
    )
    return CorrectedLog(right, told)


@dataclass(frozen=True)
class LogInspection:
    """What a log holds, all that is suspected of its sensors, what stops a command first, and why wrenches were not
    judged, "" where they were or nobody pushes."""

    overview: Overview
    suspicions: tuple[Suspicion, ...]
    unjudged: str = ""

    def as_dict(self) -> dict[str, Any]:
        """The look as `cartgrasp check` says it."""
        fields = ("kind", "where", "probability", "factor", "words")
        told = [{name: getattr(one, name) for name in fields} for one in self.suspicions]
        return {**asdict(self.overview), "suspicions": told, "unjudged": self.unjudged}


def look_at(log: RunLog, cart: CartModel | None) -> LogInspection:
    """Looks at a log. Without a cart nothing is suspected of wrenches, nor of headings. Of a log with holes its longest
    part is judged. Raises DataError for a log that is too short to be looked at."""
    told, log = unreadable_columns(log), without_sentinels(log)
    parts = split_at_gaps(without_glitches(log), MAX_SEGMENT_POSE_GAP)
    longest = max(parts, key=len)
    others = [part for part in parts if part is not longest]
    sensors, of_arms = corrected_log(longest, cart), tuple[Suspicion, ...]()
    is_odd = any(one.kind == "unit" and one.where == "pose" for one in sensors.suspicions)
    if cart is None or is_odd:
        motions, unjudged = [motion_of(sensors.log, UNCONSTRAINED_CART)], NO_CART if log.arms else ""
        unjudged = ODD_POSES if is_odd else unjudged
    else:
        balances = Balances.of(sensors.log, cart)
        motions, (of_arms, unjudged) = [balances.motion], judged_wrenches(balances, cart)
        of_arms = (*of_arms, *wheel_suspicions(balances, cart))
    for part in others:
        with suppress(DataError):  # it is too short
            motions.append(motion_of(corrected_log(part, None).log, UNCONSTRAINED_CART))
    jumped = (one for part in others for one in jumps(part))
    found = (*told, *sensors.suspicions, *of_arms, *jumped, *_holes(parts))
    return LogInspection(Overview.of(log, motions), tuple(sorted(found, key=lambda one: not one.is_refused)), unjudged)


def check_sensors(log: RunLog, cart: CartModel | None) -> tuple[Suspicion, ...]:
    """What is suspected, as `look_at` has it."""
    return look_at(log, cart).suspicions


def _holes(parts: Sequence[RunLog]) -> Iterator[Suspicion]:
    """A clock that jumped, or a recorder that paused."""
    for before, after in pairwise(parts):
        begins, ends = float(before.time[-1]), float(after.time[0])
        words = (
            f"from t = {begins:g} s to {ends:g} s nobody saw the cart: a recorder that paused, or a clock that jumped; "
            "parts are judged apart, so split the log there, or mend its clock"
        )
        yield Suspicion("holes", "time", 0.99, ends - begins, words)
