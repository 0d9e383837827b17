"""Wrenches beyond what a sensor can tell, which it tells as the end of its range: what acted then is not known.

Noise keeps a sensor from telling one number twice. One that is the largest of all, and comes far more often than any
other, is such an end. Rows of it are left out: taken as they are, they make the cart too light.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from cartgrasp.errors import printable
from cartgrasp.frames import Array
from cartgrasp.logs import ArmLog

from .frozen_wrenches import tells_noise
from .suspicion import Suspicion

WRENCH_COMPONENTS = ("fx", "fy", "fz", "tx", "ty", "tz")
MIN_CLIPPED_ROWS, MIN_CLIPPED_COUNT_RATIO = 10, 5.0
"""Rows at an end; times as many as of any other number."""
CLIP_MARGIN_INTERVAL = 0.03
"""s: of what is near an end, noise lets only the smaller part through. Of 0.03 to 0.1 masses say the same."""


class RangeLimit(NamedTuple):
    """A component's index, the number (N or N·m) that it does not go beyond, and where (n,) it is told."""

    component: int
    value: float
    rows: np.ndarray


def range_limits(wrench: Array) -> Iterator[RangeLimit]:
    """The ends of range that a wrench (n, 6), NaN where missing, was told at. Nothing is no end."""
    for i, column in enumerate(wrench.T):
        known = column[np.isfinite(column)]
        both = (known.max(), known.min()) if len(known) else ()
        within = known[~np.isin(known, both)]
        for value in both if tells_noise(within[:, None]) else ():
            count = int((known == value).sum())
            if (
                value != 0.0
                and count >= MIN_CLIPPED_ROWS
                and count > MIN_CLIPPED_COUNT_RATIO * np.unique(within, return_counts=True)[1].max()
            ):
                yield RangeLimit(i, float(value), column == value)


def without_clipped(arm: ArmLog, time: Array) -> ArmLog:
    """The arm, with such rows, and those `CLIP_MARGIN_INTERVAL` about them, as missing samples at times (n,)."""
    found = [end.rows for end in range_limits(arm.wrench)]
    at = time[np.any(found, axis=0)] if found else time[:0]
    if not len(at):
        return arm
    after = np.searchsorted(at, time)
    before, behind = time - at[np.maximum(after - 1, 0)], at[np.minimum(after, len(at) - 1)] - time
    near = (np.abs(before) < CLIP_MARGIN_INTERVAL) | (np.abs(behind) < CLIP_MARGIN_INTERVAL)
    return ArmLog(arm.contact, np.where(near[:, None], np.nan, arm.wrench))


def clipped_arm(name: str, arm: ArmLog, time: Array) -> Iterator[Suspicion]:
    """`scale` of an arm, by component and end."""
    for end in range_limits(arm.wrench):
        unit, count = "N" if end.component < 3 else "N·m", int(end.rows.sum())
        words = (
            f"{printable(name)}: {WRENCH_COMPONENTS[end.component]} is {end.value:.6g} {unit} in {count} of "
            f"{len(time)} rows, first at t = {time[int(np.argmax(end.rows))]:g} s, and never beyond: the end of "
            "the sensor's range; these rows are left out: push less, or take a sensor for more"
        )
        yield Suspicion("scale", name, 0.99, None, words, put_right=True)
