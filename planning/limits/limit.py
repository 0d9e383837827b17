"""What an arm's wrench in {a} must obey: a Limit answers with bounds, linear rows and cones, each with a
name."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np

from cartgrasp.arms import Arm, UserLimit
from cartgrasp.checks import check_kind
from cartgrasp.contacts import WRENCH_NAMES
from cartgrasp.errors import UsageError
from cartgrasp.frames import Array
from planning.quadratic_program import Cone

UNLIMITED, NO_ROWS, NO_LIMITS = np.full(6, np.inf), np.zeros((0, 6)), np.zeros(0)
UNLIMITED.setflags(write=False)
CONE_FORM = "give it a name, rows (k, 6) and an offset (k,), the cone's axis first"


@dataclass(frozen=True, eq=False)
class LimitRows:
    """`lower <= F <= upper` (6,), `low_limits <= rows @ F <= limits` (k, 6), and cones on F (6,); of several arms
    side by side F is (6n,). Low limits that are left out are infinite, and called as the limits are.

    Certificates tell a name that ends in `upper` or `lower` with the limit's value, and others alone. The unit is N or
    N·m, by the components that a row adds up; N·m where a word of the name is `torque`; none of a mixture. With the
    word `rate` a value keeps its sign."""

    lower: Array = field(default_factory=lambda: -UNLIMITED)
    upper: Array = field(default_factory=lambda: UNLIMITED)
    lower_names: tuple[str, ...] = tuple(f"{name} lower" for name in WRENCH_NAMES)
    upper_names: tuple[str, ...] = tuple(f"{name} upper" for name in WRENCH_NAMES)
    rows: Array = field(default_factory=lambda: NO_ROWS)
    limits: Array = field(default_factory=lambda: NO_LIMITS)
    names: tuple[str, ...] = ()
    cones: tuple[Cone, ...] = ()
    low_limits: Array = field(default_factory=lambda: NO_LIMITS)
    low_names: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if len(self.low_limits) != len(self.limits):
            object.__setattr__(self, "low_limits", np.full(len(self.limits), -np.inf))
            object.__setattr__(self, "low_names", self.names)

    def followed_by(self, other: LimitRows) -> LimitRows:
        """These, and bounds of further unknowns; both have rows over all unknowns."""
        return LimitRows(
            np.concatenate([self.lower, other.lower]),
            np.concatenate([self.upper, other.upper]),
            self.lower_names + other.lower_names,
            self.upper_names + other.upper_names,
            np.vstack([self.rows, other.rows]),
            np.concatenate([self.limits, other.limits]),
            self.names + other.names,
            self.cones + other.cones,
            np.concatenate([self.low_limits, other.low_limits]),
            self.low_names + other.low_names,
        )

    def __and__(self, other: LimitRows) -> LimitRows:
        return self.all_of((self, other))

    @classmethod
    def all_of(cls, parts: Sequence[LimitRows]) -> LimitRows:
        """All limits at once: of bounds the tightest one stays, with its name; of those alike the first."""
        if len(parts) == 1:
            return parts[0]
        lower, upper = np.array([part.lower for part in parts]), np.array([part.upper for part in parts])
        rowed = [part for part in parts if len(part.limits)]
        rows = rowed[0] if len(rowed) == 1 else cls._above_each_other(rowed or parts[:1])
        return cls(
            np.maximum.reduce(lower),
            np.minimum.reduce(upper),
            _picked(tuple([part.lower_names for part in parts]), lower.argmax(axis=0).tobytes()),
            _picked(tuple([part.upper_names for part in parts]), upper.argmin(axis=0).tobytes()),
            rows.rows,
            rows.limits,
            rows.names,
            tuple([cone for part in parts for cone in part.cones]),
            rows.low_limits,
            rows.low_names,
        )

    @classmethod
    def _above_each_other(cls, parts: Sequence[LimitRows]) -> LimitRows:
        """The rows of all parts, stacked, without their bounds and cones."""
        return cls(
            rows=np.concatenate([part.rows for part in parts]),
            limits=np.concatenate([part.limits for part in parts]),
            names=tuple([name for part in parts for name in part.names]),
            low_limits=np.concatenate([part.low_limits for part in parts]),
            low_names=tuple([name for part in parts for name in part.low_names]),
        )


class Limit(ABC):
    """A convex set of wrenches that holds the zero wrench, so a wrench scaled down stays inside."""

    @abstractmethod
    def rows(self, arm: Arm) -> LimitRows:
        """The limit of this arm; names without the arm's."""


def user_rows(limit: UserLimit, arm: Arm) -> LimitRows:
    """The rows of a limit from outside, which are looked at, since kernels look at no bounds."""
    where = f"arm {arm.name}: limits: {type(limit).__name__}"
    rows: LimitRows = limit.rows(arm)
    check_kind(f"{where}: rows", rows, LimitRows, "return LimitRows(...)")
    k = len(rows.rows)
    shapes = {"lower": (6,), "upper": (6,), "rows": (k, 6), "limits": (k,), "low_limits": (k,)}
    for part, shape in shapes.items():
        values = np.asarray(getattr(rows, part))
        if values.shape != shape or values.dtype.kind not in "fiu" or np.isnan(values).any():
            raise UsageError(f"{where}: {part}: {values.tolist()} is not {shape} numbers; give N and N·m")
    if not np.isfinite(rows.rows).all():
        raise UsageError(f"{where}: rows: {np.asarray(rows.rows).tolist()} has a number that is not finite")
    for part, count in {"lower_names": 6, "upper_names": 6, "names": k, "low_names": k}.items():
        names = getattr(rows, part)
        if len(names) != count or not all(names):
            raise UsageError(f"{where}: {part}: {list(names)} are not {count} names; name each, as plans tell them")
    for cone in rows.cones:
        check_kind(f"{where}: cones", cone, Cone, "return LimitRows(cones=(Cone(name, rows, offset),))")
        sizes = np.shape(cone.rows), np.shape(cone.offset)
        if not cone.name or len(sizes[0]) != 2 or sizes != ((len(cone.rows), 6), (len(cone.rows),)) or not sizes[1][0]:
            raise UsageError(f"{where}: cones: {cone.name!r} has rows {sizes[0]} and an offset {sizes[1]}; {CONE_FORM}")
        if not (np.isfinite(cone.rows).all() and np.isfinite(cone.offset).all()):
            raise UsageError(f"{where}: cones: {cone.name} has what is no number; give N and N·m")
    low, high = np.r_[rows.lower, rows.low_limits], np.r_[rows.upper, rows.limits]
    if (low > 0).any() or (high < 0).any() or any(np.linalg.norm(c.offset[1:]) > c.offset[0] for c in rows.cones):
        raise UsageError(f"{where}: it leaves out the wrench 0, so an arm that lets go would break it; take that in")
    return rows


def joined(names: Sequence[str], limits: Iterable[LimitRows]) -> LimitRows:
    """Limits of several arms over all their wrenches (6n,), with the arm's name before each name."""
    limits = tuple(limits)
    n, cones = 6 * len(limits), list[Cone]()
    rows, start = np.zeros((sum(len(part.rows) for part in limits), n)), 0
    for i, (name, part) in enumerate(zip(names, limits, strict=True)):
        columns, stop = slice(6 * i, 6 * i + 6), start + len(part.rows)
        rows[start:stop, columns], start = part.rows, stop
        for cone in part.cones:
            wide = np.zeros((len(cone.rows), n))
            wide[:, columns] = cone.rows
            cones.append(Cone(f"{name}: {cone.name}", wide, cone.offset))

    def named(field: str) -> tuple[str, ...]:
        parts = zip(names, limits, strict=True)
        return tuple([full for name, part in parts for full in _full_names(name, getattr(part, field))])

    return LimitRows(
        lower=np.concatenate([part.lower for part in limits]),
        upper=np.concatenate([part.upper for part in limits]),
        lower_names=named("lower_names"),
        upper_names=named("upper_names"),
        rows=rows,
        limits=np.concatenate([part.limits for part in limits]),
        names=named("names"),
        cones=tuple(cones),
        low_limits=np.concatenate([part.low_limits for part in limits]),
        low_names=named("low_names"),
    )


@lru_cache(maxsize=256)
def _full_names(arm: str, names: tuple[str, ...]) -> tuple[str, ...]:
    return tuple(f"{arm}: {name}" for name in names)


@lru_cache(maxsize=256)
def _picked(names: tuple[tuple[str, ...], ...], picks: bytes) -> tuple[str, ...]:
    """For each place, the name from the part of `names` that the integer in `picks` selects."""
    return tuple(names[i][j] for j, i in enumerate(np.frombuffer(picks, dtype=np.intp).tolist()))
