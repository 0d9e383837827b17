"""`RunLog`: the measured or simulated record of one push, one row per instant."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from ..checks import brief, check_kind, digits, rows
from ..errors import DataError, UsageError
from ..frames import PLANAR, Array
from ..motion import Measurement

POSE_COLUMNS = ("x", "y", "theta")
VELOCITY_COLUMNS = ("vx", "vy", "omega")
CONTACT_COLUMNS = ("px", "py", "pz")
WRENCH_COLUMNS = ("fx", "fy", "fz", "tx", "ty", "tz")


@dataclass(frozen=True)
class ArmLog:
    """Contact point (n, 3) in {b}, m, and measured wrench (n, 6) in {a}, N and N·m, of one arm; NaN where missing."""

    contact: Array
    wrench: Array

    def __post_init__(self) -> None:
        object.__setattr__(self, "contact", rows("arm: contact", self.contact, CONTACT_COLUMNS))
        object.__setattr__(self, "wrench", rows("arm: wrench", self.wrench, WRENCH_COLUMNS, len(self.contact)))

    @property
    def pushes(self) -> bool:
        """Whether any number of its wrench is there and not zero."""
        return bool((np.nan_to_num(self.wrench) != 0.0).any())


@dataclass(frozen=True)
class RunLog:
    """What was measured, or simulated, of a push: one row an instant. A missing sample is NaN.

    Args:
        time: (n,), s, strictly increasing.
        pose: (n, 3): x, y, theta of {b} in {s}, m and rad.
        velocity: (n, 3): vx, vy, omega of {b}'s origin in {s}, m/s and rad/s; None: not measured.
        arms: Contact and wrench by arm; none where nobody touches the cart.
        name: Where it is from; errors say it.
        notes: Of the reader, by what they are about.
        coasting: Says of a log whose wrenches are zero throughout that nobody pushed (`coasting.py`).

    Raises:
        DataError: No rows, times that do not increase, or a push in a log that is said to coast.

    Example:
        >>> import numpy as np
        >>> import cartgrasp as cg
        >>> time, still = np.arange(100) / 50, np.zeros((100, 3))
        >>> hand = cg.ArmLog(contact=still + [-0.25, 0.0, 1.0], wrench=np.zeros((100, 6)))
        >>> log = cg.RunLog(time, still, None, {"hand": hand})
        >>> len(log), log.duration, log.columns[:5]
        (100, 1.98, ('t', 'x', 'y', 'theta', 'hand.px'))
        >>> cg.write_log(log, "still.csv").name
        'still.csv'
    """

    time: Array
    pose: Array
    velocity: Array | None
    arms: Mapping[str, ArmLog]
    name: str = "run"
    notes: Mapping[str, str] = field(default_factory=dict)
    coasting: bool = False

    def __post_init__(self) -> None:
        check_kind("log: name", self.name, str, 'say where it is from, name="run.csv"')
        object.__setattr__(self, "time", rows(f"{self.name}: time", self.time, ("t",)))
        n = len(self.time)
        if n == 0:
            raise DataError(f"{self.name}: the log has no rows")
        object.__setattr__(self, "pose", rows(f"{self.name}: pose", self.pose, POSE_COLUMNS, n))
        if self.velocity is not None:
            object.__setattr__(self, "velocity", rows(f"{self.name}: velocity", self.velocity, VELOCITY_COLUMNS, n))
        self._check_clock()
        self._check_arms()
        pushing = [name for name, arm in self.arms.items() if arm.pushes] if self.coasting else []
        if pushing:
            raise DataError(
                f"{self.name}: is said to coast, but the wrench of arm {pushing[0]} is not zero throughout; leave "
                "--coasting out, or the arm's columns if nobody's hand was at its sensor"
            )

    def _check_clock(self) -> None:
        """Times are finite, and each is later than the one before."""
        right = np.isfinite(self.time)
        right[1:] &= self.time[1:] > self.time[:-1]
        if not right.all():
            i = int(np.argmin(right))
            before = f" after {self.time[i - 1]:.15g} s" if i else ""
            why = "must be finite and increase strictly; leave such rows out, or mend their clock"
            raise DataError(f"{self.name}: time: {self.time[i]:.15g} s in row {i}{before}: times {why}")

    def _check_arms(self) -> None:
        cure = 'write {"left": ArmLog(contact, wrench)}, or {} where nobody touches the cart'
        check_kind(f"{self.name}: arms", self.arms, Mapping, cure)
        for name, arm in self.arms.items():
            if not isinstance(name, str) or not name or "." in name:
                raise UsageError(f"{self.name}: arms: {name!r} is no name of an arm; give a word without a dot")
            check_kind(f"{self.name}: arms: {name}", arm, ArmLog, cure)
            if len(arm.contact) != len(self):
                raise UsageError(
                    f"{self.name}: arms: {name}: {len(arm.contact)} rows, but the log has {len(self)}; give NaN where "
                    "nothing was measured"
                )

    def __repr__(self) -> str:
        arms = f"arms {', '.join(self.arms)}" if self.arms else "no arms"
        velocity = "no velocity" if self.velocity is None else ""
        return brief("RunLog", repr(self.name), f"{len(self)} rows", f"{digits(self.duration)} s", arms, velocity)

    def __len__(self) -> int:
        return len(self.time)

    @property
    def duration(self) -> float:
        return float(self.time[-1] - self.time[0])

    @property
    def columns(self) -> tuple[str, ...]:
        arms = (f"{arm}.{c}" for arm in self.arms for c in CONTACT_COLUMNS + WRENCH_COLUMNS)
        velocity = () if self.velocity is None else VELOCITY_COLUMNS
        return ("t", *POSE_COLUMNS, *velocity, *arms)

    @property
    def table(self) -> Array:
        """All columns, shape (n, columns)."""
        velocity = [] if self.velocity is None else [self.velocity]
        arms = [part for arm in self.arms.values() for part in (arm.contact, arm.wrench)]
        return np.column_stack([self.time, self.pose, *velocity, *arms])

    def thinned(self, rate: float = 250.0) -> RunLog:
        """About `rate` rows a second, each of a bin of rows: the fullest pose, at its own time, the fullest velocity
        and contact, and the mean of the wrenches that are there. Sensors may have rates of their own."""
        with np.errstate(over="ignore"):
            step = float(np.median(np.diff(self.time))) if len(self) > 1 else np.inf
        size = int(min((1.0 + stamp_rounding(self.time) / step) / (rate * step) + 1e-6, len(self)))
        if size < 2:
            return self
        n = len(self) // size * size

        def fullest(columns: Array) -> Array:
            known = np.isfinite(columns[:n]).sum(axis=1).reshape(-1, size)
            return np.asarray(np.arange(0, n, size) + known.argmax(axis=1))

        def mean(columns: Array) -> Array:
            values = columns[:n].reshape(-1, size, columns.shape[1])
            there = ~np.isnan(values).all(axis=2, keepdims=True)
            count = there.sum(axis=1)
            total = np.where(there, values, 0.0).sum(axis=1)
            return np.asarray(np.where(count > 0, total / np.maximum(count, 1), np.nan))

        rows = fullest(self.pose)
        arms = {name: ArmLog(arm.contact[fullest(arm.contact)], mean(arm.wrench)) for name, arm in self.arms.items()}
        velocity = None if self.velocity is None else self.velocity[fullest(self.velocity)]
        return replace(self, time=self.time[rows], pose=self.pose[rows], velocity=velocity, arms=arms)

    def measurements(self) -> Iterator[Measurement]:
        """The rows one after another; a part that is missing whole is left out."""
        for i, time in enumerate(self.time):
            velocity = None if self.velocity is None else _present(self.velocity[i])
            held = [(arm, log.wrench[i], log.contact[i]) for arm, log in self.arms.items()]
            wrenches = {arm: wrench for arm, wrench, _ in held if np.isfinite(wrench[[*PLANAR]]).all()}
            contacts = {arm: contact for arm, _, contact in held if np.isfinite(contact[:2]).all()}
            yield Measurement(float(time), _present(self.pose[i]), velocity, wrenches, contacts)

    @classmethod
    def from_measurements(cls, measurements: Sequence[Measurement], arms: Sequence[str], name: str = "run") -> RunLog:
        n = len(measurements)

        def stack(parts: list[Array | None], width: int) -> Array:
            table = np.full((n, width), np.nan)
            for i, part in enumerate(parts):
                if part is not None:
                    table[i] = part
            return table

        velocities = [m.velocity for m in measurements]
        return cls(
            time=np.array([m.time for m in measurements]),
            pose=stack([m.pose for m in measurements], 3),
            velocity=None if all(v is None for v in velocities) else stack(velocities, 3),
            arms={
                arm: ArmLog(
                    stack([m.contacts.get(arm) for m in measurements], 3),
                    stack([m.wrenches.get(arm) for m in measurements], 6),
                )
                for arm in arms
            },
            name=name,
        )


def stamp_rounding(time: Array) -> float:
    """By how much a difference of two of these times (n,), s, may be off because they are rounded: of unix time doubles
    hold a quarter of a microsecond, so that even steps differ."""
    return float(np.spacing(np.abs(time).max()))


def _present(row: Array) -> Array | None:
    return None if np.isnan(row).all() else row
