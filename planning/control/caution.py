"""What a controller does less of while not all is well: it slows down along its path, and widens margins."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from operator import itemgetter

from cartgrasp.checks import MAX_DISTANCE, check_kind, check_known, number, positive
from cartgrasp.frames import Array
from cartgrasp.motion import Estimate, Reference
from cartgrasp.roles import ReferencePath

from ..plan import USABLE

MAX_CHANGE, MAX_WIDENING = 100.0, 100.0
MAX_STEP_GAP = 0.3
"""s between two steps, if not of such a period, from which on nobody drove the cart meanwhile."""
HEALTHS = frozenset({"ok", "stale", "clock_went_back", "no_wrench", "inconsistent", "load_changed", "outliers"})
"""The words of `estimation.Health`, which planning does not know."""
OK, IDLE, NO_ARM = "ok", "idle_arm", "no_arm"
"""The health under which all is well; and the words for an arm that is felt to give little of what it is told, and for
all of them, in its place."""
TRUSTED_HEALTHS = frozenset({OK, "load_changed", "no_wrench"})
"""Healths under which what is learned holds, as far as it says itself."""
COMMAND_TRACKING_WORDS = {IDLE: "an arm gives little", NO_ARM: "no arm gives what it is told"}


@dataclass(frozen=True)
class Caution:
    """By the estimate's health, or `idle_arm` and `no_arm`, of which those left out change nothing. The cart also stops
    along its path while no plan can be given, and while it is behind; and where what is measured of its motion surely
    isn't it, it is stopped. After `load_changed` the filter's own deviations are as wide as needed. A cart that
    coasts, since no arm gives anything, is not waited for where it is ahead.

    Args:
        pace: Share of the reference's speed at which the cart goes on, 0 to 1.
        widen: Times as many standard deviations are kept from limits with a `confidence`, 1 or more.
        change: Of the pace at most, 1/s: 0.5 stops within 2 s.
        short: Share of the reference's speed while not all of the margins can be kept.
        astray: m and rad off the path, from which on the cart is not driven there but stopped (protective_stop.py).
        behind: m along the path from where the cart is to be, from which on the reference waits for it. Beside the
            path no waiting helps: wheels that don't slip get back to it by going on.
        sure: Deviation of the mass, as a share of it, up to which the tracker uses what is newly learned of the cart;
            and only where the model fits. Else it goes on with the cart that it used last, unless the new one is surer.
            Of an estimator that tells a disturbance, which is what a cart leaves unexplained, it uses that very cart.

    Raises:
        UsageError: A number is out of bounds.
    """

    pace: Mapping[str, float] = field(
        default_factory=lambda: {
            "stale": 0.0,
            "clock_went_back": 0.5,
            "no_wrench": 0.5,
            "inconsistent": 0.5,
            "load_changed": 0.7,
            "outliers": 0.7,
            IDLE: 0.5,
            NO_ARM: 0.0,
        }
    )
    widen: Mapping[str, float] = field(default_factory=lambda: {"inconsistent": 2.0, "outliers": 1.5, "no_wrench": 1.5})
    change: float = 0.5
    short: float = 0.5
    astray: float = 1.0
    behind: float = 0.3
    sure: float = 0.15

    def __post_init__(self) -> None:
        for name, low, high in (("pace", 0.0, 1.0), ("widen", 1.0, MAX_WIDENING)):
            rule = getattr(self, name)
            check_kind(f"caution: {name}", rule, Mapping, 'write {"inconsistent": …}')
            for health, value in rule.items():
                check_known(f"caution: {name}", [health], HEALTHS | COMMAND_TRACKING_WORDS.keys())
                number(f"caution: {name}: {health}", value, low, high)
        positive("caution: change", self.change, MAX_CHANGE, "give 1/s")
        number("caution: short", self.short, 0.0, 1.0)
        for name in ("astray", "behind"):
            positive(f"caution: {name}", getattr(self, name), MAX_DISTANCE, "give m")
        positive("caution: sure", self.sure, MAX_CHANGE, "give a share")

    def wanted(self, health: str, last: tuple[str, str], behind: float) -> tuple[float, str]:
        """The share of its speed at which the reference is to go on, and why not at all of it; of the `last` plan there
        are status and what it says of margins; `behind` is how far (m) along the path the cart is behind where it was
        to be."""
        status, margins = last
        share = 1.0 if health == NO_ARM and behind < 0.0 else self.pace.get(health, 1.0)
        if share == 1.0 and not margins and status in USABLE and behind <= self.behind:
            return 1.0, ""
        why = COMMAND_TRACKING_WORDS.get(health, f"health {health}")
        reasons = [(1.0, ""), (share, f"slows to {100 * share:.0f} % of its speed: {why}")]
        if margins:
            reasons.append((self.short, f"slows to {100 * self.short:.0f} % of its speed"))
        if status not in USABLE:
            reasons.append((0.0, f"stops: the plan is {status}"))
        if behind > self.behind:
            reasons.append((0.0, f"waits for the cart, which is {behind:.2g} m behind"))
        return min(reasons, key=itemgetter(0))

    def is_used(self, new: Estimate, used: Estimate) -> bool:
        """Whether the tracker is to use what is newly believed of the cart, not what it `used` last."""
        if new.disturbance is not None:
            return True
        return new.health in TRUSTED_HEALTHS and _unsure(new) <= max(self.sure, _unsure(used))

    def wider(self, health: str) -> str:
        """In words, how many times as wide margins are; empty where they are as they were."""
        times = self.widen.get(health, 1.0)
        return "" if times == 1.0 else f"keeps {times:g} times the margins: health {health}"

    def widened(self, estimate: Estimate) -> Estimate:
        """The estimate with a covariance that is as much wider."""
        times, own, on_floor = self.widen.get(estimate.health, 1.0), estimate.covariance, estimate.covariance_on_floor
        if times == 1.0:
            return estimate
        return estimate._replace(
            covariance=None if own is None else times**2 * own,
            covariance_on_floor=None if on_floor is None else times**2 * on_floor,
        )


def behind_of(there: Reference, pose_sb: Array) -> float:
    """How far (m) a pose is behind the reference, where that goes; from it, either way, where it stands."""
    x, y, heading = there.pose_sb.tolist()
    away = math.cos(heading) * float(x - pose_sb[0]) + math.sin(heading) * float(y - pose_sb[1])
    speed = float(there.velocity[0])
    return math.copysign(1.0, speed) * away if speed else abs(away)


def _unsure(estimate: Estimate) -> float:
    """The deviation of the mass as a share of it; 0 where nobody tells it."""
    mass = estimate.parameters.get("mass")
    return 0.0 if mass is None else mass.std / mass.value if mass.value > 0.0 else math.inf


@dataclass(frozen=True)
class Pace:
    """How far `along` the reference one is (s of it), at which `share` of its speed, which changes by `rate` (1/s)."""

    along: float
    share: float = 1.0
    rate: float = 0.0

    def after(self, duration: float, wanted: float, change: float, longest: float = MAX_STEP_GAP) -> Pace:
        """So many s later, the share being wanted so. After a pause, `longest` s and more, it goes on from rest."""
        if duration <= 0:
            return replace(self, rate=0.0)
        if duration > longest:
            return Pace(self.along, 0.0)
        share = self.share + min(max(wanted - self.share, -change * duration), change * duration)
        return Pace(self.along + duration * (self.share + share) / 2, share, (share - self.share) / duration)

    def reference(self, path: ReferencePath, time: float) -> Reference:
        """Where the cart should be: with s(t) the share, `nu = s nu_r`, `nu' = s² nu_r' + s' nu_r`."""
        there = path.at(self.along)
        velocity = self.share * there.velocity
        acceleration = self.share**2 * there.acceleration + self.rate * there.velocity
        return Reference(time, there.pose_sb, velocity, acceleration)
