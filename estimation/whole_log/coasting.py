"""Logs in which nobody pushes, for what learns from wrenches: the wrench is zero, and known to be.

Forces are then known per mass only, so the body is taken as given, and effects are told for its mass.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from cartgrasp.first_guess import PHYSICAL_NAMES
from cartgrasp.logs import RunLog, coasts
from cartgrasp.logs.coasting import with_zero_wrench

from ..prior import Prior


def with_known_wrench(log: RunLog) -> RunLog:
    """The log, with its wrench written out where nobody pushes."""
    return with_zero_wrench(log) if coasts(log) else log


def body_as_given(logs: Sequence[RunLog], prior: Prior | None = None) -> Prior:
    """The prior, with mass, CoM and inertia known where nobody pushes in any of the logs."""
    prior = prior or Prior()
    return replace(prior, known=prior.known | set(PHYSICAL_NAMES)) if all(coasts(log) for log in logs) else prior
