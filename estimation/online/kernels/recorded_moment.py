"""What is recorded of a moment, taken into the rows of the last moments: the motion, which no wrench tells of
(`tracked_motion.py`), and beside it the wrench (`measured_wrench.py`)."""

from __future__ import annotations

from cartgrasp.frames import Array

from . import row_algebra
from .jit import compiled, entry
from .measured_wrench import MeasuredWrench, hold, record_wrench, size
from .tracked_motion import follow, known_of, take

NEW_MOMENT, WRENCH_USED, ROW_DUE = 1, 2, 4
"""Said of a sample, as a sum: it begins another moment; its wrench counts; a row of the regression may be due."""
TIME_TOLERANCE = 1e-9
"""s."""

_known_of, _size, _over = compiled(known_of), compiled(size), compiled(row_algebra.over)


@entry
def record(
    rows: Array, known: Array, n: int, time: float, seen: Array, wrenches: Array, grip: Array, believed: Array
) -> int:
    """A sample at the last of n moments, or later: a pose and a velocity `seen` (6,), NaN where missing, and what is
    `MeasuredWrench`, if wrenches are."""
    f, felt, said = len(grip), MeasuredWrench(wrenches, grip, believed), 0
    if time - rows[n - 1, 0] > TIME_TOLERANCE:
        go_on(rows, known, n, time, felt)
        n, said = n + 1, NEW_MOMENT
    take(rows, n - 1, known, seen, f)
    if len(wrenches) > 0 and record_wrench(rows, n - 1, time, felt, _known_of(known, f).room):
        said += WRENCH_USED
    if _over(rows[:n])[0] > 0:
        said += ROW_DUE
    return said


@compiled
def go_on(rows: Array, known: Array, i: int, time: float, felt: MeasuredWrench) -> None:
    """To moment i > 0, of which nothing is seen yet, and which has the last one's wrench."""
    f = len(felt.grip)
    p = (len(felt.believed) - f * f) // (f + 1)
    end = 1 + _size(f, p)
    hold(rows, i, time, end - 1, f)
    follow(rows, i, time - rows[i - 1, 0], known, rows[i - 1, end - f : end])
