"""Logs in which nobody pushes: the cart coasts.

A log coasts where it has no arm, or where it is said to (`RunLog.coasting`) and its wrenches are zero throughout.
Zeros alone say nothing: a sensor that is not connected gives them, too.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..errors import DataError, UsageError
from .run_log import ArmLog, RunLog

NOBODY = "nobody"
"""The arm whose wrench is zero."""


def coasts(log: RunLog) -> bool:
    """Whether nobody pushes in it: its mass can't be learned, and forces are known per mass only."""
    return log.coasting or not log.arms


def without_idle_arms(log: RunLog) -> RunLog:
    """The log, of no arm where nobody pushes."""
    return replace(log, arms={}) if coasts(log) else log


def is_silent(log: RunLog) -> bool:
    """Whether it has arms, of which some wrench is recorded and none is ever other than zero."""
    recorded = any(np.isfinite(arm.wrench).any() for arm in log.arms.values())
    return recorded and not any(arm.pushes for arm in log.arms.values())


def said_to_coast(log: RunLog) -> RunLog:
    """The log as one in which nobody pushes; refused where somebody does."""
    return log if coasts(log) else replace(log, coasting=True)


def check_said(log: RunLog) -> None:
    """Refuses a log whose wrenches are all zero and that is not said to coast."""
    if is_silent(log) and not coasts(log):
        raise DataError(
            f"{log.name}: all its wrenches are zero: if nobody pushed, say so with --coasting (in Python "
            "`said_to_coast(log)`); else look at the sensor's connection"
        )


def check_pushed(log: RunLog, why: str) -> None:
    """Refuses a log that coasts; `why` says what needs a wrench, and what would do instead."""
    check_said(log)
    if coasts(log):
        raise DataError(f"{log.name}: nobody pushes in it, {why}")


def with_zero_wrench(log: RunLog) -> RunLog:
    """A log that coasts as one whose wrench is known at every row, to be zero: of one arm, at {b}'s origin."""
    if not coasts(log):
        raise UsageError(f"{log.name}: somebody pushes in it, so its wrench is not zero")
    n = len(log)
    return replace(log, arms={NOBODY: ArmLog(np.zeros((n, 3)), np.zeros((n, 6)))}, coasting=True)
