"""How much a wrench may change from one call to the next: |F - F_last| <= wrench_rate · period, per axis of {a}.

The last wrench holds it, the zero wrench need not: what is held instead of a plan shrinks no faster than this.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np

from cartgrasp.arms import Arm
from cartgrasp.contacts import WRENCH_NAMES
from cartgrasp.frames import Array

from .limit import LimitRows


@dataclass(frozen=True, eq=False)
class WrenchRate:
    """`step` (6n,): most that each component of all arms may change in one call, N and N·m, `inf` for no limit."""

    step: Array
    names: tuple[str, ...]

    @classmethod
    def of(cls, arms: Sequence[Arm], period: float) -> Self | None:
        """None where no arm has a rate."""
        if not any(math.isfinite(rate) for arm in arms for rate in arm.wrench_rate):
            return None
        with np.errstate(over="ignore", under="ignore"):
            step = period * np.concatenate([arm.wrench_rate for arm in arms])
        names = tuple(f"{arm.name}: {name} rate" for arm in arms for name in WRENCH_NAMES)
        return cls(step, names) if np.isfinite(step).any() else None

    def around(self, last: Array) -> LimitRows:
        """Bounds (6n,) about the last wrenches."""
        lower_names = tuple(f"{name} lower" for name in self.names)
        upper_names = tuple(f"{name} upper" for name in self.names)
        return LimitRows(last - self.step, last + self.step, lower_names, upper_names, np.zeros((0, len(last))))

    def towards(self, last: Array, wanted: Array) -> Array:
        """As near to wrenches (6n,) that are wanted as one call may come, straight from the last."""
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            part = np.nan_to_num(self.step / np.abs(wanted - last), nan=np.inf, posinf=np.inf).min()
        return wanted if part >= 1.0 else last + part * (wanted - last)

    def shrink(self, wrenches: Array, factor: float) -> float:
        """The smallest factor from `factor` on by which wrenches (6n,) may be scaled in one call."""
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            least = 1.0 - self.step / np.abs(wrenches)
        return max(factor, float(np.nan_to_num(least, nan=0.0, neginf=0.0).max()))


def towards(rate: WrenchRate | None, last: Array | None, wanted: Array) -> Array:
    """`WrenchRate.towards`, where there is a rate, and something was given last."""
    return wanted if rate is None or last is None else rate.towards(last, wanted)
