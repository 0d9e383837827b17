"""Limits of several arms as one."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from planning.quadratic_program import Cone

from .limit import LimitRows


def side_by_side(names: Sequence[str], limits: Sequence[LimitRows]) -> LimitRows:
    """Limits over all arms' wrenches (6n,), with the arm's name before each name."""
    n, rows, cones, start = 6 * len(limits), [np.zeros((0, 6 * len(limits)))], [], 0
    for name, part in zip(names, limits, strict=True):
        columns = slice(start, start + 6)
        rows.append(_wide(part.rows, columns, n))
        cones += [Cone(f"{name}: {cone.name}", _wide(cone.rows, columns, n), cone.offset) for cone in part.cones]
        start += 6

    def named(field: str) -> tuple[str, ...]:
        return tuple(f"{name}: {own}" for name, part in zip(names, limits, strict=True) for own in getattr(part, field))

    return LimitRows(
        lower=np.concatenate([part.lower for part in limits]),
        upper=np.concatenate([part.upper for part in limits]),
        lower_names=named("lower_names"),
        upper_names=named("upper_names"),
        rows=np.concatenate(rows),
        limits=np.concatenate([part.limits for part in limits]),
        names=named("names"),
        cones=tuple(cones),
        low_limits=np.concatenate([part.low_limits for part in limits]),
        low_names=named("low_names"),
    )


def _wide(rows: np.ndarray, columns: slice, n: int) -> np.ndarray:
    wide = np.zeros((len(rows), n))
    wide[:, columns] = rows
    return wide
