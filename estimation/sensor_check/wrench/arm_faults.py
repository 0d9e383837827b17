"""What is told of arms' force sensors, one fault after the other, and put right."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from cartgrasp.errors import printable
from cartgrasp.frames import Array
from cartgrasp.logs import RunLog
from cartgrasp.logs.run_log import ArmLog
from cartgrasp.model import CartModel

from ..motion.track import Track
from ..prior import MASS_SPREAD
from ..suspicion import SURE, TOLD, Suspicion
from .sensor_readings import KINDS, Reading, SensorCheck, sensor_check


def arm_suspicions(log: RunLog, cart: CartModel, mass_spread: float = MASS_SPREAD) -> tuple[Suspicion, ...]:
    """`sign`, `axes`, `frame` and `unit` of each arm. Where a reading is sure, it is put right before the other arms
    are judged."""
    told, left = list[Suspicion](), list(log.arms)
    while left:
        check = sensor_check(log, cart, mass_spread)
        if check is None:
            break
        sure = sure_reading(check)
        now = [arm for arm in left if sure is None or arm in sure.arms]
        told += [one for arm in now for kind in KINDS if (one := _told(check, kind, arm, cart)) is not None]
        left = [arm for arm in left if arm not in now]
        if sure is None or not now:
            break
        log = with_reading(log, sure)
    return tuple(told)


def sure_reading(check: SensorCheck) -> Reading | None:
    """The likeliest, where a fault of its kind is sure in each of its arms, however it comes about."""
    best = check.readings[check.best]
    faults = [check.of(kind, arm)[0] for kind in best.kinds for arm in best.arms]
    return best if faults and min(faults) >= SURE else None


def with_reading(log: RunLog, reading: Reading) -> RunLog:
    """The log with wrenches as a reading has them."""
    heading = Track.of(log).headed(log.time)
    arms = dict(log.arms)
    for name in reading.arms:
        arms[name] = ArmLog(arms[name].contact, _read(arms[name].wrench, reading, heading))
    return replace(log, arms=arms)


def _read(wrench: Array, reading: Reading, heading: Array) -> Array:
    """Wrenches (n, 6) in {a}; components that no balance has keep what was recorded."""
    found, how = wrench.copy(), reading.mounting
    if how.of_world:
        c, s = np.cos(heading), np.sin(heading)
        found[:, 0], found[:, 1] = c * wrench[:, 0] + s * wrench[:, 1], c * wrench[:, 1] - s * wrench[:, 0]
    else:
        found[:, :2], found[:, 5] = wrench[:, :3] @ how.force.T, wrench[:, 3:] @ how.moment
    found[:, :3] *= reading.unit.factors[0]
    found[:, 3:] *= reading.unit.factors[1]
    return found


def _told(check: SensorCheck, kind: str, arm: str, cart: CartModel) -> Suspicion | None:
    probability, at = check.of(kind, arm)
    if probability < TOLD:
        return None
    reading, recorded, so = check.readings[at], check.mass[0], check.mass[at]
    shares = f"{100 * check.explained[at]:.0f} % of the accelerations rather than {100 * check.explained[0]:.0f} %"
    name, factor = printable(arm), None
    if kind == "unit":
        (force, moment), (force_factor, moment_factor), _ = reading.unit
        factor = force_factor if force_factor != 1.0 else moment_factor
        words = (
            f"{name}: wrenches seem to be in {force} and {moment}: as recorded, the mass would be {recorded:.3g} kg, "
            f"so it is {so:.3g} kg (the cart file says {cart.inertia.mass:.3g}), which explains {shares}; multiply "
            f"forces by {force_factor:.6g} and moments by {moment_factor:.6g}, or mend the file's mass"
        )
    elif kind == "sign":
        factor = -1.0
        words = (
            f"{name}: {reading.mounting.words}: as recorded, the motion asks for a mass of {recorded:.3g} kg, so "
            f"for {so:.3g} kg, and they explain {shares}; record what the arm does to the cart (or x runs backwards)"
        )
    else:
        words = f"{name}: {reading.mounting.words}: so they explain {shares}; turn the sensor's axes into the contact's"
    return Suspicion(kind, arm, probability, factor, words)
