"""Checks before the solve: a solver would return numbers for a NaN, so no NaN gets there."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from cartgrasp.contacts import LARGEST_POSITION
from cartgrasp.errors import CartgraspError
from cartgrasp.frames import Array

from .plan import INVALID_INPUT, STALE_ESTIMATE

if TYPE_CHECKING:
    from cartgrasp.motion import Estimate

LARGEST_WRENCH = 1e9  # N, N·m
MAX_ESTIMATE_AGE = 0.5  # s
COVARIANCE_TOLERANCE = 1e-6  # of the standard deviations' product


class RefusedError(CartgraspError):
    """Data that can't be planned with; becomes a plan's status and message."""

    def __init__(self, status: str, message: str) -> None:
        self.status = status
        super().__init__(message)


def read_wrench(wrench: Any) -> tuple[float, float, float]:
    """(fx, fy, tau) in {b}."""
    return _read(wrench, "wrench", "(fx, fy, tau) in {b}", LARGEST_WRENCH)


def read_contacts(contacts: Mapping[str, Any], names: Sequence[str]) -> dict[str, tuple[float, float, float]]:
    """Contacts in {b} of some or all arms, as numbers, which compare fast."""
    if not isinstance(contacts, Mapping):
        raise RefusedError(INVALID_INPUT, "contacts: a mapping from arm to (x, y, z) is needed")
    for name in contacts:
        if name not in names:
            raise RefusedError(INVALID_INPUT, f"contacts: there is no arm {name!r}; there are {', '.join(names)}")
    return {
        name: _read(point, f"contacts: {name}", "(x, y, z) in {b}", LARGEST_POSITION)
        for name, point in contacts.items()
    }


def check_estimate(estimate: Estimate, newest: float) -> float:
    """The time of the newest estimate so far, s; refused if this one isn't finite or much older."""
    motion = np.concatenate((np.ravel(estimate.motion.pose_sb), np.ravel(estimate.motion.velocity)))
    numbers = [estimate.time, *motion.tolist(), *(parameter.value for parameter in estimate.parameters.values())]
    if not all(map(math.isfinite, numbers)):
        raise RefusedError(INVALID_INPUT, "estimate: its time, motion or a parameter is not finite")
    if estimate.time < newest - MAX_ESTIMATE_AGE:
        age = newest - estimate.time
        raise RefusedError(STALE_ESTIMATE, f"estimate: {age:.3g} s older than the newest one given before")
    return max(newest, estimate.time)


def read_covariance(estimate: Estimate) -> Array:
    """That of the model's parameters (p, p); refused unless it is there and is one."""
    covariance, size = estimate.covariance, len(estimate.model_parameters)
    if covariance is None:
        raise RefusedError(INVALID_INPUT, "estimate: it has no covariance, which the planner's confidence needs")
    if np.shape(covariance) != (size, size):
        shape = np.shape(covariance)
        raise RefusedError(INVALID_INPUT, f"estimate: covariance: shape {shape} instead of {(size, size)}")
    if not np.isfinite(covariance).all():
        raise RefusedError(INVALID_INPUT, "estimate: covariance: a value is not finite")
    scale = np.sqrt(np.abs(np.diagonal(covariance)))
    allowed = COVARIANCE_TOLERANCE * np.outer(scale, scale)
    if (np.diagonal(covariance) < 0).any() or (np.abs(covariance - covariance.T) > allowed).any():
        raise RefusedError(INVALID_INPUT, "estimate: covariance: not symmetric with a diagonal >= 0")
    units = np.where(scale > 0, scale, 1.0)
    least = float(np.linalg.eigvalsh(covariance / np.outer(units, units))[0])
    if least < -COVARIANCE_TOLERANCE:
        raise RefusedError(INVALID_INPUT, f"estimate: covariance: not positive semidefinite (eigenvalue {least:.3g})")
    return covariance


def _read(value: Any, what: str, form: str, largest: float) -> tuple[float, float, float]:
    try:
        numbers = np.asarray(value, dtype=float)
    except (TypeError, ValueError, OverflowError) as error:
        raise RefusedError(INVALID_INPUT, f"{what}: {value!r} is not three numbers {form}") from error
    if numbers.shape != (3,):
        raise RefusedError(INVALID_INPUT, f"{what}: shape {numbers.shape} instead of three numbers {form}")
    a, b, c = numbers.tolist()
    if not (abs(a) <= largest and abs(b) <= largest and abs(c) <= largest):
        raise RefusedError(INVALID_INPUT, f"{what}: {[a, b, c]} is not finite, or beyond {largest:g}; {form} is needed")
    return a, b, c
