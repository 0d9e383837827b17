"""Up to which frequency a model foretells a log's motion: as far as its mass is the same as in narrower bands.

Regressed force on acceleration, a mass comes out too small where the acceleration has a share that no wrench made (a
rider leans, hands give); acceleration on force, too large (Frisch, 1934): between the two lies what can't be known. The
share is largest at high frequencies, so a mass that is wrong for it changes with the band, which is Hausman's test
(1978) of a fit that uses more against one that assumes less.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from cartgrasp.effects import DirectionalDrag, Effect, FloorSlope, ForceBias, QuadraticDrag, RollingResistance
from cartgrasp.frames import Array
from cartgrasp.inertia import N_PHI
from cartgrasp.model import CartModel

from .balances import Balances
from .integrals import SPLINE_SUPPORT
from .motion import KNOT_STEPS
from .rows import wrench_noise

ROW_STEPS = (0.025, 0.05, 0.1, 0.2, 0.4, 0.8, 1.6)
"""Steps (s) of the test functions that are tried, but for those that are finer than the motion is known (`KNOT_STEPS`).
Half of the inverse is the band's upper end (Hz)."""
BAND_MASS_SIGMAS, BAND_MASS_RATIO = 3.0, 0.05
"""Standard deviations of a narrower band's mass, and share of it, from which on it is another."""
MIN_SPARE_ROWS = 12
"""Fewest rows beyond one for each column."""
NEWEY_WEST_LAGS = 8
"""Rows over which residuals may be correlated (Newey and West, 1987)."""
NUISANCE_EFFECTS: tuple[Effect, ...] = (
    RollingResistance(),
    QuadraticDrag(),
    DirectionalDrag(),
    ForceBias(),
    FloorSlope(),
)
"""What a residual is made of that says nothing about the mass."""
INERTIAL_EFFECTS = ("payload_change", "load_slosh")
"""Effects that change how much a push moves a cart."""
MIN_COLUMN_RATIO = 1e-6
ALL_ROWS = slice(None)
COMPARABLE_STD_RATIO = 2.0
"""Multiple of the least deviation that counts as good as it: that of a dozen rows is told to about a factor of two
itself."""
MAX_MASS_STD_RATIO = 0.25
"""Largest scatter, as a share of the mass: with a larger one, a band says nothing of it."""


@dataclass(frozen=True)
class Band:
    """Step (s) of a log's test functions; the mass there (kg), its scatter, half of its two-way bracket, and as much of
    that as the noise of the motion's sensors makes; the sum of squares of the acceleration that tells it."""

    row_step: float
    mass: float
    std: float
    bracket: float
    of_noise: float = 0.0
    energy: float = 1.0

    @property
    def open_share(self) -> float:
        """Half of the bracket that no sensor's noise explains, as a share of the mass."""
        return max(self.bracket - self.of_noise, 0.0) / self.mass

    @property
    def middle(self) -> float:
        """Middle of the two-way bracket (kg)."""
        return self.mass + self.bracket

    @property
    def deviation(self) -> float:
        """Deviation of the mass (kg): its scatter, half of the bracket, and by how much bands may differ that agree."""
        return float(np.linalg.norm([self.std, self.bracket, BAND_MASS_RATIO * self.mass]))

    @property
    def share(self) -> float:
        """Deviation as a share of the mass."""
        return self.deviation / self.mass

    @property
    def spread(self) -> float:
        """Scatter and half of the bracket, as a share of the mass."""
        return float(np.hypot(self.std, self.bracket)) / self.mass

    def agrees(self, narrower: Band) -> bool:
        """Whether the mass is that of a narrower band."""
        return abs(self.mass - narrower.mass) < max(BAND_MASS_SIGMAS * narrower.std, BAND_MASS_RATIO * narrower.mass)


def bands(balances: Balances, cart: CartModel, guess: CartModel | None = None) -> list[Band]:
    """Bands of a log whose wrenches say something about the mass, with a cart's structure; the widest first. Inertial
    effects that a first `guess` does not have are left as they are."""
    span = float(balances.motion.time[-1] - balances.motion.time[0])
    finest = 2 * KNOT_STEPS * balances.motion.step * (1 - 1e-6)
    fit = (step for step in ROW_STEPS if finest <= step < span / (MIN_SPARE_ROWS + SPLINE_SUPPORT))
    steps = [step for step in fit if balances.wrenches.arms]
    found = (band_in(balances.every(step), cart, guess or cart) for step in steps)
    return [band for band in found if band is not None]


def is_narrower(band: Band, balances: Balances) -> bool:
    """Whether a band is narrower than that of a log's rows."""
    return round(band.row_step / balances.row_step) > 1


def consistent(known: list[Band]) -> Band | None:
    """The widest band in which the model foretells the motion: with the mass of all narrower ones, told as well as in
    any, for a band in which something else moves the cart says little. None of none."""
    return _told_as_well(known, lambda band: band.share)


def sharp(known: list[Band]) -> Band | None:
    """The band as in `consistent`, where nothing but the mass is asked for: bands that agree differ by their spread
    alone."""
    return _told_as_well(known, lambda band: band.spread)


def _told_as_well(known: list[Band], unsure: Callable[[Band], float]) -> Band | None:
    steady = [band for i, band in enumerate(known) if all(map(band.agrees, known[i + 1 :]))]
    least = min(map(unsure, steady), default=0.0)
    return next((band for band in steady if unsure(band) <= COMPARABLE_STD_RATIO * least), None)


def pooled(known: Sequence[tuple[Band, float]]) -> float:
    """The mean of a share of each log's band, as a fit to all of them weighs logs, whose masses are wrong alike."""
    total = sum(band.energy for band, _ in known)
    return sum(band.energy * share for band, share in known) / total if known else 0.0


def band_in(balances: Balances, cart: CartModel, guess: CartModel, kept: np.ndarray | slice = ALL_ROWS) -> Band | None:
    """Band of the rows' own test functions, from rows that are kept (k,); None where they don't tell the mass."""
    left, slopes = (rows[kept] for rows in balances.beside(None).residual(cart))
    taken = {effect.name for effect in cart.effects}
    rich = [balances.columns(cart, e)[kept, 0] for e in NUISANCE_EFFECTS if e.name not in taken]
    known = {effect.key for effect in guess.effects}
    loose = [e.key in known or e.name not in INERTIAL_EFFECTS for e in cart.effects for _ in e.parameters]
    own = slopes[:, 0, np.array([True] * N_PHI + loose)]
    others = np.column_stack([own[:, 1:], *rich])
    acceleration, force = own[:, 0], left[:, 0] + cart.inertia.mass * own[:, 0]
    sizes = np.linalg.norm(others, axis=0)
    others = others[:, sizes > MIN_COLUMN_RATIO * sizes.max(initial=0.0)]
    if len(force) < MIN_SPARE_ROWS or not (np.abs(force) > 0).any() or not (np.abs(acceleration) > 0).any():
        return None
    basis = _orthogonal(others)
    if len(force) < MIN_SPARE_ROWS + basis.shape[1]:
        return None
    x, y = (signal - basis @ (basis.T @ signal) for signal in (acceleration, force))
    size = float(x @ x)
    mass = float(x @ y) / size
    rest = y - mass * x
    known = wrench_noise(balances, cart)[0] ** 2 * balances.overlap(0, 0)
    excess = max(float(rest @ rest) / (len(rest) - basis.shape[1] - 1) - known, 0.0) * len(rest)
    moments = x * rest
    scatter = float(moments @ moments)
    for lag in range(1, min(NEWEY_WEST_LAGS, len(moments) // 4) + 1):
        scatter += 2 * (1 - lag / (NEWEY_WEST_LAGS + 1)) * float(moments[lag:] @ moments[:-lag])
    std = float(np.sqrt(max(scatter, float(moments @ moments) / 4))) / size
    if std > MAX_MASS_STD_RATIO * mass:
        return None
    noise = acceleration_noise(balances) ** 2 * len(rest)
    return Band(balances.row_step, mass, std, excess / (2 * mass * size), mass * noise / (2 * size), size)


def acceleration_noise(balances: Balances) -> float:
    """Standard deviation (m/s) of a row of forward acceleration, by the noise of the motion's sensors."""
    density, derivative = balances.motion.noise.density
    return float(density[0] * balances.overlap(2 - derivative, 0) ** 0.5)


def _orthogonal(columns: Array) -> Array:
    """A basis (k, r) of the columns' span."""
    unit = columns / np.maximum(np.linalg.norm(columns, axis=0), 1e-300)
    left, values, _ = np.linalg.svd(unit, full_matrices=False)
    return np.asarray(left[:, values > 1e-4 * values.max(initial=1.0)])
