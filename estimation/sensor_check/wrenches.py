"""Whether each arm's wrench is of the right sign, axes, frame and unit: every way to read it is tried in the balances.

Divided by mass and by yaw inertia, a balance says that accelerations are wrenches times a gain, 1/m or 1/J, beside what
drags, offsets, slopes and first moments make, which is taken out of both sides. The gain is positive, and about what
the cart file says. A wrong sign asks for a negative mass, wrong axes explain less of the motion, and a wrong unit moves
the mass by its factor, which is weighed with how sure the file's is.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import product

import numpy as np

from cartgrasp.effects import CasterRealignment, Effect, ViscousDrag, WheelDragImbalance
from cartgrasp.errors import printable
from cartgrasp.frames import PLANAR, Array
from cartgrasp.logs import RunLog
from cartgrasp.model import CartModel
from cartgrasp.wheels import CASTER

from ..log_noise.log_noise import noise_floor
from ..weak_form.balances import Balances
from ..weak_form.band import NUISANCE_EFFECTS
from .evidence import UNEXPLAINED_FRACTION, gain_evidence, independent_rows, probabilities
from .suspicion import REFUSAL_PROBABILITY, REPORT_PROBABILITY, UNIT_REPORT_PROBABILITY, Suspicion
from .wrench_readings import RECORDED_WRENCH_UNITS, UNIT_ODDS, Mounting, mountings

WRENCH_CHECK_ROW_STEPS = 0.4, 0.2
"""The step (s) of rows of test functions, which are four times as long in all. Models of pushed carts hold below a
hertz or so; loads swing, handles give. The second step is for logs that are too short for the first."""
MIN_WRENCH_SPARE_ROWS = 16
"""Rows beside the columns that are taken out."""
LOG_MASS_STD, LOG_INERTIA_STD, SIDEWAYS_LOG_GAIN_STD = 0.5, 0.7, 0.1
"""Spreads of logarithms. The first is of a file's mass about the true one: 19 in 20 guesses are within a factor of 2.7.
The second is of its yaw inertia, beside what the mass is off by. The third is of the mass that is felt sideways against
the one felt ahead."""
MIN_SIGNAL_VARIANCE_RATIO = 2.0
"""Times the variance that white noise gives means over a row's step: of sixteen of them, in one case in a hundred."""
NEGLIGIBLE_DIRECTION_RATIO = 1e-8
"""Share of the largest below which smaller directions are rounding."""
MAX_CONTACT_DISTANCE = 5.0
"""m from {b}'s origin: nobody holds a cart there, but at about one metre: three hundred are millimetres."""
LEFT_OUT_FRACTION, LEFT_OUT_STARTS = 1 / 3, (0.0, 1 / 6, 1 / 3, 1 / 2, 2 / 3)
"""Share of what the cart did that lies in a stretch; where they begin."""
NO_OVERLAP = "poses and the wrenches of all arms come together nowhere for long enough"
WRENCH_FAULT_KINDS = ("sign", "axes", "frame", "unit")


@dataclass(frozen=True)
class Reading:
    """How the wrenches of some arms are read."""

    arms: tuple[int, ...]
    mounting: Mounting
    unit: tuple[str, str]
    odds: float

    @property
    def kinds(self) -> tuple[str, ...]:
        of_unit = ("unit",) if self.unit != ("N", "N·m") else ()
        return ((self.mounting.kind,) if self.mounting.kind else ()) + of_unit

    @property
    def taken(self) -> Array:
        """(3, 8)."""
        force, moment = RECORDED_WRENCH_UNITS[self.unit]
        return np.asarray(self.mounting.taken * np.array([[force], [force], [moment]]))


@dataclass(frozen=True)
class Balance:
    """Accelerations (k,) and signals (k, arms, 3, 8) of each component taken for fx, fy or tz, both beside what was
    taken out; how many columns that were."""

    motion: Array
    signals: Array
    taken_out: int

    def products(self) -> tuple[Array, Array, float]:
        """Signal by signal and by motion (r,) of each reading, and motion by motion."""
        k, arms = self.signals.shape[:2]
        flat, how = self.signals.reshape(k, -1), _as_read(arms)
        gram, seen = flat.T @ flat, flat.T @ self.motion
        return np.maximum(np.einsum("ri,ri->r", how @ gram, how), 0.0), how @ seen, float(self.motion @ self.motion)

    def rows(self, kept: np.ndarray) -> Balance:
        """Some rows alone."""
        taken_out = round(self.taken_out * kept.mean())
        return Balance(self.motion[kept], self.signals[kept], taken_out)

    def as_recorded(self) -> Array:
        """The sum (k,) of the arms' signals, as they are."""
        return np.asarray(np.einsum("kaij,ij->k", self.signals, mountings()[0].taken))

    def scatter(self) -> tuple[float, float]:
        """Rows that count as independent, and the share of the motion that no gains of all components explain."""
        sound = self.as_recorded()[:, None]
        whole = self.signals.reshape(len(self.motion), -1)
        left = [self.motion - basis @ (basis.T @ self.motion) for basis in (_orthogonal(sound), _orthogonal(whole))]
        rows = min(independent_rows(one) for one in left) * (1 - self.taken_out / len(self.motion))
        return max(rows, 1.0), max(float(left[1] @ left[1] / (self.motion @ self.motion)), UNEXPLAINED_FRACTION**2)


KnownBalances = tuple[Balance, Balance | None, Balance | None]


def wrench_suspicions(balances: Balances, cart: CartModel) -> tuple[Suspicion, ...]:
    """`sign`, `axes`, `frame` and `unit` of each arm."""
    return judged_wrenches(balances, cart)[0]


def judged_wrenches(balances: Balances, cart: CartModel) -> tuple[tuple[Suspicion, ...], str]:
    """Suspicions of wrenches, and why they can't be judged: "" where they can, or nobody pushes."""
    far = _far_contacts(balances)
    known = next((found for step in WRENCH_CHECK_ROW_STEPS if (found := balances_of(balances.every(step), cart))), None)
    if far or known is None:
        why = "the cart moves too little, or for too short a time" if len(balances.used) else NO_OVERLAP
        return far, why if balances.wrenches.arms and not far else ""
    readings = _readings(len(balances.wrenches.arms))
    every = [_posterior(one, readings, cart) for one in (known, *_leave_third_out(known))]
    posterior = max(every, key=lambda one: float(one[0]))
    zz, zy, yy = known[0].products()
    masses = zz / np.where(np.abs(zy) > NEGLIGIBLE_DIRECTION_RATIO * np.sqrt(zz * yy), zy, np.inf)
    told = []
    for i, name in enumerate(balances.wrenches.arms):
        wrong = [j for j, r in enumerate(readings) if i in r.arms]
        by_kind = {kind: [j for j in wrong if kind in readings[j].kinds] for kind in WRENCH_FAULT_KINDS}
        sums = {kind: float(posterior[own].sum()) for kind, own in by_kind.items()}
        for kind, probability in _reported_kinds(float(posterior[wrong].sum()), sums).items():
            most = max(by_kind[kind], key=lambda j: float(posterior[j]))
            factor, words = _words(kind, readings[most], (float(masses[0]), float(masses[most])), cart)
            told.append(Suspicion(kind, name, probability, factor, f"{printable(name)}: {words}"))
    return tuple(told), ""


def _posterior(known: KnownBalances, readings: Sequence[Reading], cart: CartModel) -> Array:
    """The probability (r,) of each reading."""
    (forward, sideways, turning), phi = known, cart.inertia.phi
    one = np.ones(len(readings))
    rows, floor = forward.scatter()
    usual = -math.log(phi[0]) * one
    log_evidence, log_gain = gain_evidence(forward.products(), rows, usual, LOG_MASS_STD, floor)
    for balance, ratio, spread in ((sideways, 1.0, SIDEWAYS_LOG_GAIN_STD), (turning, phi[0] / phi[3], LOG_INERTIA_STD)):
        if balance is not None:
            rows, floor = balance.scatter()
            products = balance.products()
            log_evidence = log_evidence + gain_evidence(products, rows, log_gain + math.log(ratio), spread, floor)[0]
    return probabilities(log_evidence, np.array([r.odds for r in readings]))


def _leave_third_out(known: KnownBalances) -> Iterator[KnownBalances]:
    """The balances without each of some stretches in which a third of what the cart did lies. A sensor that is set up
    wrongly is so in all of the log; what else acts for a while, such as somebody who pushes, is not."""
    done = np.cumsum(known[0].motion ** 2)
    for first in LEFT_OUT_STARTS:
        kept = (done < first * done[-1]) | (done > (first + LEFT_OUT_FRACTION) * done[-1])
        yield known[0].rows(kept), *(None if one is None else one.rows(kept) for one in known[1:])  # type: ignore[misc]


def _reported_kinds(whole: float, found: dict[str, float]) -> dict[str, float]:
    """The kinds worth a line. Where it is sure that something is wrong (`whole`), and not what, the likeliest stands
    for all."""
    likeliest = max(found, key=lambda kind: found[kind])
    if whole >= REFUSAL_PROBABILITY > found[likeliest]:
        return {likeliest: whole}
    least = {"unit": UNIT_REPORT_PROBABILITY}
    return {
        kind: probability for kind, probability in found.items() if probability >= least.get(kind, REPORT_PROBABILITY)
    }


def _words(kind: str, reading: Reading, masses: tuple[float, float], cart: CartModel) -> tuple[float | None, str]:
    """The factor, and what is told, of the masses (kg) as recorded and as read."""
    recorded, so = masses
    file = f"(the cart file says {cart.inertia.mass:.3g} kg)"
    if kind == "unit":
        force, moment = RECORDED_WRENCH_UNITS[reading.unit]
        words = (
            f"wrenches seem to be in {' and '.join(reading.unit)}: as recorded the mass would be {recorded:.3g} kg, so "
            f"it is {so:.3g} kg {file}; multiply forces by {force:.6g} and moments by {moment:.6g}, or mend the file's "
            "mass, or the unit of lengths"
        )
        return (force if force != 1.0 else moment), words
    if kind == "sign" and reading.mounting.taken[0, 0] > 0:
        words = f"{reading.mounting.words}: so wrenches fit how the cart turns; record what the arm does to the cart"
        return -1.0, words
    if kind == "sign":
        words = (
            f"{reading.mounting.words}: as recorded the motion asks for a mass of {recorded:.3g} kg, so for "
            f"{so:.3g} kg {file}; record what the arm does to the cart (or x runs backwards)"
        )
        return -1.0, words
    return None, f"{reading.mounting.words}: so wrenches fit the motion; turn the sensor's axes into the contact's"


@cache
def _readings(arms: int) -> tuple[Reading, ...]:
    """Every mounting in every unit, of all arms alike (as one hand set them up) and of each alone; the sound one
    first."""
    every = tuple(range(arms))
    groups = [(every, 1.0)] if arms == 1 else [(every, 0.5), *(((i,), 0.5 / arms) for i in every)]
    sound, si = mountings()[0], ("N", "N·m")
    found = [Reading((), sound, si, 1.0)]
    for (group, share), mounting, unit in product(groups, mountings(), RECORDED_WRENCH_UNITS):
        if mounting is not sound or unit != si:
            alike = 1 if unit[0] == "N" else sum(other[0] == unit[0] for other in RECORDED_WRENCH_UNITS)
            odds = share * mounting.odds * (1.0 if unit == si else UNIT_ODDS / alike)
            found.append(Reading(group, mounting, unit, odds))
    return tuple(found)


@cache
def _as_read(arms: int) -> Array:
    """What each reading takes of all arms' components (r, arms * 3 * 8)."""
    sound, readings = mountings()[0].taken, _readings(arms)
    found = np.array([[one.taken if i in one.arms else sound for i in range(arms)] for one in readings])
    return found.reshape(len(found), -1)


def balances_of(balances: Balances, cart: CartModel) -> KnownBalances | None:
    """Forward, sideways (of carts that may go so) and yaw (of those that may turn); None where nothing is told."""
    if not balances.wrenches.arms or not len(balances.used):
        return None
    free = cart.constraints.n_free
    signals, slopes = _signals(balances, cart), balances.residual(cart)[1]
    casters = (CasterRealignment(),) if any(wheel.kind == CASTER for wheel in cart.wheels) else ()
    taken = {effect.name for effect in cart.effects}
    imbalance = (WheelDragImbalance(),) if free > 1 else ()
    every: tuple[Effect, ...] = (ViscousDrag(), *NUISANCE_EFFECTS, *imbalance, *casters)
    more = [e for e in every if e.name not in taken]
    columns = [balances.columns(cart, e)[..., [not p.optional for p in e.parameters]] for e in more]
    whole = np.concatenate([slopes, *columns], axis=2)
    own = [0, 0, 3][:: 1 if free == 3 else 2] if free > 1 else [0]
    found = [_beside(whole[:, i], signals[:, i], column) for i, column in enumerate(own)]
    if found[0] is None:
        return None
    return found[0], found[1] if free == 3 else None, found[-1] if free > 1 else None


def _signals(balances: Balances, cart: CartModel) -> Array:
    """(k, f, arms, 3, 8): what each recorded component is in each balance, taken for fx, fy or tz."""
    wrenches, heading = balances.wrenches, balances.motion.pose[:, 2]
    c, s = np.cos(heading), np.sin(heading)
    spoken = wrenches.recorded * np.array([_has_signal(balances.log, name) for name in wrenches.arms])[:, None]
    fx, fy = spoken[..., 0], spoken[..., 1]
    recorded = np.concatenate([spoken, np.stack([c * fx + s * fy, c * fy - s * fx], axis=-1)], axis=-1)
    reduced = (cart.basis_b.T @ wrenches.grasps)[..., [*PLANAR]]
    return balances.integrated(np.einsum("anfi,anj->nfaij", reduced, recorded))


def _has_signal(log: RunLog, arm: str) -> np.ndarray:
    """Which components (6,) of an arm's wrench are more than white noise: of what is nothing else no log tells the
    sign, and chance would."""
    wrench = log.arms[arm].wrench
    wrench = wrench[np.isfinite(wrench).all(axis=1)]
    size = int(WRENCH_CHECK_ROW_STEPS[0] / float(np.median(np.diff(log.time))))
    count = len(wrench) // max(size, 1)
    if size < 2 or count < MIN_WRENCH_SPARE_ROWS:
        return np.ones(wrench.shape[1], dtype=bool)
    means = wrench[: count * size].reshape(count, size, -1).mean(axis=1)
    noise = np.array([noise_floor(column) for column in wrench.T])
    return np.asarray(means.var(axis=0) > MIN_SIGNAL_VARIANCE_RATIO * noise**2 / size)


def _beside(columns: Array, signals: Array, own: int) -> Balance | None:
    """What is left of one balance's acceleration, a column of (k, p), and signals (k, ...) beside all others; None
    where too little is."""
    basis = _orthogonal(np.delete(columns, own, axis=1))
    k, taken = basis.shape
    if k < taken + MIN_WRENCH_SPARE_ROWS:
        return None
    motion, flat = columns[:, own], signals.reshape(k, -1)
    left, beside = motion - basis @ (basis.T @ motion), flat - basis @ (basis.T @ flat)
    if (
        left @ left <= NEGLIGIBLE_DIRECTION_RATIO * (motion @ motion)
        or not (beside**2).sum() > NEGLIGIBLE_DIRECTION_RATIO * (flat**2).sum()
    ):
        return None
    return Balance(left, beside.reshape(signals.shape), taken)


def _orthogonal(columns: Array) -> Array:
    """A basis (k, q) of columns (k, p), but for those that are nothing."""
    sizes = np.linalg.norm(columns, axis=0)
    live = sizes > NEGLIGIBLE_DIRECTION_RATIO * sizes.max(initial=0.0)
    left, values, _ = np.linalg.svd(columns[:, live] / sizes[live], full_matrices=False)
    return np.asarray(left[:, values > NEGLIGIBLE_DIRECTION_RATIO * values.max(initial=0.0)])


def _far_contacts(balances: Balances) -> tuple[Suspicion, ...]:
    """`unit` of contact points that nobody reaches."""
    told = []
    for name, arm in balances.log.arms.items():
        whole = arm.contact[np.isfinite(arm.contact).all(axis=1)]
        reach = float(np.median(np.linalg.norm(whole, axis=1))) if len(whole) else 0.0
        if reach > MAX_CONTACT_DISTANCE:
            unit, factor = ("mm", 0.001) if reach > 300 else ("cm", 0.01)
            words = (
                f"{printable(name)}: contacts are {reach:.3g} m from the cart's origin, they seem to be in {unit}: "
                f"multiply px, py and pz by {factor:g}"
            )
            told.append(Suspicion("unit", name, 0.99, factor, words))
    return tuple(told)
