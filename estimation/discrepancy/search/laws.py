"""What a log may follow that no effect of the vocabulary makes: forces, drags and moments as functions of one variable,
or of a place, with few numbers. They are rivals of the effects in the same comparison."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import BSpline

from cartgrasp.effects import LearnedForce
from cartgrasp.effects.learned_force import LEVER_TARGETS
from cartgrasp.frames import Array
from cartgrasp.model import CartModel

from ...weak_form.balances import Balances
from ...weak_form.motion import Motion
from .candidates import free_label
from .covariates import Covariates, rows_at

VARIABLE_WORDS = {
    "travelled_distance": "travelled distance",
    "yaw_rate": "yaw rate",
    "since_reversal": "way since a reversal",
}
"""Variables in words, where these are others than the effect's."""
VARIABLE_UNITS = {"time": "s", "heading": "rad", "speed": "m/s", "yaw_rate": "rad/s"}
"""Units of variables; all others are in m."""
AT_HANDS = "at the hands"
DRAG_ONSET_FRACTIONS = (0.25, 0.5, 0.75)
"""Shares of the largest speed from which on a drag grows."""
REVERSAL_KNOTS = (0.02, 0.1, 0.3, 1.0)
"""Knots (m since a reversal) of drags that it changes."""
SCRUB_SATURATION_FRACTION = 0.15
"""Share of the largest yaw rate from which on a moment no longer grows."""
CURVE_KNOTS = np.linspace(-0.1, 1.1, 13)
"""Knots of smooth curves, as shares of what a variable goes through."""
SPLINE_COEFFICIENTS = 5
"""Number of coefficients of a curve, which is a cubic spline."""
FIELD_KNOTS = np.linspace(-1.25, 1.25, 6)
"""Knots of fields about the middle, as shares of half of what x and y go through."""
MIN_VARIABLE_SPAN = 0.1
"""Least range, in the variable's unit: nothing is a law of what goes less far."""


@dataclass(frozen=True, eq=False)
class Law:
    """Learned forces whose amplitudes, one force's after another's, are a `basis` (a, q) times a few numbers."""

    form: str
    effects: tuple[LearnedForce, ...]
    basis: Array

    @classmethod
    def free(cls, form: str, effect: LearnedForce) -> Law:
        """Every amplitude of one force is a number of its own."""
        return cls(form, (effect,), np.eye(len(effect.parameters)))

    @property
    def of(self) -> str:
        return self.effects[0].of

    @property
    def name(self) -> str:
        """Variable of which the law is a function, in words."""
        return variable_of(self.effects[0])

    @property
    def kind(self) -> tuple[Any, ...]:
        """What and where it acts on, and of what it is a function."""
        first = self.effects[0]
        return first.acts_on, first.of, first.lever, first.direction, len(self.effects)

    @property
    def period(self) -> float | None:
        return self.effects[0].period or None

    @property
    def unit(self) -> str:
        return unit_of(self.effects[0])

    @property
    def size(self) -> int:
        return int(self.basis.shape[1])

    @property
    def key(self) -> str:
        return f"law: {self.name}, {self.form}" + (f", {self.period:.3g} {self.unit}" if self.period else "")

    @property
    def words(self) -> str:
        """The law in words for people."""
        period = f" with a period of {self.period:.3g} {self.unit}" if self.period else ""
        return f"the {self.name}{period} ({self.effects[0].acts_on.replace('_', ' ')}: {self.form})"

    @property
    def std(self) -> Array:
        """Prior standard deviations of the numbers (q,)."""
        return np.full(self.size, self.effects[0].parameters[0].typical)

    def repeating(self, period: float) -> Law:
        """The law with another period (in the variable's unit)."""
        return replace(self, effects=tuple(replace(effect, period=period) for effect in self.effects))

    def columns(self, balances: Balances, cart: CartModel) -> Array:
        """What a unit of each number takes away of the residual (k, c, q)."""
        return self.of_amplitudes(lambda effect: balances.columns(cart, effect))

    def of_amplitudes(self, columns: Callable[[LearnedForce], Array]) -> Array:
        """Columns (k, c, q) of the numbers, from those (k, c, a) of each force's amplitudes."""
        return np.concatenate([columns(effect) for effect in self.effects], axis=2) @ self.basis

    def sized(self, numbers: ArrayLike) -> tuple[LearnedForce, ...]:
        """The forces of such numbers (q,)."""
        amplitudes, found = self.basis @ np.asarray(numbers, dtype=float), list[LearnedForce]()
        for effect in self.effects:
            own, amplitudes = np.split(amplitudes, [len(effect.parameters)])
            found.append(effect.with_values(own))
        return tuple(found)


def variable_of(effect: LearnedForce) -> str:
    """An effect's variable in words."""
    return VARIABLE_WORDS.get(effect.of, effect.of)


def constant(effect: LearnedForce) -> LearnedForce:
    """One unit of the same force throughout."""
    plain = LearnedForce(effect.acts_on, "speed", lever=effect.lever, ahead=effect.ahead, amplitudes=(1.0,))
    return replace(plain, direction=effect.direction) if effect.acts_on == "world_force" else plain


def unit_of(effect: LearnedForce) -> str:
    """Unit of an effect's variable."""
    return VARIABLE_UNITS.get(effect.of, "m")


def seen_values(effect: LearnedForce, motions: Sequence[Motion]) -> Array:
    """Values of an effect's variable along motions (n,); of places with knots of y (n, 2)."""
    return np.concatenate([_values(effect, motion) for motion in motions])


def row_values(effect: LearnedForce, logs: Sequence[Balances]) -> Array:
    """Values of an effect's variable at the rows of logs (k,); of places with knots of y (k, 2)."""
    return np.concatenate([_values(effect, b.motion)[rows_at(b.motion, b.time)] for b in logs])


def _values(effect: LearnedForce, motion: Motion) -> Array:
    course = Covariates.along(motion)
    if effect.of == "place":
        along = np.array([np.cos(effect.direction), np.sin(effect.direction)])
        return course.place if effect.knots_y else course.place @ along
    turned = effect.lever * course.yaw_rate
    found = {
        "time": motion.time,
        "travelled_distance": course.way - effect.lever * (course.heading - course.heading[0]),
        "heading": course.heading,
        "speed": np.abs(course.speed - turned) if effect.acts_on == "drag" else course.speed - turned,
        "yaw_rate": course.yaw_rate,
        "since_reversal": course.since_reversal,
    }[effect.of]
    return np.asarray(np.nan_to_num(found, posinf=found[np.isfinite(found)].max(initial=2.0)))


def labelled(effect: LearnedForce, cart: CartModel) -> LearnedForce:
    """The effect with a label that no law of the cart has."""
    return replace(effect, label=free_label(LearnedForce, cart))


def smooth_laws(motions: Sequence[Motion], cart: CartModel, lever: float = 0.0) -> list[Law]:
    """Laws of what varies slowly with one variable along motions. Drags and forward forces come, too, at a lever of the
    hands' (m; none: 0), whose sensors may be what follows it. Forces of the world act at {b} and at the CoM."""
    found = list(_on_all(motions))
    if cart.constraints.n_free > 1:
        found += [*_on_turns(motions), *_of_world(motions, 0.0), *_of_world(motions, float(cart.inertia.com[0]))]
    at_hands = [law for law in found if lever and law.effects[0].acts_on in LEVER_TARGETS]
    return found + [
        replace(law, form=f"{law.form} {AT_HANDS}", effects=tuple(replace(e, lever=lever) for e in law.effects))
        for law in at_hands
    ]


def _on_all(motions: Sequence[Motion]) -> Iterator[Law]:
    low, high = _span([m.time for m in motions])
    most = _span([np.abs(m.velocity[:, 0]) for m in motions])[1]
    steps = np.append(0.0, (*DRAG_ONSET_FRACTIONS, 1.0))
    setting_in = (np.maximum(steps - share, 0.0) / (1.0 - share) for share in DRAG_ONSET_FRACTIONS)
    time, curves = low + (high - low) * CURVE_KNOTS, splines(CURVE_KNOTS)
    yield Law.free("the same at all", LearnedForce("drag", "speed"))
    yield _knotted("cubic drag", "drag", "speed", most * CURVE_KNOTS, CURVE_KNOTS**3)
    yield _knotted("drag that sets in", "drag", "speed", most * steps, *setting_in)
    yield _knotted("drift", "forward_force", "time", time, CURVE_KNOTS)
    yield _knotted("drag that warms", "drag", "time", time, *curves)
    yield _knotted("viscous drag that warms", "viscous_drag", "time", time, *curves)
    yield _knotted("drag", "drag", "since_reversal", np.array(REVERSAL_KNOTS), *np.eye(len(REVERSAL_KNOTS))[:-1])


def _on_turns(motions: Sequence[Motion]) -> Iterator[Law]:
    both = np.append(-CURVE_KNOTS[:1:-1], CURVE_KNOTS[1:])
    most = _span([np.abs(m.velocity[:, -1]) for m in motions])[1]
    yield Law.free("force", LearnedForce("forward_force", "heading", harmonics=(1, 2)))
    yield Law.free("drag", LearnedForce("drag", "heading", harmonics=(2,)))
    yield Law.free("drag, another one way", LearnedForce("drag", "heading", harmonics=(1, 2)))
    yield Law.free("viscous drag", LearnedForce("viscous_drag", "heading", harmonics=(1, 2)))
    yield Law.free("moment", LearnedForce("yaw_moment", "heading"))
    yield _knotted("drag", "drag", "yaw_rate", most * both, np.abs(both))
    yield _knotted("viscous drag", "viscous_drag", "yaw_rate", most * both, np.abs(both))
    yield _knotted(
        "moment",
        "yaw_moment",
        "yaw_rate",
        most * both,
        both * np.abs(both),
        np.clip(both / SCRUB_SATURATION_FRACTION, -1, 1),
    )
    knots, plane, bowl = _fields(motions)
    yield Law("drag", (replace(knots, acts_on="drag"),), plane)
    yield Law("curved drag", (replace(knots, acts_on="drag"),), bowl)


def _of_world(motions: Sequence[Motion], ahead: float) -> Iterator[Law]:
    low, high = _span([m.time for m in motions])
    times = tuple((low + (high - low) * CURVE_KNOTS).tolist())
    wind = LearnedForce("world_force", "time", ahead=ahead, knots=times)
    field, plane, bowl = _fields(motions)
    field = replace(field, acts_on="world_force", ahead=ahead)
    yield both_ways("wind", wind, CURVE_KNOTS[:, None])
    yield both_ways("wind that turns", wind, splines(CURVE_KNOTS).T)
    yield both_ways("field", field, plane)
    yield both_ways("curved field", field, bowl)


def _fields(motions: Sequence[Motion]) -> tuple[LearnedForce, Array, Array]:
    """A force over the places of motions, and bases (a, q) of planes and of parabolas."""
    ends = [_span([m.pose[:, i] for m in motions]) for i in range(2)]
    x, y = (np.mean(each) + np.diff(each) / 2 * FIELD_KNOTS for each in ends)
    across, along = (part.ravel() for part in np.meshgrid(FIELD_KNOTS, FIELD_KNOTS, indexing="ij"))
    plane = np.stack([np.ones_like(along), across, along], axis=1)
    bowl = np.column_stack([plane, across**2, across * along, along**2])
    return LearnedForce("lateral_force", "place", knots=tuple(x.tolist()), knots_y=tuple(y.tolist())), plane, bowl


def splines(at: Array) -> Array:
    """Cubic splines (q, n) between 0 and 1."""
    inside = np.linspace(0.0, 1.0, SPLINE_COEFFICIENTS - 2)
    knots = np.concatenate([[0.0] * 3, inside, [1.0] * 3])
    return np.asarray(BSpline.design_matrix(np.clip(at, 0.0, 1.0), knots, 3).toarray().T)


def _knotted(form: str, acts_on: str, of: str, knots: Array, *shapes: Array) -> Law:
    """A force that interpolates shapes (a,) at knots."""
    return Law(form, (LearnedForce(acts_on, of, knots=tuple(knots.tolist())),), np.array(shapes, dtype=float).T)


def both_ways(form: str, effect: LearnedForce, basis: Array) -> Law:
    """A force of the world along x, and one along y, each with a basis."""
    both = tuple(replace(effect, direction=way) for way in (0.0, np.pi / 2))
    return Law(form, both, np.kron(np.eye(2), basis).astype(float))


def _span(signals: Sequence[Array]) -> Array:
    """The least and the largest of them, (2,), apart."""
    low, high = min(float(s.min()) for s in signals), max(float(s.max()) for s in signals)
    return np.array([low, max(high, low + MIN_VARIABLE_SPAN)])
