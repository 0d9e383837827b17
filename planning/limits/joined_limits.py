"""Limits of several arms as one."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import lru_cache

import numpy as np

from planning.quadratic_program import Cone

from .limit import LimitRows


def joined(names: Sequence[str], limits: Iterable[LimitRows]) -> LimitRows:
    """Limits over all arms' wrenches (6n,), with the arm's name before each name."""
    limits = tuple(limits)
    n, cones = 6 * len(limits), list[Cone]()
    rows, start = np.zeros((sum(len(part.rows) for part in limits), n)), 0
    for i, (name, part) in enumerate(zip(names, limits, strict=True)):
        columns, stop = slice(6 * i, 6 * i + 6), start + len(part.rows)
        rows[start:stop, columns], start = part.rows, stop
        cones += [Cone(f"{name}: {cone.name}", _wide(cone.rows, columns, n), cone.offset) for cone in part.cones]

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


def _wide(rows: np.ndarray, columns: slice, n: int) -> np.ndarray:
    wide = np.zeros((len(rows), n))
    wide[:, columns] = rows
    return wide
