"""Times, positions, headings and velocities: their units and signs, by labels where there are, and by physics."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from ....frames import Array, unwrapped
from ..units import UNITS
from .columns import Column, FileColumns, first_of
from .evidence import Motion, heading_of, motion_of, scale, velocities
from .proposed_value import ProposedValue

LOG_RATE_RANGE = (2.0, 5000.0)
"""Hz, of logs."""
LOG_DURATION_RANGE = (1.0, 24 * 3600.0)
"""s."""
CART_SPEED_RANGE = (0.005, 15.0)
"""m/s: the 95th percentile of a pushed cart's speed; likely up to `MAX_LIKELY_SPEED`."""
MAX_LIKELY_SPEED = 4.0
UNIT_FACTOR_TOLERANCE = 0.1
"""Largest relative difference between a factor and a unit that is taken for it."""
MAX_TRACKER_YAW = 0.26
"""rad: an offset that small is a tracker that is a little turned, told later."""


@dataclass(frozen=True)
class Entry:
    """A column in a map."""

    column: ProposedValue
    unit: ProposedValue = field(default_factory=lambda: ProposedValue(None))
    sign: ProposedValue = field(default_factory=lambda: ProposedValue(1))


def one_of_several(column: Column, is_only: bool) -> ProposedValue:
    return ProposedValue(column.ref, is_only, "" if is_only else "several columns may be it")


def near(factor: float, dimension: str) -> str | None:
    """The unit that is about so large."""
    for unit, size in UNITS[dimension].items():
        if factor > 0 and abs(factor / size - 1) < UNIT_FACTOR_TOLERANCE:
            return unit
    return None


def time_unit(column: Column) -> ProposedValue:
    """The clock's unit: the one of its label, else the only one with which rows come at a rate and for a time that logs
    have."""
    times = column.said[np.isfinite(column.said)]
    steps = np.diff(times)
    if len(times) < 2 or not (steps > 0).any():
        return ProposedValue(column.unit or "s", False, "the clock doesn't run: look at the column")
    step = float(np.median(steps[steps > 0]))
    span = float(times.max() - times.min())

    def fits(unit: str) -> bool:
        size = UNITS["time"][unit]
        return (
            LOG_RATE_RANGE[0] <= 1 / (step * size) <= LOG_RATE_RANGE[1]
            and LOG_DURATION_RANGE[0] <= span * size <= LOG_DURATION_RANGE[1]
        )

    if column.unit is not None:
        why = "" if fits(column.unit) else f"rows would come every {step * UNITS['time'][column.unit]:.3g} s"
        return ProposedValue(column.unit, not why, why)
    likely = [unit for unit in ("s", "ms", "us", "ns") if fits(unit)]
    if len(likely) == 1 and not np.allclose(steps, 1.0):
        return ProposedValue(likely[0], True, f"as rows every {step * UNITS['time'][likely[0]]:.3g} s")
    why = "no unit is in its name" + ("; are these seconds, or numbers of rows?" if np.allclose(steps, 1.0) else "")
    return ProposedValue(likely[0] if likely else "s", False, why)


@dataclass(frozen=True, eq=False)
class Clock:
    """A file's column of times with its unit, and the times (n,), s: a hundred rows a second where there is none."""

    column: Column | None
    unit: ProposedValue
    time: Array

    @classmethod
    def of(cls, file: FileColumns) -> Clock:
        """By the first column of times that always rises, else the first."""
        columns = file.of_role("t")
        if not columns:
            return cls(None, ProposedValue(None, False), np.arange(len(file.table.lines)) / 100.0)
        column = next((c for c in columns if _rises(c.said)), columns[0])
        unit = time_unit(column)
        return cls(column, unit, column.said * UNITS["time"][str(unit.value)])

    @property
    def rate(self) -> float:
        """Hz; 0 where it doesn't run."""
        steps = np.diff(self.time[np.isfinite(self.time)])
        return 1 / float(np.median(steps)) if len(steps) and np.median(steps) > 0 else 0.0


class MotionUnits:
    """Decides step by step; `notes` are what was seen on the way, `offset` (rad) is {b}'s in the tracked frame."""

    def __init__(self, file: FileColumns) -> None:
        self.file, self.notes = file, list[str]()
        self.offset = ProposedValue(0.0)
        self.clock = Clock.of(file)
        self.time = self.clock.time
        roles = {role: first_of(file.of_role(role)) for role in ("x", "y", "theta", "vx", "vy", "omega")}
        if roles["x"][0] is None and not file.arms:
            roles |= {axis: first_of(file.of_role(f"p{axis}")) for axis in ("x", "y")}
        if roles["theta"][0] is None:
            roles["theta"] = (file.yaw, True)
        self.columns = {role: column for role, (column, _) in roles.items()}
        self.is_only = {role: only for role, (_, only) in roles.items()}
        self.lengths = {role: self._length(role) for role in ("x", "y")}
        self.motion = self._motion_in([UNITS["length"][str(self.lengths[role].value or "m")] for role in ("x", "y")])
        if self.motion is None and self.columns["x"] is not None:
            self.notes.append("positions are too few, or the clock goes back: units and signs could not be looked at")
        self.heading = self._heading()
        self.frame, self.velocity = self._velocity()

    def _motion_in(self, factors: Sequence[float] = (1.0, 1.0)) -> Motion | None:
        """The motion whose coordinates are so many times what the columns hold; None where they tell none."""
        x, y = self.columns["x"], self.columns["y"]
        if x is None:
            return None
        return motion_of(self.time, factors[0] * x.said, np.zeros_like(x.said) if y is None else factors[1] * y.said)

    def _length(self, role: str) -> ProposedValue:
        column = self.columns[role]
        if column is None:
            return ProposedValue(None)
        if column.odd:
            return ProposedValue(None, False, f"its label says {column.odd}")
        if column.unit is None and _wraps(column.said, 360.0):
            return ProposedValue(None, False, "it wraps at 360: a wheel's angle? then {column, unit: deg, radius: m}")
        motion = self._motion_in()
        top = 0.0 if motion is None else motion.top_speed
        if column.unit is not None:
            speed = top * UNITS["length"][column.unit]
            is_odd = top > 0 and not speed < CART_SPEED_RANGE[1]
            return ProposedValue(column.unit, not is_odd, f"the cart would go {speed:.3g} m/s" if is_odd else "")
        other = self.columns["y" if role == "x" else "x"]
        if other is not None and other.unit is not None:
            return ProposedValue(other.unit, False, f"as {other.title}")
        if motion is not None and (found := self._length_by_speed(motion)) is not None:
            return found
        return _length_by_size(top)

    def _length_by_speed(self, motion: Motion) -> ProposedValue | None:
        """The unit of length with which differences of positions are as large as labelled velocities, along either
        frame; None where they don't tell."""
        vx, vy = self.columns["vx"], self.columns["vy"]
        if vx is None or vx.unit is None or not self.clock.unit.is_sure:
            return None
        recorded = vx.said**2 if vy is None else vx.said**2 + vy.said**2
        speed = motion.on(self.time, np.sqrt(recorded) * UNITS["speed"][vx.unit])
        factor, agreement = scale(speed, motion.speed)
        unit = near(factor, "length")
        if unit is None or agreement < 0.97:
            return None
        return ProposedValue(unit, True, f"as {vx.title} says how fast it goes")

    def _heading(self) -> Entry | None:
        column = self.columns["theta"]
        if column is None:
            return None
        said = one_of_several(column, self.is_only["theta"])
        best = heading_of(self.motion, self.time, column.said) if self.motion is not None else None
        unit = self._angle_unit(column, None if best is None else best.unit)
        if best is None and isinstance(column.ref, list):
            return Entry(said, unit)
        if best is None:
            return Entry(said, unit, ProposedValue(1, False, "the way doesn't tell whether headings grow to the left"))
        if abs(best.offset) > MAX_TRACKER_YAW:
            why = "the cart goes so far left of its heading: from which axis is it counted? or are x and y swapped?"
            self.offset = ProposedValue(best.offset, False, why)
        if best.sign < 0:
            why = "headings fall where the way turns left: are they clockwise? or is y to the right?"
            if isinstance(column.ref, list):
                return Entry(ProposedValue(column.ref, False, why))
            return Entry(said, unit, ProposedValue(-1, False, why))
        return Entry(said, unit)

    def _angle_unit(self, column: Column, told: str | None) -> ProposedValue:
        """`told` is the unit with which headings go where the cart goes."""
        if column.odd:
            return ProposedValue(None, False, f"its label says {column.odd}")
        if column.unit is not None:
            is_odd = told is not None and column.unit in ("deg", "rad") and told != column.unit
            why = f"but in {told} it goes where the cart goes" if is_odd else ""
            return ProposedValue(column.unit, not is_odd, why)
        if told is not None:
            return ProposedValue(told, True, "as the way turns")
        if _wraps(column.said, 360.0):
            return ProposedValue("deg", True, "it wraps at 360")
        if _wraps(column.said, 2 * np.pi):
            return ProposedValue("rad", True, "it wraps at 2 pi")
        if (by_rate := self._angle_by_rate(column)) is not None:
            return by_rate
        largest = float(np.nanmax(np.abs(column.said)))
        why = f"no unit is in its name; it goes up to {largest:.3g}"
        return ProposedValue("deg" if largest > 7 else "rad", False, why)

    def _angle_by_rate(self, column: Column) -> ProposedValue | None:
        omega = self.columns["omega"]
        if omega is None or omega.unit is None or self.motion is None or not self.clock.unit.is_sure:
            return None
        recorded = self.motion.on(self.time, omega.said * UNITS["rate"][omega.unit])
        for unit, period in (("deg", 360.0), ("rad", 2 * np.pi)):
            rate = np.gradient(self.motion.smoothed(self.time, unwrapped(column.said, period)), self.motion.time)
            factor, agreement = scale(recorded, rate)
            if abs(agreement) > 0.9 and near(abs(factor), "angle") == unit:
                return ProposedValue(unit, True, f"as {omega.title} says how fast it turns")
        return None

    def heading_rad(self) -> Array | None:
        """Headings (rad) at the file's rows; None where their unit is not known."""
        column = self.columns["theta"]
        if column is None or self.heading is None or self.heading.unit.value is None:
            return None
        size = UNITS["angle"][str(self.heading.unit.value)]
        sign = self.heading.sign.value if isinstance(self.heading.sign.value, int) else 1
        offset = self.offset.value if isinstance(self.offset.value, float) else 0.0
        return np.asarray(sign * size * unwrapped(column.said, 2 * np.pi / size) + offset)

    def _velocity(self) -> tuple[ProposedValue, dict[str, Entry | ProposedValue]]:
        """Along which axes, and its columns: none where one of the three is missing."""
        vx, vy, omega = (self.columns[role] for role in ("vx", "vy", "omega"))
        if vx is None or omega is None or self.motion is None:
            if vx is not None or vy is not None:
                self.notes.append("velocities are left out: vx, vy and the yaw rate come together or not at all")
            return ProposedValue(None), {}
        heading = self.heading_rad()
        lateral = np.zeros_like(vx.said) if vy is None else vy.said
        sizes = [UNITS["speed"][c.unit or vx.unit or "m/s"] if c is not None else 1.0 for c in (vx, vy)]
        seen = velocities(self.motion, self.time, sizes[0] * vx.said, sizes[1] * lateral, heading)
        if seen is None or seen.agreement < 0.8:
            self.notes.append("velocities are left out: they are no differences of the positions")
            return ProposedValue(None), {}
        why = "" if seen.is_clear else "a way this straight doesn't tell them apart"
        sideways = ProposedValue(0.0, False, "no column has it; wheels on an axle forbid it")
        return ProposedValue(seen.frame, seen.is_clear, why), {
            "vx": self._speed(vx, seen.factors[0], vx),
            "vy": sideways if vy is None else self._speed(vy, seen.factors[1], vx),
            "omega": self._rate(omega),
        }

    def _speed(self, column: Column, factor: float, first: Column) -> Entry:
        """The entry of a velocity column, which is so many times what differences of positions are."""
        label = column.unit or first.unit
        unit, sign = _unit_by(factor, label, "speed", "differences of positions"), ProposedValue(1)
        is_sure = self.clock.unit.is_sure and self.lengths["x"].is_sure and self.lengths["y"].is_sure
        if label is None and unit.is_sure and not is_sure:
            unit = ProposedValue(unit.value, False, "as positions, of which a unit or the clock is not sure")
        if not factor > 0:
            sign = ProposedValue(-1, False, "it falls where the cart goes the other way")
        return Entry(one_of_several(column, self.is_only[column.role]), unit, sign)

    def _rate(self, column: Column) -> Entry:
        """The entry of a yaw rate column, with its sign and unit against differences of headings."""
        heading = self.heading_rad()
        label, ref = column.unit, one_of_several(column, self.is_only["omega"])
        if heading is None or self.heading is None or self.motion is None:
            return Entry(ref, ProposedValue(label or "rad/s", label is not None, "no unit is in its name"))
        truth = np.gradient(self.motion.smoothed(self.time, heading), self.motion.time)
        size = UNITS["rate"][label or "rad/s"]
        factor, agreement = scale(size * self.motion.on(self.time, column.said), truth)
        is_seen = abs(agreement) > 0.8
        unit, sign = _unit_by(factor if is_seen else None, label, "rate", "differences of headings"), ProposedValue(1)
        if label is None and not (self.clock.unit.is_sure and self.heading.unit.is_sure):
            unit = replace(unit, is_sure=False)
        if is_seen and factor < 0:
            sign = ProposedValue(-1, False, "it falls where the heading grows")
        return Entry(ref, unit, sign)


def _unit_by(factor: float | None, label: str | None, dimension: str, differences: str) -> ProposedValue:
    """The unit of a column that is, in the unit of its label, so many times what differences of poses are; `factor` is
    None where they don't tell."""
    if label is not None:
        size = 1.0 if factor is None else abs(factor)
        fits = abs(size - 1) < 0.25
        return ProposedValue(label, fits, "" if fits else f"it is {size:.3g} times what {differences} are")
    unit = None if factor is None else near(1 / abs(factor), dimension)
    if unit is None:
        return ProposedValue(next(iter(UNITS[dimension])), False, "no unit is in its name")
    return ProposedValue(unit, True, f"as {differences}")


def _rises(times: Array) -> bool:
    steps = np.diff(times[np.isfinite(times)])
    return len(steps) > 0 and bool((steps > 0).all())


def _wraps(column: Array, period: float) -> bool:
    """Whether it jumps by a whole turn, and stays within one."""
    there = column[np.isfinite(column)]
    jump = float(np.abs(np.diff(there)).max()) if len(there) > 1 else 0.0
    return 0.85 * period < jump < 1.002 * period and float(np.ptp(there)) < 1.002 * period


def _length_by_size(top: float) -> ProposedValue:
    """A guess, by how fast a cart is pushed; `top` is the 95th percentile of its speed, a second."""
    unit = "m" if top < MAX_LIKELY_SPEED else "cm" if top < 25 else "mm"
    speed = top * UNITS["length"][unit]
    return ProposedValue(unit, False, f"no unit is in its name; the cart would go {speed:.3g} m/s")
