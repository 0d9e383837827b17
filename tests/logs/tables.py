"""A small good log as text, and how to spoil a cell of it."""

from __future__ import annotations

import numpy as np

from cartgrasp.logs import ArmLog, RunLog

ARM_PARTS = ("px", "py", "pz", "fx", "fy", "fz", "tx", "ty", "tz")
HEADER = ["t", "x", "y", "theta", "vx", "vy", "omega", *(f"left.{part}" for part in ARM_PARTS)]


def rows(n=4):
    return [[str(round(0.01 * i, 6)), *("0.5" for _ in HEADER[1:])] for i in range(n)]


def text(table=None, header=None):
    table = rows() if table is None else table
    return "\n".join([",".join(HEADER if header is None else header), *(",".join(row) for row in table)]) + "\n"


def spoiled(line, column, cell):
    """The good log with another cell in a line of the file (the header is line 1)."""
    table = rows()
    table[line - 2][HEADER.index(column)] = cell
    return text(table)


def without(*columns):
    keep = [i for i, name in enumerate(HEADER) if name not in columns]
    return text([[row[i] for i in keep] for row in rows()], [HEADER[i] for i in keep])


def random_log(rng, n=50, arms=("left", "right"), step=0.01, velocity=True):
    return RunLog(
        time=np.cumsum(rng.uniform(0.5, 1.5, n)) * step,
        pose=rng.normal(size=(n, 3)),
        velocity=rng.normal(size=(n, 3)) if velocity else None,
        arms={arm: ArmLog(rng.normal(size=(n, 3)), 10 * rng.normal(size=(n, 6))) for arm in arms},
        name="random",
    )
