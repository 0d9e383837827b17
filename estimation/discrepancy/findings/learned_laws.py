"""Laws that logs follow, as effects with their sizes, and in words."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from cartgrasp.checks import unrounded
from cartgrasp.effects import LearnedForce
from cartgrasp.effects.learned_force import LEVER_TARGETS
from cartgrasp.frames import Array
from cartgrasp.model import CartModel

from ...weak_form.motion import Motion
from ..search.laws import Law, labelled, seen_values, unit_of, variable_of

FORCE_PHRASES = {
    "forward_force": "a forward force",
    "lateral_force": "a sideways force",
    "yaw_moment": "a yaw moment",
    "drag": "a drag",
    "viscous_drag": "a drag in proportion to speed",
    "world_force": "a force",
}
TIME_LAW_CAUSES = {"world_force": "wind that grows", "forward_force": "a force sensor whose zero drifts, or a tether"}
VARIABLE_LAW_CAUSES = {
    "travelled_distance": "a floor or a wheel that changes along the way",
    "place": "a tether, a ramp or a floor that changes",
    "speed": "air, a churned liquid, or bearings at speed",
    "yaw_rate": "tyres that scrub in turns",
    "since_reversal": "casters that swing round, or play that is taken up",
}
"""What usually makes a law that does not repeat."""
FULL_TURN = 2 * np.pi
SLOPE_STEPS_PER_PERIOD = 1000
"""Share of a period over which slopes are taken."""
WALKING_PERIODS = (0.4, 1.1)
"""Times (s) from step to step of a person who walks."""


# Many methods: one for each thing that a report says of a law; what is computed is `curve`.
@dataclass(frozen=True, eq=False)
class LearnedLaw:
    """One force of a law: the effect with its amplitudes (a,), their covariance (a, a), how well a period is known (in
    the variable's unit), and values (n,; n, 2 of places with knots of y) of the variable along the logs."""

    effect: LearnedForce
    covariance: Array
    period_std: float
    seen: Array

    @property
    def std(self) -> Array:
        """Standard deviations of the amplitudes (a,)."""
        return np.asarray(np.sqrt(np.maximum(np.diagonal(self.covariance), 0.0)))

    @property
    def unit(self) -> str:
        return unit_of(self.effect)

    @property
    def size(self) -> float:
        """Root mean square of the force as the logs went."""
        return float(np.sqrt(np.mean(self.curve(self.seen)[0] ** 2)))

    def curve(self, at: Array) -> tuple[Array, Array]:
        """The force at values of the variable, and its standard deviation (n,): of its numbers, and of where in its
        period the logs were, on the average."""
        shares = self.effect.shares(at)
        variance = np.maximum(np.einsum("na,ab,nb->n", shares, self.covariance, shares), 0.0)
        if self.effect.period:
            step = self.effect.period / SLOPE_STEPS_PER_PERIOD
            change = (self.effect.shares(at + step) - self.effect.shares(at - step)) @ self.effect.values / 2.0
            variance += (change / step * self.period_std * self.seen.std() / self.effect.period) ** 2
        return shares @ self.effect.values, np.sqrt(variance)

    @property
    def words(self) -> str:
        """The law in one sentence without a full stop."""
        return f"{self._force} {self._course}, {self._between}"

    @property
    def _between(self) -> str:
        """The force's range as the logs went, in words, in which what rounding makes of nought is nought."""
        force = self.curve(self.seen)[0]
        whole = float(np.abs(force).max())
        low, high = (unrounded(float(end), whole) for end in (force.min(), force.max()))
        return f"between {low:.2g} and {high:.2g} {self.effect.parameters[0].unit}"

    def is_beside(self, other: LearnedLaw) -> bool:
        """Whether it is the other part of one force of the world: of the same variable, another way."""
        one, before = self.effect, other.effect
        same = (one.of, one.period, one.knots, one.knots_y) == (before.of, before.period, before.knots, before.knots_y)
        return same and one.acts_on == before.acts_on == "world_force" and one.direction != before.direction

    @property
    def words_beside(self) -> str:
        """Words of the force that follow those of the other part."""
        return f", and{self._towards} {self._between}"

    @property
    def _towards(self) -> str:
        return f" towards {np.degrees(self.effect.direction):.0f}° of the world"

    @property
    def _force(self) -> str:
        effect = self.effect
        where = self._towards if effect.acts_on == "world_force" else ""
        if effect.lever and effect.acts_on in LEVER_TARGETS:
            where = f" {self._side}"
        return FORCE_PHRASES[effect.acts_on] + where

    @property
    def _of_wheel(self) -> str:
        """Which wheel's way it is, where it is one's."""
        return f" {'there' if self.effect.acts_on in LEVER_TARGETS else self._side}" if self.effect.lever else ""

    @property
    def _side(self) -> str:
        return f"{abs(self.effect.lever):.2g} m to the {'left' if self.effect.lever > 0 else 'right'}"

    @property
    def _course(self) -> str:
        effect = self.effect
        if effect.period:
            value = f"{effect.period:.3g} {self.unit}"
            return f"that repeats every {value}" + {
                "time": "",
                "travelled_distance": f" of the way rolled{self._of_wheel}",
                "place": f" of the floor along {'y' if abs(np.sin(effect.direction)) > 0.5 else 'x'}",
            }.get(effect.of, f" of {variable_of(effect)}")
        name = variable_of(effect)
        return f"that changes with the {name}" if effect.knots or effect.cycle else f"that is the same at every {name}"

    @property
    def likely(self) -> str:
        """What usually makes such a law."""
        return " or ".join(self._causes())

    def _causes(self) -> Iterator[str]:
        effect, period = self.effect, self.effect.period
        if effect.of == "travelled_distance" and period:
            wheel = f"the wheel {self._side}" if effect.lever else "a wheel"
            size = f"of radius {1e3 * period / FULL_TURN:.0f} mm: {period:.3g} m a turn"
            yield f"a flat spot, a bent rim or dirt on {wheel} {size}"
        elif effect.of == "time" and period:
            yield f"a second drive, a pump or a motor at {1 / period:.3g} Hz"
            if WALKING_PERIODS[0] <= period <= WALKING_PERIODS[1]:
                yield f"the steps of a person ({60 / period:.0f} a minute)"
        elif effect.of == "place" and period:
            yield f"seams or ridges of the floor, {period:.3g} m apart"
        elif not effect.knots and not effect.cycle:
            yield "rolling resistance of the wheels at {b} alone: list which wheels carry the load"
        elif effect.of == "heading":
            yield "the grain of the floor, or a carpet's pile" if "drag" in effect.acts_on else "wind, or a slope"
        elif effect.of == "time":
            yield TIME_LAW_CAUSES.get(effect.acts_on, "bearings that warm")
        else:
            yield VARIABLE_LAW_CAUSES[effect.of]

    def as_dict(self) -> dict[str, Any]:
        period = self.effect.period or None
        return {
            "acts_on": self.effect.acts_on,
            "of": self.effect.of,
            "period": period and {"value": period, "std": self.period_std, "unit": self.unit},
            "words": self.words,
            "likely": self.likely,
        }


def learned(
    law: Law, numbers: Array, covariance: Array, cart: CartModel, period_std: float, motions: Sequence[Motion]
) -> Iterator[LearnedLaw]:
    """The forces of a law of such numbers (q,) with their covariance (q, q), labelled beside a cart's."""
    whole, at = law.basis @ covariance @ law.basis.T, 0
    for force in law.sized(numbers):
        effect = labelled(force, cart)
        cart = cart.with_effect(effect)
        own = slice(at, at + len(effect.parameters))
        at = own.stop
        yield LearnedLaw(effect, whole[own, own], period_std, seen_values(effect, motions))
