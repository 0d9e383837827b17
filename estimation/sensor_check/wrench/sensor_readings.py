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
from ..prior import EVERY_ARM, INERTIA_SPREAD, MASS_SPREAD, MODEL, SAME_GAIN, UNITS, Units
from .balance import Balance, balances
from .mountings import Mounting, mountings

NOTHING = 1e-20
"""Of the largest sum of squares: a component that nobody records can't be the one that pushed."""
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
    found = balances(log, cart)
    if found is None or not _speaks(found.forward):
        return None
    known, phi = readings_of(tuple(log.arms)), cart.inertia.phi
    how = np.array([one.mounting.forward(one.unit.factors[0]) for one in known])
    ahead = _products(found.forward, known, how)
    mean = np.full(len(known), -math.log(phi[0]))
    evidence, log_gain = _evidence(ahead, _left(found.forward, how[0]), mean, mass_spread)
    explained = [_explained(ahead)]
    others = (
        (found.sideways, [one.mounting.sideways(one.unit.factors[0]) for one in known], 1.0, SAME_GAIN),
        (found.turning, [one.mounting.turning(*one.unit.factors) for one in known], phi[0] / phi[3], INERTIA_SPREAD),
    )
    for balance, coefficients, ratio, spread in others:
        if balance is not None and _speaks(balance):
            how = np.array(coefficients)
            products = _products(balance, known, how)
            evidence = evidence + _evidence(products, _left(balance, how[0]), log_gain + math.log(ratio), spread)[0]
            explained.append(_explained(products))
    zz, zy, _ = ahead
    evidence = np.where(zz > NOTHING * zz.max(), evidence, -np.inf)
    probability = probabilities(evidence, np.array([one.prior for one in known]))
    mass = zz / np.where(np.abs(zy) > 1e-12 * zz, zy, np.inf)
    return SensorCheck(known, probability, mass, np.mean(explained, axis=0))


def mass_evidence(log: RunLog, cart: CartModel, mass_spread: float = MASS_SPREAD) -> Callable[[Array], Array]:
    """Takes units (k,) of forces over accelerations to log evidence (k,), for wrenches of the right sign and axes."""
    found = balances(log, cart)
    if found is None or not _speaks(found.forward):
        return lambda units: np.zeros(len(units))
    forward, mass = found.forward, cart.inertia.mass
    sound, motion = _recorded(forward, tuple(forward.signals), mountings()[0].forward(1.0)), forward.motion
    products = float(sound @ sound), float(sound @ motion), float(motion @ motion)
    rows = _left(forward, mountings()[0].forward(1.0))

    def evidence(units: Array) -> Array:
        zz, zy, yy = products
        one = np.ones(len(units))
        return _evidence((zz * one, zy * one, yy), rows, np.log(units) - math.log(mass), mass_spread)[0]

    return evidence


def _speaks(balance: Balance) -> bool:
    """Whether anything moves, and anything is recorded that could have moved it."""
    return bool(np.any(balance.motion)) and any(np.any(one) for one in balance.signals.values())


def _evidence(
    products: tuple[Array, Array, float], left: tuple[float, float], mean: Array, spread: float
) -> tuple[Array, Array]:
    """Log evidence and log gains (k,) of products (k,), for rows that count and what is left unexplained."""
    rows, unexplained = left
    log, log_gain, _ = gain_evidence(products, rows, mean, spread, max(unexplained, MODEL**2))
    return log, log_gain


def _products(balance: Balance, known: tuple[Reading, ...], coefficients: Array) -> tuple[Array, Array, float]:
    """Signal by signal and by motion (k,), and motion by motion, of readings (k) with coefficients (k, s) of the
    signals of their arms; the other arms' are read as they are recorded."""
    zz, zy = np.zeros(len(known)), np.zeros(len(known))
    for group in {one.arms for one in known}:
        which = np.array([i for i, one in enumerate(known) if one.arms == group])
        others = _recorded(balance, tuple(a for a in balance.signals if a not in group), coefficients[0])
        own = sum((balance.signals[a] for a in group), start=np.zeros((len(balance.motion), coefficients.shape[1])))
        c = coefficients[which]
        zz[which] = others @ others + 2 * c @ (own.T @ others) + np.einsum("ks,st,kt->k", c, own.T @ own, c)
        zy[which] = others @ balance.motion + c @ (own.T @ balance.motion)
    return np.maximum(zz, 0.0), zy, float(balance.motion @ balance.motion)


def _explained(products: tuple[Array, Array, float]) -> Array:
    zz, zy, yy = products
    return np.maximum(zy, 0.0) ** 2 / np.maximum(zz * yy, 1e-300)


def _recorded(balance: Balance, arms: tuple[str, ...], coefficients: Array) -> Array:
    """The signal (k,) of arms that are read as they are recorded, with those coefficients (s,)."""
    return sum((balance.signals[arm] @ coefficients for arm in arms), start=np.zeros(len(balance.motion)))


def _left(balance: Balance, sound: Array) -> tuple[float, float]:
    """Rows that count, and the share of the motion that no gains of the signals explain: the fewer rows of those that
    the log leaves as it is, with `sound` coefficients (s,), and with any gains."""
    left = []
    for columns in (
        _recorded(balance, tuple(balance.signals), sound)[:, None],
        np.hstack(list(balance.signals.values())),
    ):
        size = np.linalg.norm(columns, axis=0)
        columns = columns / np.where(size > 0, size, 1.0)
        left.append(balance.motion - columns @ np.linalg.lstsq(columns, balance.motion, rcond=1e-8)[0])
    rows = min(independent_rows(one) for one in left) * (1 - balance.taken / len(balance.motion))
    return max(rows, 1.0), float(left[1] @ left[1]) / float(balance.motion @ balance.motion)
