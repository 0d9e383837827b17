"""What a residual depends on, in the world's terms: time, distance, heading, speed, place.

Families of smooth functions, none of them an effect, are fitted to the residual's polygon. What a family takes away is
judged by Schwarz's criterion, which needs no size of the noise.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from cartgrasp.frames import Array

from ..batch.smooth_motion import SmoothMotion
from .polygon import Polygon

HEADING, PLACE = "heading", "place"
AS_DRAG = ", as a drag"
"""Of what acts against the motion."""
FREQUENCIES = 0.1, 4.0
"""Hz."""
WAVENUMBERS = 1 / 3.0, 5.0
"""1/m."""
MOST_TURNS = 800
HARMONICS, MORE_HARMONICS = 3, 6
"""Of a wheel's turn: a flat spot bumps for a fraction of it. So many are tried everywhere, and where a period is known.
"""
LONGER, BESIDE = (1, 2, 3), 3
"""Turns that may look like one with fewer harmonics; settings on each side of a period that is known."""
LEVELS = 5
"""Of speed."""
DRIFT = 4
"""Slow waves over a log."""
RIDGE, LEAST = 1e-10, 1e-300
PARTS = 6
"""Of a log, each of which is foretold by a fit to the others."""
LEAST_TURN, FINE_TURN = 2.0, 0.3
"""Turns that something periodic takes, at least, in a log; and by how many two that are tried differ."""


@dataclass(frozen=True)
class Dependence:
    """A family's fit along one free direction: what it is called, its period and that period's unit where it has one,
    the log of its Bayes factor by Schwarz's criterion, the share of the squares that it takes away, and the share that
    it foretells in parts of the log from the others."""

    name: str
    direction: int
    period: float | None
    unit: str
    log_factor: float
    share: float
    foretold: float

    @property
    def is_periodic(self) -> bool:
        return self.period is not None

    @property
    def is_drag(self) -> bool:
        return self.name.endswith(AS_DRAG)

    @property
    def is_of_the_floor(self) -> bool:
        """Whether it is what a floor does, which is one thing along one heading, or at one place."""
        return not self.is_periodic and self.name in (HEADING, PLACE)


@dataclass(frozen=True)
class Course:
    """At some times (b,): time, heading, forward speed, yaw rate, place, distance since the last
    reversal; how far each fixed wheel, or the axle's middle, has rolled, and as the last the way of the middle,
    backward or forward, (b, w)."""

    time: Array
    rolled: Array
    heading: Array
    speed: Array
    turning: Array
    place: Array
    since_reversal: Array

    @classmethod
    def of(
        cls, time: Array, log: np.ndarray, motions: Sequence[SmoothMotion], tracks: Sequence[float] = (0.0,)
    ) -> Course:
        """At times (b,) of logs (b,); `tracks` says how far to the left of the middle a wheel stands, m."""
        parts = [_along(motion, time[log == k], tracks) for k, motion in enumerate(motions)]
        return cls(*(np.concatenate(columns) for columns in zip(*parts, strict=True)))


def dependences(polygon: Polygon, course: Course) -> list[Dependence]:
    """The best of each family along each free direction, the most probable first. More harmonics tell a period alone:
    so flexible a family takes some of anything away."""
    directions = [_Seen.of(polygon, i) for i in range(polygon.value.shape[1])]
    best = [dict[str, tuple[Dependence, Array]]() for _ in directions]
    for family in _families(course):
        looks = [_Look.of(family, seen) for seen in directions]
        together = _together(family, looks)
        for seen, look, known in zip(directions, looks, best, strict=True):
            one, columns = _told(look, together, seen)
            if family.name not in known or one.log_factor > known[family.name][0].log_factor:
                known[family.name] = one, columns
    found = [
        replace(one, foretold=_foretold(seen, columns))
        for seen, known in zip(directions, best, strict=True)
        for one, columns in known.values()
    ]
    return sorted(found, key=lambda one: -one.log_factor)


Together = tuple[int, int, float]
"""Where a family fits all directions best: in which of them it takes the most, at which setting, and the log of the
Bayes factor of all."""


def _together(family: _Family, looks: Sequence[_Look]) -> Together | None:
    """Of what has a period."""
    if family.periods is None:
        return None
    factor = np.sum([look.factor for look in looks], axis=0) + (len(looks) - 1) * np.log(family.tried)
    k = int(np.argmax(factor))
    return int(np.argmax([look.share[k] for look in looks])), k, float(factor[k])


def _told(look: _Look, together: Together | None, seen: _Seen) -> tuple[Dependence, Array]:
    """Where a family fits best, with its columns (b, k) there; what these foretell is not worked out."""
    k, family = int(np.argmax(look.factor)), look.family
    one, own = look.told(k), float(look.factor[k])
    if together is not None and together[0] == seen.direction and together[2] > own:
        k = together[1]
        one = replace(look.told(k), log_factor=together[2])
    if one.period is not None and one.log_factor > 0 and family.finer is not None:
        finer = _Look.of(family.finer(one.period), seen)
        known = finer.told(int(np.argmax(finer.factor)))
        one = replace(one, period=known.period) if known.log_factor > own else one
    return one, look.columns[k].copy()


@dataclass(frozen=True)
class _Seen:
    """Of a polygon along one direction: its whitened values (b,) about a constant, and that constant as a unit (b,)."""

    polygon: Polygon
    direction: int
    value: Array
    constant: Array

    @classmethod
    def of(cls, polygon: Polygon, direction: int) -> _Seen:
        constant = polygon.whitened(direction, np.ones((len(polygon.time), 1)))[:, 0]
        constant /= np.linalg.norm(constant)
        value = polygon.standard(direction)
        return cls(polygon, direction, value - constant * (constant @ value), constant)

    def about(self, columns: Array) -> Array:
        """Of columns (..., b, k) at nodes, what they say about the values."""
        found = self.polygon.whitened(self.direction, columns)
        found -= self.constant[:, None] * (self.constant @ found)[..., None, :]
        return found


@dataclass(frozen=True)
class _Family:
    """Columns (s, b, k) at settings (s,), which may be periods; how many settings share one prior; what to look at
    where a period is found."""

    name: str
    columns: Array
    tried: int = 1
    periods: Array | None = None
    unit: str = ""
    finer: Callable[[float], _Family] | None = None


@dataclass(frozen=True)
class _Look:
    """At a family along a direction: its whitened columns (s, b, k); logs of Bayes factors and shares, both (s,)."""

    family: _Family
    direction: int
    columns: Array
    factor: Array
    share: Array

    @classmethod
    def of(cls, family: _Family, seen: _Seen) -> _Look:
        columns = seen.about(family.columns)
        factor, share = _judged(seen.value, columns)
        return cls(family, seen.direction, columns, factor - np.log(family.tried), share)

    def told(self, k: int) -> Dependence:
        """At a setting; what it foretells is not worked out."""
        family, factor, share = self.family, float(self.factor[k]), float(self.share[k])
        period = None if family.periods is None else float(family.periods[k])
        return Dependence(family.name, self.direction, period, family.unit, factor, share, 0.0)


def _families(course: Course) -> Iterator[_Family]:
    frequencies = _turns(course.time, FREQUENCIES)
    yield _Family("time, periodic", _wave(np.outer(frequencies, course.time)), len(frequencies), 1 / frequencies, "s")
    for rolled in course.rolled.T:
        turns = _turns(rolled, WAVENUMBERS)
        tried = 4 * len(turns) * course.rolled.shape[1]
        waves = _harmonics(turns, rolled, HARMONICS)
        for sign in (np.ones_like(course.speed), np.sign(course.speed)):
            wheel = _Wheel(rolled, sign, tried)
            for columns in (waves[..., :2], waves):
                yield replace(wheel.family(turns, columns), finer=wheel.near)
    turned = course.heading / (2 * np.pi)
    once, twice = _wave(turned), np.hstack([_wave(turned), _wave(2 * turned)])
    yield _Family(HEADING, once[None])
    yield _Family(HEADING, twice[None])
    yield _Family("speed", _levels(course.speed)[None])
    yield _Family("yaw rate", _levels(course.turning)[None])
    along = (course.time - course.time.min()) / max(float(np.ptp(course.time)), 1e-9)
    slow = np.column_stack([np.cos(np.pi * (k + 1) * along) for k in range(DRIFT)])
    yield _Family("time, slowly", slow[None])
    place = course.place - course.place.mean(axis=0)
    x, y = (place / np.maximum(np.abs(place).max(axis=0), 1e-9)).T
    curved = np.column_stack([x, y, x * y, x**2, y**2])
    yield _Family(PLACE, curved[None])
    yield from _seams(course)
    yield from _drags(course, [(HEADING, once), (HEADING, twice), ("time", slow), (PLACE, curved)])


def _drags(course: Course, by: Sequence[tuple[str, Array]]) -> Iterator[_Family]:
    """Of what acts against the motion, flat in speed or in proportion to it, and is larger or smaller by something."""
    speed = course.speed
    ways = np.sign(speed), speed / max(float(np.abs(speed).max()), 1e-9)
    for name, columns in [*by, ("yaw rate", np.abs(course.turning)[:, None])]:
        yield _Family(f"{name}{AS_DRAG}", np.hstack([way[:, None] * columns for way in ways])[None])


def _seams(course: Course) -> Iterator[_Family]:
    """Of what lies on the floor at equal distances along its x or its y: a drag, or a force of the floor's own
    direction."""
    toward = np.column_stack([np.cos(course.heading), np.sin(course.heading)])
    wide = [i for i in range(2) if np.ptp(course.place[:, i]) > LEAST_TURN / WAVENUMBERS[1]]
    turns = {i: _turns(course.place[:, i], WAVENUMBERS) for i in wide}
    tried = 2 * sum(len(each) for each in turns.values())
    for i, each in turns.items():
        waves = _wave(np.outer(each, course.place[:, i]))
        for sign in (np.sign(course.speed), toward[:, i]):
            yield _Family("place, periodic", sign[None, :, None] * waves, tried, 1 / each, "m")


@dataclass(frozen=True)
class _Wheel:
    """How far one has rolled (b,), whether it pushes or drags (b,), and how many settings share one prior."""

    rolled: Array
    sign: Array
    tried: int

    def family(self, turns: Array, waves: Array) -> _Family:
        """Of waves (s, b, k) at turns a metre (s,)."""
        columns = self.sign[None, :, None] * waves
        return _Family("travelled distance, periodic", columns, self.tried, 1 / turns, "m")

    def near(self, period: float) -> _Family:
        """With more harmonics, of which a part may have looked like a shorter period."""
        step = FINE_TURN / max(float(np.ptp(self.rolled)), 1e-9) / MORE_HARMONICS
        turns = np.concatenate([1 / (period * k) + step * np.arange(-BESIDE, BESIDE + 1) for k in LONGER])
        turns = turns[turns > WAVENUMBERS[0]]
        return self.family(turns, _harmonics(turns, self.rolled, MORE_HARMONICS))


def _turns(along: Array, limits: tuple[float, float]) -> Array:
    """Turns a second or a metre between limits, so near to one another that none is missed on a log this long."""
    length = max(float(np.ptp(along)), 1e-9)
    low, high = max(limits[0], LEAST_TURN / length), limits[1]
    count = int(np.clip((high - low) * length / FINE_TURN, 2, MOST_TURNS))
    return np.linspace(low, max(high, 1.01 * low), count)


def _judged(value: Array, columns: Array) -> tuple[Array, Array]:
    """Schwarz's log of a Bayes factor against a constant, and the share of the squares taken away, both (s,)."""
    gram = np.swapaxes(columns, 1, 2) @ columns
    scale = np.trace(gram, axis1=1, axis2=2)[:, None, None]
    pull = np.swapaxes(columns, 1, 2) @ value
    solved = np.linalg.solve(gram + (RIDGE * scale + LEAST) * np.eye(gram.shape[1]), pull[..., None])[..., 0]
    taken = np.minimum((pull * solved).sum(axis=1) / max(float(value @ value), LEAST), 1 - 1e-12)
    n, k = len(value), columns.shape[2]
    return -0.5 * n * np.log1p(-taken) - 0.5 * k * np.log(n), taken


def _foretold(seen: _Seen, columns: Array) -> float:
    """Of the squares, the share that whitened columns (b, k) take away in each part of a log when they are fitted to
    the others; 0 where they foretell nothing."""
    value = seen.value
    number = np.arange(len(value)) * PARTS // len(value)
    sides = np.column_stack([seen.constant, columns])
    left = 0.0
    for part in range(PARTS):
        own = number == part
        known = np.linalg.lstsq(sides[~own], value[~own], rcond=None)[0]
        left += float(np.square(value[own] - sides[own] @ known).sum())
    return max(0.0, 1.0 - left / max(float(value @ value), LEAST))


def _wave(turns: Array) -> Array:
    return np.stack([np.sin(2 * np.pi * turns), np.cos(2 * np.pi * turns)], axis=-1)


def _harmonics(turns: Array, along: Array, number: int) -> Array:
    """Waves (s, b, 2 number) at turns (s,)."""
    return np.concatenate([_wave(k * np.outer(turns, along)) for k in range(1, number + 1)], axis=2)


def _levels(values: Array) -> Array:
    edges = np.quantile(values, np.linspace(0, 1, LEVELS + 1)[1:-1])
    return np.eye(LEVELS)[np.searchsorted(edges, values)][:, 1:]


def _along(motion: SmoothMotion, at_times: Array, tracks: Sequence[float]) -> tuple[Array, ...]:
    time, speed = motion.time, motion.velocity[:, 0]
    steps = np.append(0.0, np.where(motion.linked, np.diff(time), 0.0))
    distance = np.cumsum(motion.speed * steps)
    turning = motion.velocity[:, -1] if motion.velocity.shape[1] > 1 else np.zeros(len(time))
    rolled = np.cumsum((speed[:, None] - np.outer(turning, tracks)) * steps[:, None], axis=0)
    rolling = np.where(np.abs(speed) > 0.02, np.sign(speed), 0.0)
    last, reversed_at, at = 0.0, -np.inf, np.full(len(time), np.inf)
    for i in range(len(time)):
        if rolling[i] and rolling[i] != last:
            reversed_at = distance[i] if last else -np.inf
            last = rolling[i]
        at[i] = distance[i] - reversed_at
    rows = np.clip(np.searchsorted(time, at_times), 0, len(time) - 1)
    rolled = np.column_stack([rolled, distance])
    columns = (rolled, np.unwrap(motion.pose[:, 2]), speed, turning, motion.pose[:, :2], at)
    return at_times, *(column[rows] for column in columns)
