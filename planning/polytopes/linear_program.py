"""Linear programs, solved by HiGHS through SciPy; the only file that knows it."""

from __future__ import annotations

import numpy as np
from scipy.optimize import linprog

from cartgrasp.errors import UsageError
from cartgrasp.frames import Array

SOLVED, UNBOUNDED = 0, 3


def maximizer(
    gain: Array, rows: Array, limits: Array, equal: Array | None = None, what: str = "this"
) -> tuple[Array, Array]:
    """An x (n,) that maximizes `gain · x` subject to `rows @ x <= limits` (k,) and `equal @ x == 0`, and how much more
    each limit would give per unit (k,). `what` names the gain in the words of an error."""
    values = None if equal is None else np.zeros(len(equal))
    answer = linprog(-gain, rows, limits, equal, values, bounds=(None, None), method="highs-ds")
    if answer.status == UNBOUNDED:
        raise UsageError(f"nothing limits {what}; add limits of the arms or their joints")
    if answer.status != SOLVED or answer.x is None:
        raise UsageError(f"{what}: no wrench within all {len(limits)} limits was found: {answer.message}")
    return np.asarray(answer.x, dtype=float), -np.asarray(answer.ineqlin.marginals, dtype=float)
