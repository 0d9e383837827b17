"""What a controller does less of while the estimator is not well: it slows down along its path, and widens margins."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from cartgrasp.checks import check_kind, number, positive
from cartgrasp.motion import Estimate, Reference
from cartgrasp.roles import ReferencePath

QUICKEST, WIDEST = 100.0, 100.0


@dataclass(frozen=True)
class Caution:
    """By the estimate's health, of which those left out change nothing.

    Args:
        pace: Share of the reference's speed at which the cart goes on, 0 to 1.
        widen: Times as many standard deviations are kept from limits with a `confidence`, 1 or more.
        change: Of the pace at most, 1/s: 0.5 stops within 2 s.

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
        }
    )
    widen: Mapping[str, float] = field(default_factory=lambda: {"inconsistent": 2.0, "outliers": 1.5, "no_wrench": 1.5})
    change: float = 0.5

    def __post_init__(self) -> None:
        for name, low, high in (("pace", 0.0, 1.0), ("widen", 1.0, WIDEST)):
            rule = getattr(self, name)
            check_kind(f"caution: {name}", rule, Mapping, 'write {"inconsistent": …}')
            for health, value in rule.items():
                number(f"caution: {name}: {health}", value, low, high)
        positive("caution: change", self.change, QUICKEST, "give 1/s")

    def widened(self, estimate: Estimate) -> Estimate:
        """The estimate with a covariance that is as much wider."""
        times = self.widen.get(estimate.health, 1.0)
        if times == 1.0 or estimate.covariance is None:
            return estimate
        return estimate._replace(covariance=times**2 * estimate.covariance)


@dataclass(frozen=True)
class Pace:
    """How far `along` the reference one is (s of it), at which `share` of its speed, which changes by `rate` (1/s)."""

    along: float
    share: float = 1.0
    rate: float = 0.0

    def after(self, duration: float, wanted: float, change: float) -> Pace:
        """So many s later, the share being wanted so."""
        if duration <= 0:
            return replace(self, rate=0.0)
        share = self.share + float(np.clip(wanted - self.share, -change * duration, change * duration))
        return Pace(self.along + duration * (self.share + share) / 2, share, (share - self.share) / duration)

    def reference(self, path: ReferencePath, time: float) -> Reference:
        """Where the cart should be: with s(t) the share, `nu = s nu_r`, `nu' = s² nu_r' + s' nu_r`."""
        there = path.at(self.along)
        velocity = self.share * there.velocity
        acceleration = self.share**2 * there.acceleration + self.rate * there.velocity
        return Reference(time, there.pose_sb, velocity, acceleration)
