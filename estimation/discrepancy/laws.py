"""What a log may follow that no effect of the vocabulary makes: forces, drags and moments as linear functions of a few
columns over one variable. They are rivals of the effects in the same comparison."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from cartgrasp.frames import Array
from cartgrasp.model import CartModel
from cartgrasp.wheels import FIXED

from ..weak_form.balances import THIN, Balances
from .course import ROLLING, Course

AT_HANDS = "at the hands"
FORCE_STD, MOMENT_STD = 10.0, 3.0
"""N, N·m: what pushes carts about."""


@dataclass(frozen=True)
class Place:
    """Where a law acts: as a moment, or as a forward force at a `lever` (m) to the left of {b}'s x: a wheel's, which
    rolls another way than {b}'s origin, or that of the hands, whose sensors may be what follows a law."""

    is_moment: bool = False
    lever: float = 0.0
    is_wheel: bool = False

    @property
    def shift(self) -> float:
        """By how many metres for each rad less than {b}'s origin goes what is there."""
        return self.lever if self.is_wheel else 0.0

    @property
    def words(self) -> str:
        if self.is_moment:
            return "moment"
        if self.is_wheel:
            return f"force at the wheel at y = {self.lever:g} m"
        return f"force {AT_HANDS}" if self.lever else "force"


@dataclass(frozen=True, eq=False)
class Law:
    """`shape` gives columns (n, q) of a force, or of a moment, over a course."""

    name: str
    form: str
    place: Place
    shape: Callable[[Course], Array]
    size: int
    period: float | None = None
    unit: str = ""
    variable: str = ""

    @property
    def is_moment(self) -> bool:
        return self.place.is_moment

    @property
    def key(self) -> str:
        return f"law: {self.name}, {self.form}" + (f", {self.period:.3g} {self.unit}" if self.period else "")

    @property
    def words(self) -> str:
        """For people."""
        period = f" with a period of {self.period:.3g} {self.unit}" if self.period else ""
        return f"{'yaw moment' if self.is_moment else 'forward force'}: {self.name}{period} ({self.form})"

    @property
    def std(self) -> Array:
        return np.full(self.size, MOMENT_STD if self.is_moment else FORCE_STD)

    def columns(self, balances: Balances, cart: CartModel) -> Array:
        """Raw (k, c, q)."""
        return self.over(balances.integrated(self.shape(_thin(Course.along(balances.motion)))), balances, cart)

    def over(self, integrated: Array, balances: Balances, cart: CartModel) -> Array:
        """Columns (k, c, q) in all balances, of a signal against the test functions (k, q)."""
        found = np.zeros((len(integrated), balances.n_balances(cart), integrated.shape[1]))
        last = cart.constraints.n_free - 1
        found[:, last if self.is_moment else 0] = integrated
        if self.place.lever:
            found[:, last] = -self.place.lever * integrated
        return found


def _thin(course: Course) -> Course:
    return course.at(np.arange(0, len(course.time), THIN))


def _sign(course: Course) -> Array:
    return np.asarray(np.tanh(course.speed / ROLLING))


def smooth_laws(turns: bool, hands: float = 0.0) -> list[Law]:
    """Of what varies slowly with one variable; forces, too, at a lever of the hands' (m; none: 0)."""
    found = [
        Law(variable, form, Place(is_moment), shape, size)
        for variable, form, is_moment, size, shape in (ON_ALL + ON_TURNS if turns else ON_ALL)
    ]
    forces = [law for law in found if hands and not law.is_moment]
    return found + [replace(law, form=f"{law.form} {AT_HANDS}", place=Place(lever=hands)) for law in forces]


def _setting_in(c: Course) -> Array:
    """Drag that grows from a quarter, half and three quarters of the largest speed on."""
    most = abs(c.speed).max()
    return _columns(*(_sign(c) * np.maximum(abs(c.speed) - share * most, 0) for share in (0.25, 0.5, 0.75)))


def _warming(c: Course) -> Array:
    return _columns(_sign(c), c.speed * c.time / 60, _sign(c) * c.time / 60)


def _round(c: Course, times: int = 1) -> tuple[Array, Array]:
    return np.cos(times * c.heading), np.sin(times * c.heading)


def _field(c: Course) -> Array:
    """A force of the world that changes from place to place."""
    return _columns(*(along * at for along in _round(c) for at in (c.x, c.y)))


def _columns(*signals: Array) -> Array:
    return np.column_stack(signals)


ON_ALL: tuple[tuple[str, str, bool, int, Callable[[Course], Array]], ...] = (
    ("speed", "cubic drag", False, 1, lambda c: _columns(c.speed**3)),
    ("speed", "drag that sets in", False, 3, _setting_in),
    ("time", "drift", False, 1, lambda c: _columns(c.time / 60)),
    ("time", "drag that warms", False, 3, _warming),
)
ON_TURNS: tuple[tuple[str, str, bool, int, Callable[[Course], Array]], ...] = (
    ("heading", "force", False, 4, lambda c: _columns(*_round(c), *_round(c, 2))),
    ("heading", "drag", False, 2, lambda c: _columns(*(_sign(c) * one for one in _round(c, 2)))),
    ("heading", "drag in proportion to speed", False, 2, lambda c: _columns(*(c.speed * one for one in _round(c)))),
    ("heading", "moment", True, 2, lambda c: _columns(*_round(c))),
    ("yaw rate", "drag", False, 1, lambda c: _columns(_sign(c) * abs(c.yaw_rate))),
    ("yaw rate", "moment", True, 1, lambda c: _columns(c.yaw_rate * abs(c.yaw_rate))),
    ("time", "wind", False, 2, lambda c: _columns(*(one * c.time / 60 for one in _round(c)))),
    ("place", "field", False, 4, _field),
    ("place", "drag", False, 3, lambda c: _columns(_sign(c), _sign(c) * c.x, _sign(c) * c.y)),
)
"""Variable, form, whether it is a moment, and how many columns over a course."""

PERIODS = (("time", "s", 0.25, 4.0), ("way", "m", 0.25, 2.5), ("x", "m", 0.3, 2.0), ("y", "m", 0.3, 2.0))
"""Variables, and between which periods a law is looked for."""
OVERSAMPLED = 16
"""Points of a Fourier transform's grid in the shortest period."""
KNOWN, LIKELY = 24, 40
"""Periods of a scan of which the information is worked out, and then the gain."""


def periodic(variable: str, unit: str, period: float, harmonics: int, place: Place) -> Law:
    def shape(course: Course) -> Array:
        phase = 2 * np.pi * (getattr(course, variable) - place.shift * course.heading) / period
        along = {"x": np.cos(course.heading), "y": np.sin(course.heading)}.get(variable, np.ones_like(phase))
        return np.column_stack([along * f(k * phase) for k in range(1, harmonics + 1) for f in (np.cos, np.sin)])

    name = "place" if variable in "xy" else {"way": "travelled distance"}.get(variable, variable)
    form = place.words + (f" of {harmonics} harmonics" if harmonics > 1 else "")
    return Law(name, form, place, shape, 2 * harmonics, period, unit, variable)


@dataclass(frozen=True, eq=False)
class Scan:
    """Of periodic laws of one form between two periods, as many as `frequencies` (v,) of the variable."""

    variable: str
    unit: str
    place: Place
    frequencies: Array

    def laws(self, chosen: np.ndarray) -> list[Law]:
        return [periodic(self.variable, self.unit, float(1 / f), 1, self.place) for f in self.frequencies[chosen]]

    def power(self, courses: Sequence[Course], pulls: Sequence[Array]) -> Array:
        """How much pulls (n, f) of the residual on forces and moments along the courses go with each frequency (v,):
        by a fast Fourier transform of pulls over the variable, each shared by the two nearest of its grid's points."""
        step = 1 / (OVERSAMPLED * self.frequencies[-1])
        first = min(float(self.of(c).min()) for c in courses)
        count = round(1 / (step * float(np.diff(self.frequencies[:2])[0])))
        total = np.zeros(count)
        for course, pull in zip(courses, pulls, strict=True):
            last = pull.shape[1] - 1
            weight = pull[:, last] if self.place.is_moment else pull[:, 0]
            if self.place.lever:
                weight = weight - self.place.lever * pull[:, last]
            at = (self.of(course) - first) / step
            low = np.floor(at).astype(int)
            signal = weight * {"x": np.cos(course.heading), "y": np.sin(course.heading)}.get(self.variable, 1.0)
            for where, share in ((low, 1 - (at - low)), (low + 1, at - low)):
                total += np.bincount(where % count, weights=signal * share, minlength=count)
        found = np.abs(np.fft.rfft(total)) ** 2
        return np.asarray(np.interp(self.frequencies, np.fft.rfftfreq(count, step), found), dtype=float)

    def of(self, course: Course) -> Array:
        return np.asarray(getattr(course, self.variable) - self.place.shift * course.heading)


def scans(courses: Sequence[Course], cart: CartModel, hands: float = 0.0) -> list[Scan]:
    """Those that a motion allows: periods of which it saw two at least; with a lever of the hands' (m; none: 0)."""
    found, turns = [], cart.constraints.n_free > 1
    levers = [wheel.y for wheel in cart.wheels if wheel.kind == FIXED and wheel.y] if turns else []
    for variable, unit, least, most in PERIODS:
        span = max(float(np.ptp(getattr(c, variable))) for c in courses)
        if span < 2 * least or (variable in "xy" and not turns):
            continue
        frequencies = np.arange(1 / min(most, span / 2), 1 / least, 0.4 / span)
        places = [Place(), Place(is_moment=True)] if turns else [Place()]
        places += [Place(lever=hands)] if hands else []
        places += [Place(lever=lever, is_wheel=True) for lever in levers if variable == "way"]
        found += [Scan(variable, unit, place, frequencies) for place in places if len(frequencies) > 1]
    return found


def scanned(
    logs: Sequence[Balances],
    cart: CartModel,
    pulls: Sequence[Array],
    gain: Callable[[Array, Array], Array],
    whitened: Callable[[Sequence[Array]], Array],
    hands: float = 0.0,
) -> tuple[list[tuple[float, Law]], int]:
    """The best periods of one harmonic, each with its gain, and of how many: of each scan those with most power for
    the information that whitened columns have."""
    found, count = list[tuple[float, Law]](), 0
    courses = [Course.along(balances.motion) for balances in logs]
    thin = [_thin(course) for course in courses]
    for scan in scans(courses, cart, hands):
        v = len(scan.frequencies)
        count += v
        known = np.unique(np.linspace(0, v - 1, KNOWN).astype(int))
        own = _together(logs, cart, thin, scan.laws(known), whitened)
        information = np.interp(np.arange(v), known, (own**2).sum(axis=(1, 2, 3)))
        likely = scan.power(courses, pulls) / np.maximum(information, 1e-300)
        laws = scan.laws(np.argsort(-likely)[:LIKELY])
        gains = gain(_together(logs, cart, thin, laws, whitened), laws[0].std)
        found += zip(gains.tolist(), laws, strict=True)
    return found, count


def _together(
    logs: Sequence[Balances],
    cart: CartModel,
    courses: Sequence[Course],
    laws: Sequence[Law],
    whitened: Callable[[Sequence[Array]], Array],
) -> Array:
    """Whitened columns (v, k, c, 2) of laws of one form."""
    raw = []
    for balances, course in zip(logs, courses, strict=True):
        integrated = np.concatenate([balances.integrated(law.shape(course)) for law in laws], axis=1)
        raw.append(laws[0].over(integrated, balances, cart))
    white = whitened(raw)
    k, c, _ = white.shape
    return np.asarray(np.moveaxis(white.reshape(k, c, len(laws), 2), 2, 0))
