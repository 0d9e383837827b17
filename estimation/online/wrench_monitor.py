"""Whether wrenches mean what they say: their power against what the first guess would take on the same way, which tells
signs and units. A cart takes power to be sped up and gives some back, never the other way round, and about as much as
it is guessed to, as far as its file knows its mass."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from cartgrasp.model import CartModel
from cartgrasp.rigid_body import mass_matrix_b

from ..noise import FilterNoise
from ..prior import Prior
from ..sensor_check.evidence import probabilities
from ..sensor_check.suspicion import REFUSAL_PROBABILITY, Suspicion
from ..sensor_check.wrench_readings import COMMON_MOUNTING_ODDS
from ..standstill import HALF_TRACK
from .competing_explanations import MIN_EVIDENCE_ROWS, RETAINED_PROBABILITY, CompetingExplanations
from .disturbance.observer import PUSH_FORCE_STD
from .power_balance import PowerBalance
from .sensor_block import SensorBlock, wrapped
from .turned_signs import ForceRow, TurnedSigns

FORCE_UNITS = {"N": 1.0, "lbf": 4.4482216, "kgf": 9.80665, "kN": 1000.0}
"""N in each unit."""
FRICTION_LOG_STD = math.log(2.0)
"""Standard deviation of the logarithm of the friction as guessed, beside that of the mass."""
UNKNOWN_LOG_VARIANCE = 1e6
"""Variance of a logarithm that is not known."""
MIN_MASS_LOG_STD, MIN_POWER_RATIO = 0.02, 1e-9
"""Deviation of a mass that is known, as scales are; and a share that is none."""
MIN_CONCLUSIONS_IN_A_ROW = 4
"""Conclusions in a row, before a unit of force is told: what a gentle run says of the mass wanders for a while."""
FORCE_UNIT_ODDS = 0.003
"""Odds of each unit of force: rather less than of a log, as it is asked again and again, and a cart may be three times
as heavy as it was guessed to be."""


class WrenchMonitor:
    """Holds what arms gave against what a cart, as first guessed with a prior, takes."""

    def __init__(self, cart: CartModel, noise: FilterNoise, prior: Prior) -> None:
        self._cart = cart
        self._spread = math.log1p(float(prior.deviations(cart)[0]) / cart.inertia.mass)
        self._mass_matrix = mass_matrix_b(cart.inertia.phi)
        self._along, self._basis = cart.rolling.along_b, cart.basis_b
        push = np.square(PUSH_FORCE_STD * noise.wrench_scale(cart))
        self._signs, self._power = TurnedSigns.of(0, push), CompetingExplanations(())
        self._sure = 0  # conclusions in a row that speak for another unit of force

    def compare(self, first: SensorBlock, middle: SensorBlock, last: SensorBlock) -> None:
        """Adds what each arm's recorded wrench gave, and inertia and friction of the first guess take on the same way;
        nothing where a wrench is not known."""
        if first.wrenches_b is None or middle.wrenches_b is None or last.wrenches_b is None:
            return
        before, after = _twist(first, middle), _twist(middle, last)
        step = 0.5 * (last.time - first.time)
        twist = np.array([0.5 * (old + new) for old, new in zip(before, after, strict=True)])
        rate = np.array([(new - old) / step for old, new in zip(before, after, strict=True)])
        nu = self._along @ twist
        state = self._cart.state((*middle.place, middle.headings[0]), nu)
        needed = self._cart.required_wrench(state, self._along @ rate, time=middle.time)
        momentum_rate = self._mass_matrix @ rate
        inertia, inertial = momentum_rate @ self._basis, float(twist @ momentum_rate)
        arms = zip(first.wrenches_b, middle.wrenches_b, last.wrenches_b, strict=False)
        given = np.array([(np.add(a, c) + 4.0 * np.array(b)) / 6.0 for a, b, c in arms])
        powers = np.array([inertial, float(needed @ nu) - inertial, *given @ twist])
        u, w, turning = twist.tolist()
        speed = math.hypot(u, w) + HALF_TRACK * abs(turning)
        take, give = np.array([inertia, needed - inertia]), given @ self._basis
        if len(given) != len(self._signs.signs):
            self._signs, self._power = TurnedSigns.of(len(given), self._signs.push), CompetingExplanations(())
        self._signs = self._signs.and_then(ForceRow(powers, speed * take, speed * give, speed))
        self._power = self._power.and_then((), float(powers @ powers))

    def judge(self) -> None:
        """Looks for signs that have turned."""
        self._signs = self._signs.judged()

    def suspicions(self, arms: Sequence[str], told: Sequence[Suspicion]) -> Iterator[Suspicion]:
        """By what the first guess would take for inertia and for friction, where some are `told` by now. Its sign tells
        of that of wrenches, whatever the sizes; the sizes tell of the unit."""
        products, rows = self._signs.all_rows
        powers = PowerBalance.of(products)
        guessed, pull = powers.ii + 2.0 * powers.both + powers.ff, powers.inertial + powers.friction
        if rows < MIN_EVIDENCE_ROWS or not guessed > 0 or not powers.given > 0:
            return
        arms = arms[: len(self._signs.signs)]
        yield from self._of_turned_signs(arms)
        shares = [powers.left(sign, self._power.rows) for sign in (1.0, -1.0)]
        if len(arms) > 1:
            shares += [PowerBalance.of(products, k).left(1.0, self._power.rows) for k in range(len(arms))]
        odds = np.array([1.0, *[COMMON_MOUNTING_ODDS] * (len(shares) - 1)])
        _, *wrong = probabilities(
            np.array(CompetingExplanations(tuple(shares), 1.0, 1.0 / self._power.rows).evidence), odds
        ).tolist()
        if sum(wrong) > RETAINED_PROBABILITY:  # the likeliest stands for all
            where = ("wrench", *arms)[wrong.index(max(wrong))]
            yield _wrong_sign(where, sum(wrong))
            if where != "wrench":
                return
        scales = np.array(self._logs_of_units(powers.shares(math.copysign(1.0, pull), rows)))
        sound, *units = probabilities(scales, np.array([1.0, *[FORCE_UNIT_ODDS] * (len(FORCE_UNITS) - 1)])).tolist()
        self._sure = self._sure + 1 if sound < 1.0 - REFUSAL_PROBABILITY else 0
        stays = any(one.kind == "unit" and one.where == "wrench" for one in told)
        if self._sure >= MIN_CONCLUSIONS_IN_A_ROW or (stays and sound < 1.0 - RETAINED_PROBABILITY):
            name = list(FORCE_UNITS)[1 + units.index(max(units))]
            size = f"{abs(pull) / guessed:.2g} times what the first guess takes"
            words = f"wrenches are {size}: they seem to be in {name}, not N"
            yield Suspicion("unit", "wrench", sum(units), FORCE_UNITS[name], words)

    def _of_turned_signs(self, arms: Sequence[str]) -> Iterator[Suspicion]:
        turned = [arm for arm, sign in zip(arms, self._signs.signs.tolist(), strict=True) if sign < 0.0]
        for where in ["wrench"] if len(turned) == len(arms) else turned:
            yield _wrong_sign(where, self._signs.probability)

    def _logs_of_units(self, shares: tuple[tuple[float, float], ...]) -> list[float]:
        """Logarithms of likelihoods, by the shares of `PowerBalance`. Friction grows with the mass: by as much as the
        guess of that is off, both are."""
        (moved, moved_by), (rubbed, rubbed_by) = shares
        of_mass = self._spread**2 + MIN_MASS_LOG_STD**2
        first, last = of_mass + UNKNOWN_LOG_VARIANCE, of_mass + UNKNOWN_LOG_VARIANCE
        if moved > MIN_POWER_RATIO:
            first = of_mass + min((moved_by / moved), UNKNOWN_LOG_VARIANCE) ** 2
        if rubbed > MIN_POWER_RATIO:
            last = of_mass + FRICTION_LOG_STD**2 + min(rubbed_by / rubbed, UNKNOWN_LOG_VARIANCE) ** 2
        size, found = first * last - of_mass**2, []
        for unit in FORCE_UNITS.values():
            x, y = (math.log(share * unit) if share > MIN_POWER_RATIO else 0.0 for share in (moved, rubbed))
            found.append(-0.5 * (last * x * x - 2.0 * of_mass * x * y + first * y * y) / size)
        return found


def _wrong_sign(where: str, probability: float) -> Suspicion:
    words = "wrenches work against the cart: they are its own on the hands, or their sign is reversed"
    of_one = f"{where}: its wrench works against the cart while others push: its sign is reversed"
    return Suspicion("sign", where, probability, -1.0, words if where == "wrench" else of_one)


def _twist(first: SensorBlock, last: SensorBlock) -> tuple[float, float, float]:
    """(u, w, r) of {b}, from poses alone."""
    span, x, y = last.time - first.time, last.place[0] - first.place[0], last.place[1] - first.place[1]
    turned = wrapped(last.headings[0] - first.headings[0])
    cosine, sine = math.cos(first.headings[0] + 0.5 * turned), math.sin(first.headings[0] + 0.5 * turned)
    return (cosine * x + sine * y) / span, (cosine * y - sine * x) / span, turned / span
