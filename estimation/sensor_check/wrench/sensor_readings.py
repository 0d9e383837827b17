"""Whether each arm's wrench is of the right sign, axes, frame and unit: every way to read it is tried in the balances.

The gain of a reading is 1/m, and 1/J of the yaw balance: positive, about what the file says. A wrong sign asks for a
negative mass, wrong axes explain less of the motion, and a wrong unit moves the mass by its factor, which is weighed
with how sure the file is.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import product

import numpy as np

from cartgrasp.frames import Array
from cartgrasp.logs import RunLog
from cartgrasp.model import CartModel

from ..evidence import gain_evidence, independent_rows, probabilities
from ..prior import EVERY_ARM, INERTIA_SPREAD, MASS_SPREAD, MODEL, UNITS, Units
from .balance import FORWARD, Balance, balances
from .mountings import Mounting, mountings

KINDS = ("sign", "axes", "frame", "unit")


@dataclass(frozen=True)
class Reading:
    """How the wrenches of some arms are read: a mounting, and an entry of `UNITS`."""

    arms: tuple[str, ...]
    mounting: Mounting
    unit: Units
    prior: float

    @property
    def kinds(self) -> tuple[str, ...]:
        """Of its faults."""
        of_unit = ("unit",) if self.unit is not UNITS[0] else ()
        return ((self.mounting.kind,) if self.mounting.kind else ()) + of_unit


@dataclass(frozen=True)
class SensorCheck:
    """Readings (k) with their probabilities (k,), the masses (k,) that least squares make of them, kg, negative where
    force and acceleration are opposed, and the shares (k,) of the accelerations that they explain with a positive one.
    """

    readings: tuple[Reading, ...]
    probability: Array
    mass: Array
    explained: Array

    @property
    def best(self) -> int:
        return int(self.probability.argmax())

    def of(self, kind: str, arm: str) -> tuple[float, int]:
        """Probability that an arm has a kind of fault, and the likeliest reading with it."""
        which = [i for i, one in enumerate(self.readings) if kind in one.kinds and arm in one.arms]
        return float(self.probability[which].sum()), max(which, key=lambda i: float(self.probability[i]))


def readings_of(arms: tuple[str, ...]) -> tuple[Reading, ...]:
    """Every mounting in every unit, of all arms alike and of each alone; the sound one first."""
    groups = (
        [(arms, 1.0)] if len(arms) == 1 else [(arms, EVERY_ARM), *(((a,), (1 - EVERY_ARM) / len(arms)) for a in arms)]
    )
    sound = mountings()[0], UNITS[0]
    found = [Reading((), *sound, sound[0].prior * sound[1].prior)]
    for (group, share), mounting, unit in product(groups, mountings(), UNITS):
        if mounting is not sound[0] or unit is not sound[1]:
            found.append(Reading(group, mounting, unit, share * mounting.prior * unit.prior))
    return tuple(found)


def sensor_check(log: RunLog, cart: CartModel, mass_spread: float = MASS_SPREAD) -> SensorCheck | None:
    """None where nothing can be told. `mass_spread` is the standard deviation of the log of the file's mass."""
    forward, turning = balances(log, cart)
    if forward is None or not np.any(_sound(forward, tuple(forward.signals))) or not np.any(forward.motion):
        return None
    known, phi = readings_of(tuple(log.arms)), cart.inertia.phi
    ahead = _products(forward, known, np.array([one.mounting.forward(one.unit.factors[0]) for one in known]))
    evidence, log_gain = _evidence(forward, ahead, np.full(len(known), -math.log(phi[0])), mass_spread)
    explained = [_explained(ahead)]
    if turning is not None and np.any(turning.motion):
        about = _products(turning, known, np.array([one.mounting.turning(*one.unit.factors) for one in known]))
        evidence = evidence + _evidence(turning, about, log_gain + math.log(phi[0] / phi[3]), INERTIA_SPREAD)[0]
        explained.append(_explained(about))
    probability = probabilities(evidence, np.array([one.prior for one in known]))
    zz, zy, _ = ahead
    mass = zz / np.where(np.abs(zy) > 1e-12 * zz, zy, np.inf)
    return SensorCheck(known, probability, mass, np.mean(explained, axis=0))


def mass_evidence(log: RunLog, cart: CartModel, mass_spread: float = MASS_SPREAD) -> Callable[[Array], Array]:
    """Takes units (k,) of forces over accelerations to log evidence (k,), for wrenches of the right sign and axes."""
    forward, _ = balances(log, cart)
    sound = None if forward is None else _sound(forward, tuple(forward.signals))
    if forward is None or sound is None or not np.any(sound) or not np.any(forward.motion):
        return lambda units: np.zeros(len(units))
    motion, mass = forward.motion, cart.inertia.mass
    products = float(sound @ sound), float(sound @ motion), float(motion @ motion)

    def evidence(units: Array) -> Array:
        zz, zy, yy = products
        one = np.ones(len(units))
        return _evidence(forward, (zz * one, zy * one, yy), np.log(units) - math.log(mass), mass_spread)[0]

    return evidence


def _evidence(
    balance: Balance, products: tuple[Array, Array, float], mean: Array, spread: float
) -> tuple[Array, Array]:
    """Log evidence and log gains (k,) of products (k,)."""
    rows, unexplained = _left(balance)
    log, log_gain, _ = gain_evidence(products, rows, mean, spread, max(unexplained, MODEL**2))
    return log, log_gain


def _products(balance: Balance, known: tuple[Reading, ...], coefficients: Array) -> tuple[Array, Array, float]:
    """Signal by signal and by motion (k,), and motion by motion, of readings (k) with coefficients (k, s) of the
    signals of their arms; the other arms' are read as they are recorded."""
    zz, zy = np.zeros(len(known)), np.zeros(len(known))
    for group in {one.arms for one in known}:
        which = np.array([i for i, one in enumerate(known) if one.arms == group])
        others = _sound(balance, tuple(a for a in balance.signals if a not in group))
        own = sum((balance.signals[a] for a in group), start=np.zeros((len(balance.motion), coefficients.shape[1])))
        c = coefficients[which]
        zz[which] = others @ others + 2 * c @ (own.T @ others) + np.einsum("ks,st,kt->k", c, own.T @ own, c)
        zy[which] = others @ balance.motion + c @ (own.T @ balance.motion)
    return np.maximum(zz, 0.0), zy, float(balance.motion @ balance.motion)


def _explained(products: tuple[Array, Array, float]) -> Array:
    zz, zy, yy = products
    return np.maximum(zy, 0.0) ** 2 / np.maximum(zz * yy, 1e-300)


def _sound(balance: Balance, arms: tuple[str, ...]) -> Array:
    """The signal (k,) of arms that are read as they are recorded."""
    sound, total = mountings()[0], np.zeros(len(balance.motion))
    for arm in arms:
        signals = balance.signals[arm]
        is_forward = signals.shape[1] == len(FORWARD)
        total = total + signals @ (sound.forward(1.0) if is_forward else sound.turning(1.0, 1.0))
    return total


def _left(balance: Balance) -> tuple[float, float]:
    """Rows that count, and the share of the motion that no gains of the signals explain: the fewer rows of those that
    the log leaves as it is and with any gains."""
    left = []
    for columns in (_sound(balance, tuple(balance.signals))[:, None], np.hstack(list(balance.signals.values()))):
        size = np.linalg.norm(columns, axis=0)
        columns = columns / np.where(size > 0, size, 1.0)
        left.append(balance.motion - columns @ np.linalg.lstsq(columns, balance.motion, rcond=1e-8)[0])
    rows = min(independent_rows(one) for one in left) * (1 - balance.taken / len(balance.motion))
    return max(rows, 1.0), float(left[1] @ left[1]) / float(balance.motion @ balance.motion)
