"""The arguments of estimators, checked once when one is made."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from types import NoneType

import numpy as np

from cartgrasp.checks import MAX_DISTANCE, angle, check_kind, check_known, listed, number, shown
from cartgrasp.errors import UsageError
from cartgrasp.model import CartModel
from cartgrasp.motion import Measurement

from ..noise import FilterNoise
from ..prior import Prior

EstimatorArguments = tuple[CartModel, Sequence[str] | None, FilterNoise, Prior, Mapping[str, float]]
"""Cart, arms, noise, prior and yaws."""


def checked_arguments(
    cart: CartModel,
    arms: Sequence[str] | None,
    noise: FilterNoise | None,
    prior: Prior | None,
    yaws: Mapping[str, float] | None,
) -> EstimatorArguments:
    """With what is usual in the place of None."""
    check_kind("filter: cart", cart, CartModel, 'load it first: load_cart("cart.yaml")')
    if arms is not None:
        arms = listed("filter: arms", arms, str, 'write their names: arms=["left", "right"]')
    check_kind("filter: noise", noise, (FilterNoise, NoneType), "write FilterNoise(force=3.0)")
    check_kind("filter: prior", prior, (Prior, NoneType), "write Prior(mass=0.4)")
    check_kind("filter: yaws", yaws, (Mapping, NoneType), 'write yaws={"left": 0.0}')
    check_known("filter: yaws", (yaws or {}) if arms is not None else (), arms or ())
    by_arm = {arm: angle(f"filter: yaws: {arm}", yaw) for arm, yaw in (yaws or {}).items()}
    return cart, arms, noise or FilterNoise(), prior or Prior(), by_arm


FLOAT = np.dtype(float)


def check_measurement(measurement: Measurement) -> None:
    """Says what is wrong with one, before anything was changed by it. Of most a short look, in a quarter of the time,
    says that nothing is."""
    if not _is_usual(measurement):
        _check_thoroughly(measurement)


def _is_usual(measurement: Measurement) -> bool:
    if type(measurement) is not Measurement:
        return False
    if not (isinstance(measurement.time, float) and math.isfinite(measurement.time)):
        return False
    pose, velocity = measurement.pose, measurement.velocity
    wrenches, contacts = measurement.wrenches, measurement.contacts
    if not ((pose is None or _are_numbers(pose, 3)) and (velocity is None or _are_numbers(velocity, 3))):
        return False
    if type(wrenches) is not dict or type(contacts) is not dict:
        return False
    for wrench in wrenches.values():
        if not _are_numbers(wrench, 6):
            return False
    for contact in contacts.values():
        if not _are_numbers(contact, 3) or abs(contact[0]) > MAX_DISTANCE or abs(contact[1]) > MAX_DISTANCE:
            return False
    return True


def _are_numbers(part: object, n: int) -> bool:
    if isinstance(part, np.ndarray):
        return part.dtype is FLOAT and part.shape == (n,)
    return isinstance(part, list | tuple) and len(part) == n and all(isinstance(one, int | float) for one in part)


def owned(measurement: Measurement) -> Measurement:
    """The measurement with arrays of its own: samples wait, and are gone back to, while a caller's arrays go on."""
    pose, velocity = measurement.pose, measurement.velocity
    return Measurement(
        measurement.time,
        None if pose is None else np.array(pose, dtype=float),
        None if velocity is None else np.array(velocity, dtype=float),
        {arm: np.array(wrench, dtype=float) for arm, wrench in measurement.wrenches.items()},
        {arm: np.array(contact, dtype=float) for arm, contact in measurement.contacts.items()},
    )


def _check_thoroughly(measurement: Measurement) -> None:
    cure = "write Measurement(time, pose, velocity, wrenches, contacts)"
    check_kind("filter: measurement", measurement, Measurement, cure)
    if not math.isfinite(number("measurement: time", measurement.time, cure="give s")):
        raise UsageError(f"measurement: time {measurement.time} is not finite; give s")
    parts = {"pose": (measurement.pose, 3), "velocity": (measurement.velocity, 3)}
    for what, by_arm, n in (("wrenches", measurement.wrenches, 6), ("contacts", measurement.contacts, 3)):
        check_kind(f"measurement: {what}", by_arm, Mapping, "write {arm: numbers}")
        parts |= {f"{what}: {arm}": (part, n) for arm, part in by_arm.items()}
        for arm, numbers in by_arm.items():
            if numbers is None:
                raise UsageError(f"measurement: {what}: {arm}: None is no numbers; leave out what is missing")
    for what, (part, n) in parts.items():
        if part is not None and (np.shape(part) != (n,) or np.asarray(part).dtype.kind not in "fiu"):
            raise UsageError(f"measurement: {what}: {shown(part)} is not {n} numbers")
    for arm, contact in measurement.contacts.items():
        x, y, _ = np.asarray(contact, dtype=float).tolist()
        if max(abs(x), abs(y)) > MAX_DISTANCE:
            where = f"({x:g}, {y:g}) is more than {MAX_DISTANCE:g} m from {{b}}"
            raise UsageError(f"measurement: contacts: {arm}: {where}; give m")
