"""Checks of an estimate: what it states must be numbers, of a cart that moves as the planner's does."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from cartgrasp.effects import UnknownSlope
from cartgrasp.errors import UsageError
from cartgrasp.frames import Array

from ..plan import INVALID_INPUT, STALE_ESTIMATE
from .plan_inputs import RefusedError, real_numbers

if TYPE_CHECKING:
    from cartgrasp.model import CartModel
    from cartgrasp.motion import Estimate

MAX_ESTIMATE_AGE = 0.5  # s
N_SLOPE = len(UnknownSlope.parameters)
COVARIANCE_TOLERANCE = 1e-6  # of the standard deviations' product


def check_estimate(estimate: Estimate, newest: float) -> float:
    """The time of the newest estimate so far, s; refused if this one isn't finite or much older."""
    try:
        motion = *np.ravel(estimate.motion.pose_sb).tolist(), *np.ravel(estimate.motion.velocity).tolist()
        numbers = [estimate.time, *motion, *(parameter.value for parameter in estimate.parameters.values())]
        is_finite = all(map(math.isfinite, numbers))
    except (AttributeError, TypeError, ValueError, OverflowError) as error:
        raise _refused(f"its time, motion or parameters are not those of an Estimate ({error})") from error
    if not is_finite:
        raise _refused("its time, motion or a parameter is not finite")
    if estimate.time < newest - MAX_ESTIMATE_AGE:
        age = f"{newest - estimate.time:.3g} s older than the newest one given before"
        cure = f"{MAX_ESTIMATE_AGE:g} s is allowed; reset() forgets that one"
        raise RefusedError(STALE_ESTIMATE, f"estimate: {age}; {cure}")
    return max(newest, estimate.time)


def read_cart(estimate: Estimate, basis_b: Array) -> CartModel:
    """The cart as now estimated, on the floor as now estimated; refused unless its free velocities are the planner's,
    `basis_b` (3, k)."""
    try:
        structure, numbers, floor = estimate.structure, real_numbers(estimate.model_parameters), _floor(estimate)
        size, on_floor = len(structure.parameters), structure if floor is None else structure.on_slope
    except AttributeError as error:
        raise _refused(f"it has no cart ({error})") from error
    if numbers is None or numbers.shape != (size,):
        raise _refused(f"model_parameters: {estimate.model_parameters} are not the {size} numbers of its cart")
    try:
        cart = on_floor.with_parameters(numbers if floor is None else np.append(numbers, floor))
    except UsageError as error:
        raise _refused(str(error)) from error
    if cart.basis_b is not basis_b and not np.array_equal(cart.basis_b, basis_b):
        raise _refused("its cart has other rolling constraints than the planner's; make a new planner")
    shapes = np.shape(estimate.motion.pose_sb), np.shape(estimate.motion.velocity)
    if shapes != ((3,), basis_b.shape[1:]):
        form = f"pose_sb (3,) and velocity {basis_b.shape[1:]}"
        raise _refused(f"motion: shapes {shapes[0]} and {shapes[1]} instead of {form}")
    return cart


def read_covariance(estimate: Estimate) -> Array:
    """That of the numbers of `read_cart` (p, p); refused unless it is there and is one."""
    floor, size = _floor(estimate), len(estimate.model_parameters)
    name, size = ("covariance", size) if floor is None else ("covariance_on_floor", size + N_SLOPE)
    given = getattr(estimate, name)
    if given is None:
        raise _refused(f"it has no {name}, which the planner's confidence needs")
    covariance = real_numbers(given)
    if covariance is None:
        raise _refused(f"{name}: it is not a matrix of numbers")
    if covariance.shape != (size, size):
        raise _refused(f"{name}: shape {covariance.shape} instead of {(size, size)}")
    wrong = _wrong_with(covariance.tobytes(), size)
    if wrong:
        raise _refused(f"{name}: {wrong}")
    return covariance


def _floor(estimate: Estimate) -> Array | None:
    """The numbers of the floor's slope, where the estimate has any."""
    floor = getattr(estimate, "floor", None)
    numbers = real_numbers(floor)
    if floor is not None and (numbers is None or numbers.shape != (N_SLOPE,)):
        raise _refused(f"floor: {floor} are not the {N_SLOPE} numbers of an UnknownSlope")
    return None if floor is None else numbers


@lru_cache(maxsize=16)
def _wrong_with(numbers: bytes, size: int) -> str:
    """What keeps numbers (size, size) from being a covariance, in words; often those of the tick before."""
    covariance = np.frombuffer(numbers).reshape(size, size)
    if not np.isfinite(covariance).all():
        return "a value is not finite"
    scale = np.sqrt(np.abs(np.diagonal(covariance)))
    allowed = COVARIANCE_TOLERANCE * np.outer(scale, scale)
    if (np.diagonal(covariance) < 0).any() or (np.abs(covariance - covariance.T) > allowed).any():
        return "not symmetric with a diagonal >= 0"
    units = np.where(scale > 0, scale, 1.0)
    least = float(np.linalg.eigvalsh(covariance / np.outer(units, units))[0])
    return f"not positive semidefinite (eigenvalue {least:.3g})" if least < -COVARIANCE_TOLERANCE else ""


def _refused(why: str) -> RefusedError:
    return RefusedError(INVALID_INPUT, f"estimate: {why}")
