"""What is known of each measured log, by means simpler than ours and apart from them, and where that is from."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

DRAGS = frozenset(
    {"viscous_drag", "rolling_resistance", "quadratic_drag", "stribeck_friction", "directional_drag", "floor_patch"}
)
CONSTANT_FORCES = frozenset({"force_bias", "floor_slope", "rolling_resistance"})
"""On a rail that is driven one way, these are one force."""


@dataclass(frozen=True)
class Interval:
    """Where a number lies, in `unit`, and what says so. A value is inside if it is no more than `deviations` of its own
    beyond."""

    low: float
    high: float
    unit: str
    source: str
    deviations: float = 0.0

    def holds(self, value: float, std: float = 0.0, deviations: float | None = None) -> bool:
        """Whether it holds the value, or comes as near to it as so many of its standard deviations."""
        reach = (self.deviations if deviations is None else deviations) * std
        return self.low - reach <= value <= self.high + reach

    @property
    def words(self) -> str:
        if self.low == self.high:
            return f"{self.low:g} {self.unit}"
        return f"{self.low:g} to {self.high:g} {self.unit}"


@dataclass(frozen=True)
class Truth:
    """What is known of one log.

    `mass` is None where no force was recorded: it is given, and nothing can teach it. `values` are intervals of what
    `told_values.py` reads off a report. Of each set in `must`, one name is told, in this order if `in_order`; a name
    that is in none of them and not in `may` is wrong. `source` says why those may be told.
    """

    mass: Interval | None
    must: tuple[frozenset[str], ...] = ()
    may: frozenset[str] = frozenset()
    values: Mapping[str, Interval] = field(default_factory=dict)
    in_order: bool = False
    source: str = ""

    @property
    def allowed(self) -> frozenset[str]:
        return self.may.union(*self.must)

    @property
    def words(self) -> str:
        """For a table."""
        mass = "mass as given" if self.mass is None else f"mass {self.mass.words}"
        names = [" or ".join(sorted(one)) for one in self.must]
        values = [f"{name} {interval.words}" for name, interval in self.values.items()]
        return "; ".join([mass, *([", then ".join(names)] if self.in_order else names), *values])


WHEELCHAIR = Truth(
    mass=Interval(75, 130, "kg", "least squares both ways, 76 and 130 kg; a fit in weak form says 105 ± 5 kg"),
    must=(frozenset({"rolling_resistance"}),),
    may=frozenset({"force_bias", "floor_slope", "load_slosh", "learned_force"}),
    values={"rolling force": Interval(10, 17, "N", "13.5 to 13.7 N by least squares, whatever the smoothing")},
    source="the sensor has an offset and a wave once a turn, a person leans to and fro, one side of two was measured",
)
CAR = Truth(
    mass=Interval(185, 260, "kg", "least squares both ways, 195 to 214 kg in this run, 227 to 247 kg in its sisters"),
    may=CONSTANT_FORCES | {"quadratic_drag", "stribeck_friction", "learned_force"},
    source="the sensor's zero, the ground's slope and the front wheels' drag can't be told apart; resistance differs "
    "with speed; a wave once a turn",
)
EMPS = Truth(
    mass=Interval(94.6, 95.6, "kg", "95.1 kg, the reference of the data's authors; 0.5 kg is between their models"),
    must=(frozenset({"rolling_resistance"}), frozenset({"directional_drag"})),
    values={"rolling force": Interval(20.4, 20.4, "N", "the authors' 20.39 N", deviations=1.0)},
    in_order=True,
    source="a third term gains 1.4 % on held-out data at most; what looks like an offset is drag that differs by "
    "direction",
)

SLOPE = Interval(1.7, 2.3, "°", "0.33 to 0.35 m/s² downhill with 0.02 to 0.04 m/s² of drag, flight by flight")
BUMPER = Interval(1.12, 1.18, "m", "where the cart turns back, to the centimetre that the ranger shows")
ON_AN_INCLINE = DRAGS | {"external_push", "learned_force"}


def _incline(slope: Interval) -> Truth:
    """Of a cart that is let go, runs down a track and bounces."""
    return Truth(
        mass=None,
        must=(frozenset({"floor_slope"}), frozenset({"end_stop"})),
        may=ON_AN_INCLINE,
        values={"slope": slope, "end stop": BUMPER},
        source="Coulomb and viscous drag can't be told apart, and for the first second a hand holds the cart",
    )


GOOD_CART = MAGNETIC_BUMPER = _incline(SLOPE)
SAIL = _incline(Interval(1.5, 2.3, "°", "parabolas up and down say 1.6 to 1.9°, and a sail's drag is no constant"))
STILL = Truth(mass=None, source="nothing moves")


def downhill(grade_x: float) -> float:
    """Degrees, of a floor that falls along the world's x, from its rise over run."""
    return math.degrees(math.atan(-grade_x))
