"""Checks before the solve: a solver would return numbers for a NaN, so no NaN gets there."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from cartgrasp.arms import Arm
from cartgrasp.checks import shown
from cartgrasp.contacts import MAX_POSITION, ContactWrenches
from cartgrasp.errors import CartgraspError, UsageError
from cartgrasp.frames import Array

from ..plan import INVALID_INPUT

MAX_WRENCH = 1e6  # N, N·m; projections of what is farther from what arms give lose it in rounding
FLOAT_DTYPE = np.dtype(float)
REAL_KINDS = "fiubO"  # kinds of numpy arrays that hold real numbers: no text, dates or complex numbers


class RefusedError(CartgraspError):
    """Data that can't be planned with; becomes a plan's status and message."""

    def __init__(self, status: str, message: str) -> None:
        self.status = status
        super().__init__(message)


def read_wrench(wrench: Any) -> tuple[float, float, float]:
    """(fx, fy, tau) in {b}."""
    return _read(wrench, "wrench", "(fx, fy, tau) in {b}", MAX_WRENCH)


def read_beside(beside: Any) -> Array | None:
    """What others give the cart: a spatial wrench (6,) about {b}'s origin."""
    if beside is None:
        return None
    if not isinstance(beside, ContactWrenches):
        raise RefusedError(INVALID_INPUT, f"beside: {shown(beside)} is not what arms give; write ContactWrenches(…)")
    wrench_b = beside.spatial_wrench_b
    if not (np.abs(wrench_b) <= MAX_WRENCH).all():
        raise RefusedError(INVALID_INPUT, f"beside: {wrench_b.tolist()} is not finite, or beyond {MAX_WRENCH:g}")
    return wrench_b


def read_contacts(contacts: Mapping[str, Any], names: Sequence[str]) -> dict[str, tuple[float, float, float]]:
    """Contacts in {b} of some or all arms, as numbers, which compare fast."""
    if not isinstance(contacts, Mapping):
        raise RefusedError(INVALID_INPUT, "contacts: a mapping from arm to (x, y, z) is needed")
    for name in contacts:
        if name not in names:
            raise RefusedError(INVALID_INPUT, f"contacts: there is no arm {name!r}; there are {', '.join(names)}")
    return {
        name: _read(point, f"contacts: {name}", "(x, y, z) in {b}", MAX_POSITION) for name, point in contacts.items()
    }


def read_arms(arms: Any, names: Sequence[str]) -> dict[str, Arm]:
    """By name."""
    given = list(arms) if isinstance(arms, Iterable) and not isinstance(arms, str) else [arms]
    if not given:
        raise RefusedError(INVALID_INPUT, "arms: none given; name those that hold, or leave `arms` out for the same")
    found = dict[str, Arm]()
    for arm in given:
        if not isinstance(arm, Arm):
            raise RefusedError(INVALID_INPUT, f"arms: {shown(arm)} is not an Arm; give those made, arms=[left]")
        if arm.name not in names:
            raise RefusedError(INVALID_INPUT, f"arms: there is no arm {arm.name!r}; there are {', '.join(names)}")
        if arm.name in found:
            raise RefusedError(INVALID_INPUT, f"arms: {arm.name} stands twice; names must differ")
        found[arm.name] = arm
    return found


def read_start(wrenches: Mapping[str, Any], names: Sequence[str]) -> Array:
    """Wrenches (6n,) in {a}, of arms left out zero."""
    given = dict(wrenches) if isinstance(wrenches, Mapping) else {"": wrenches}
    rows = [real_numbers(given.get(name, np.zeros(6))) for name in names]
    if set(given) <= set(names) and all(row is not None and row.shape == (6,) for row in rows):
        last = np.concatenate([row for row in rows if row is not None])
        if (np.abs(last) <= MAX_WRENCH).all():
            return last
    raise UsageError(f"start_from: {wrenches} are not wrenches (6,) within {MAX_WRENCH:g} of {', '.join(names)}")


def real_numbers(value: Any) -> Array | None:
    """As floats; None where they are none."""
    try:
        numbers = np.asarray(value)
        if numbers.dtype is FLOAT_DTYPE:
            return numbers
        return numbers.astype(float) if numbers.dtype.kind in REAL_KINDS else None
    except (TypeError, ValueError, OverflowError):
        return None


def _read(value: Any, what: str, form: str, largest: float) -> tuple[float, float, float]:
    numbers = real_numbers(value)
    if numbers is None:
        raise RefusedError(INVALID_INPUT, f"{what}: {value!r} is not three numbers {form}")
    if numbers.shape != (3,):
        raise RefusedError(INVALID_INPUT, f"{what}: shape {numbers.shape} instead of three numbers {form}")
    a, b, c = numbers.tolist()
    if not (abs(a) <= largest and abs(b) <= largest and abs(c) <= largest):
        raise RefusedError(INVALID_INPUT, f"{what}: {[a, b, c]} is not finite, or beyond {largest:g}; {form} is needed")
    return a, b, c
