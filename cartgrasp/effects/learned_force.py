"""A law read off data where no name fits: a force that is a smooth function of one variable, or of a place.

With amplitudes a (N; N·m of a yaw moment), which are the parameters, and shares w that depend on the variable s alone,

    F = sum of a_k w_k(s),    and the wrench in {b} is F times
    forward_force (1, 0, -lever),    lateral_force (0, 1, ahead),    yaw_moment (0, 0, 1),
    drag -sign(v) (1, 0, -lever),    world_force (c, s, ahead s), c and s those of direction - theta,
    viscous_drag -v (1, 0, -lever), of which the amplitudes are N·s/m.

A forward force and drags act `lever` to the left of {b}'s x, where the cart's forward speed is v = u - lever r: at a
wheel, say, whose way and speed a yaw moment may follow, too. Sideways and world forces act `ahead` of {b}. The sign is
smoothed as that of all Coulomb forces, and interpolated amplitudes that aren't negative make a drag that never drives
the cart. The variables:

    time                 s, of the log's clock
    travelled_distance   m: s' = v, forward less backward, from where the cart came to be looked at
    heading              rad; it repeats every turn
    speed                m/s: v; of drag, abs(v)
    yaw_rate             rad/s: r
    place                m: how far along `direction` of {s}, or, with `knots_y`, the place's x and y
    since_reversal       m: abs(q), of a way q that counts on in the direction of motion and back over h, which is
                         `REVERSAL_LENGTH`: q' = v (1 + b / h), b being how far q is on the other side of 0 than v goes,
                         rounded by h

At q = D a reversal is told after h log(1 + D / h) on the way back, 5 cm after 2 m, whatever the speed; a stop counts
for nothing. Before the first it has been long ago.

With a `period`, the shares are cos_k and sin_k of k 2 pi s / period, k being one of `harmonics`. Without, they
interpolate: share i is 1 at the i-th of `knots` and 0 at its neighbours, linear between, constant beyond the first and
the last; corners are averaged over `ROUNDING_FRACTION` of the shortest gap to either side, with the weight 3 (1 - t²) /
4. Beside `knots_y` shares are products of one along x and one along y. Without period or knots the force is constant.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, fields, replace
from functools import cached_property
from itertools import pairwise
from typing import Self, final

import numpy as np
from numpy.typing import ArrayLike

from ..errors import SettingError
from ..frames import Array
from ..wheels import WheelSet
from .compiled import CompiledForce
from .effect import Parameter, Setting

TARGET_NAMES = ("forward_force", "lateral_force", "yaw_moment", "drag", "world_force", "viscous_drag")
LEVER_TARGETS, AHEAD_TARGETS = ("forward_force", "drag", "viscous_drag"), ("lateral_force", "world_force")
VARIABLE_NAMES = ("time", "travelled_distance", "heading", "speed", "yaw_rate", "place", "since_reversal")
"""The variables, in the order in which the kernel counts them."""
MEMORY_VARIABLES = ("travelled_distance", "since_reversal")
"""What is remembered."""
ROUNDING_FRACTION = 0.25
REVERSAL_LENGTH = 0.01
"""m: a reversal is told within some of it."""
INITIAL_REVERSAL_DISTANCE = 2.0
"""m: way since a reversal that lies before the first observation."""
MAX_HARMONIC, MAX_AMPLITUDES = 100.0, 400
MIN_PERIOD_OR_GAP = 1e-6
"""Least period, and least gap between knots, in the variable's unit."""


@final
@dataclass(frozen=True)
class LearnedForce(CompiledForce):
    """Acts on `acts_on` as a function `of` a variable, with `amplitudes` (all 0 unless given).

    `direction` is in rad, of {s}; `lever` and `ahead` in m; `period`, `knots` and `knots_y` are in the variable's unit.
    Amplitudes stand in the order of the parameters: pairs cos, sin of each harmonic, of which the mean is the 0th, or
    one for each knot; with `knots_y`, of the first knot of x all of y's come first.
    """

    acts_on: str = "forward_force"
    of: str = "time"
    direction: float = 0.0
    lever: float = 0.0
    ahead: float = 0.0
    period: float = 0.0
    harmonics: tuple[float, ...] = (1.0,)
    knots: tuple[float, ...] = ()
    knots_y: tuple[float, ...] = ()
    amplitudes: tuple[float, ...] = ()

    name = "learned_force"
    settings = (
        Setting("acts_on", words=TARGET_NAMES),
        Setting("of", words=VARIABLE_NAMES),
        Setting("direction"),
        Setting("lever"),
        Setting("ahead"),
        Setting("period"),
        Setting("harmonics", is_list=True),
        Setting("knots", is_list=True),
        Setting("knots_y", is_list=True),
    )
    signature = "a force that one variable foretells, whatever makes it"
    searched = False
    memory_is_seen = True

    def __post_init__(self) -> None:
        if self.of == "pushed_force":
            why = "a law of what the arms give is not worked out yet: effects see the motion, not the wrench"
            raise SettingError(self.key, "of", why)
        for setting in self.settings:
            if setting.is_list:
                object.__setattr__(self, setting.name, tuple(map(float, getattr(self, setting.name))))
            setting.check(self.key, getattr(self, setting.name))
        for name, why in self._misfits():
            raise SettingError(self.key, name, why)
        size = len(self.parameters)
        amplitudes = tuple(map(float, self.amplitudes)) or (0.0,) * size
        if len(amplitudes) != size:
            raise SettingError(self.key, "amplitudes", f"{len(amplitudes)} numbers, but the law has {size}")
        object.__setattr__(self, "amplitudes", amplitudes)
        super().__post_init__()

    def _misfits(self) -> list[tuple[str, str]]:
        """Names of what does not go with the rest, and why."""
        of_wheel = self.acts_on == "yaw_moment" and self.of in (*MEMORY_VARIABLES, "speed")
        at_wheel, along = self.acts_on in LEVER_TARGETS or of_wheel, self.of == "place" and not self.knots_y
        counted = bool(self.harmonics) and all(k == int(k) and 0 <= k <= MAX_HARMONIC for k in self.harmonics)
        given = {item.name for item in fields(self) if getattr(self, item.name) != item.default}
        tests = (
            ("lever", not at_wheel, f"only one of {', '.join(LEVER_TARGETS)} has one"),
            ("ahead", self.acts_on not in AHEAD_TARGETS, f"only one of {', '.join(AHEAD_TARGETS)} acts ahead"),
            ("direction", self.acts_on != "world_force" and not along, "only a world_force or a way along it has one"),
            ("period", self.period < MIN_PERIOD_OR_GAP, f"{self.period:g} is below {MIN_PERIOD_OR_GAP:g}"),
            ("period", self.of == "heading", "a heading repeats every turn; leave it out"),
            ("knots", bool(self.cycle), "what repeats has harmonics; leave them out"),
            ("harmonics", not self.cycle, "only what repeats has some; give a period"),
            ("harmonics", not counted, f"some whole numbers from 0 to {MAX_HARMONIC:g}"),
            ("knots_y", self.of != "place" or len(self.knots) < 2, "only a place with knots along x has some"),
            ("knots_y", len(self.knots_y) < 2, "two are needed"),
            ("knots", _shortest(self.knots) < MIN_PERIOD_OR_GAP, f"two stand closer than {MIN_PERIOD_OR_GAP:g}"),
            ("knots_y", _shortest(self.knots_y) < MIN_PERIOD_OR_GAP, f"two stand closer than {MIN_PERIOD_OR_GAP:g}"),
            ("knots", len(self._names()) > MAX_AMPLITUDES, f"more than {MAX_AMPLITUDES} amplitudes"),
        )
        return [(name, why) for name, is_wrong, why in tests if name in given and is_wrong]

    @property
    def cycle(self) -> float:
        """The period after which the law repeats, in the variable's unit; 0 where it does not."""
        return 2 * math.pi if self.of == "heading" else self.period

    @cached_property
    def parameters(self) -> tuple[Parameter, ...]:
        unit, typical = {"yaw_moment": ("N·m", 3.0), "viscous_drag": ("N·s/m", 5.0)}.get(self.acts_on, ("N", 10.0))
        return tuple(Parameter(name, unit, typical) for name in self._names())

    def _names(self) -> list[str]:
        if self.cycle:
            return [f"{part}_{k:g}" for k in self.harmonics for part in ("cos", "sin")]
        rows, columns = range(1, max(len(self.knots), 1) + 1), range(1, len(self.knots_y) + 1)
        return [f"value_{i}_{j}" for i in rows for j in columns] or [f"value_{i}" for i in rows]

    @cached_property
    def values(self) -> Array:
        """The amplitudes."""
        return np.array(self.amplitudes)

    def with_values(self, values: ArrayLike) -> Self:
        """The same law with other amplitudes (n,)."""
        return replace(self, amplitudes=tuple(np.asarray(values, dtype=float).tolist()))

    def shares(self, at: ArrayLike) -> Array:
        """What each amplitude counts for (n, a) at values of the variable (n,); with `knots_y`, at places (n, 2)."""
        at = np.asarray(at, dtype=float).reshape(-1, 2 if self.knots_y else 1)
        if self.cycle:
            phase = 2 * math.pi / self.cycle * at * self.harmonics
            return np.stack([np.cos(phase), np.sin(phase)], axis=2).reshape(len(at), -1)
        along, across = _hats(at[:, 0], self.knots), _hats(at[:, -1], self.knots_y)
        return np.asarray((along[:, :, None] * across[:, None, :]).reshape(len(at), -1))

    @property
    def constants(self) -> tuple[float, ...]:
        x, y = self.knots or (0.0,), self.knots_y or (0.0,)
        lists = self.harmonics if self.cycle else (*x, *y)
        count = len(self.harmonics if self.cycle else x)
        kind = float(TARGET_NAMES.index(self.acts_on)), float(VARIABLE_NAMES.index(self.of))
        form = float(self.direction), float(self.lever), float(self.ahead), float(self.cycle)
        rounded = ROUNDING_FRACTION * _shortest(x), ROUNDING_FRACTION * _shortest(y)
        return (*kind, *form, *rounded, REVERSAL_LENGTH, float(count), *lists)

    @property
    def memory_numbers(self) -> tuple[float, ...]:
        return float(VARIABLE_NAMES.index(self.of)), self.lever

    def memory_names(self, wheels: WheelSet) -> tuple[str, ...]:
        return (f"{self.key}.way",) if self.of in MEMORY_VARIABLES else ()

    def first_memory(self, wheels: WheelSet, velocity_b: Array) -> Array:
        speed = float(velocity_b[0] - self.lever * velocity_b[2])
        began = math.copysign(INITIAL_REVERSAL_DISTANCE, speed) if self.of == "since_reversal" else 0.0
        return np.full(len(self.memory_names(wheels)), began)

    def memory_spread(self, wheels: WheelSet) -> Array:
        return np.full(len(self.memory_names(wheels)), 0.001)


def _shortest(knots: tuple[float, ...]) -> float:
    """Gap between two; 1 where there are none."""
    return min((b - a for a, b in pairwise(knots)), default=1.0)


def _hats(at: Array, knots: tuple[float, ...]) -> Array:
    """Rounded hats (n, k) of knots; one that is 1 everywhere where there is none."""
    climbs = [np.ones(len(at))]
    for low, high in pairwise(knots):
        climbs.append((_ramp(at - low, knots) - _ramp(at - high, knots)) / (high - low))
    return np.stack([*(a - b for a, b in pairwise(climbs)), climbs[-1]], axis=1)


def _ramp(distance: Array, knots: tuple[float, ...]) -> Array:
    width = ROUNDING_FRACTION * _shortest(knots)
    t = np.clip(distance / width, -1.0, 1.0)
    return np.asarray(width * (0.1875 + t * (0.5 + t * (0.375 - 0.0625 * t * t))) + np.maximum(distance - width, 0.0))
