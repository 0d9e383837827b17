"""Whitened rows of a log: balances whose noise is as the sensors' own is known to be, up to a scale per balance."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import product
from typing import NamedTuple

import numpy as np
from scipy.linalg import cholesky_banded
from scipy.ndimage import maximum_filter1d

from cartgrasp.effects import Effect, ViscousDrag
from cartgrasp.effects.effect import Gate
from cartgrasp.frames import Array
from cartgrasp.model import CartModel

from ..log_noise.log_noise import MAD_TO_STD
from ..standstill import HALF_TRACK
from .balances import Balances
from .integrals import GRID_STRIDE, SPLINE_SUPPORT
from .standstill_forces import FRICTION_COEFFICIENT, GRAVITY, holding_forces, reversal_drag_errors
from .whitening import Whitening
from .wrenches import Densities

BODY_FORM_ERROR_RATIO, EFFECT_FORM_ERROR_RATIO = 0.01, 0.1
"""Errors of a body's form, as a share of the root mean square wrench, and of effects' forms, as a share of what they
give. Neighbours share them."""
DRY_FRICTION_SPEED, CASTER_SWING_DISTANCE = 0.05, 0.2
"""Speed (m/s) below which the paper learns nothing either; distance (m) of some four usual trails."""
CASTER_WEIGHT_FRACTION = 0.5
"""Share of a cart's weight that casters carry where none are listed."""
SOFT_EDGE_WIDTH, PUSH_RISE_FRACTION, LOAD_ONSET_TIME = 0.1, 0.2, 0.1
"""Width (m) of a wheel's print and a carpet's rim; share of a push's duration in which it rises. Time (s) in which a
load is put on."""
POISED_YAW_RATE_SIGMAS = 10.0, 3.0, 1.0
"""Standard deviations of the yaw rate by which poised casters may be off."""
MAX_POISED_TIME = 1.0
"""Time (s) for which a caster may stay on its turning point when the others swing round: the cart turns under it."""
PRIOR_FRICTION_ROWS = 4.0
"""Rows near standstill that count as if friction were as wrong there as it may be."""
MAX_NOISE_CORRELATION_TIME = 0.15
"""Longest memory (s) of sensors' noise: what is remembered for longer is what a model lacks."""
HUBER_SIGMAS = 2.0
"""Standard deviations: what is farther off counts as if it were that far."""
MAX_NOISE_SCALE = 30.0
"""Largest loudness, in multiples of that from sample to sample: white noise that an amplifier passes up to a Hertz or
so."""
BISECTIONS = 12
MIN_EXCESS_NOISE, MIN_FORM_ERROR_RATIO = 1e-6, 0.02
"""Smallest white noise beside the sensors', and smallest share of what forms may be wrong by."""
MIN_FORCE_DENSITY, MIN_VELOCITY_DENSITY = 1e-4, 1e-6
"""Smallest densities (N/√Hz, N·m/√Hz; m/√Hz): they keep logs without any noise solvable."""


class Noise(NamedTuple):
    """White noise of the sensors in balances that go together: density of the wrenches' (b, b), and root of the density
    of the motion's (b,), with the order of the test functions' derivative through which it comes."""

    wrench: Array
    motion: Array
    order: int

    @property
    def apart(self) -> tuple[Noise, ...]:
        """The noise of each balance for itself."""
        each = [slice(i, i + 1) for i in range(len(self.motion))]
        return tuple(Noise(self.wrench[own, own], self.motion[own], self.order) for own in each)


@dataclass(frozen=True, eq=False)
class Errors:
    """Errors of a log's rows: the sensors' noise in the free directions and across, and what may hold a cart that
    stands (n, f). `friction` (n, f) is what the model's dry friction may be off by at most near standstill, `forms` (n,
    f) its forms everywhere."""

    balances: Balances
    forces: tuple[Noise, ...]
    across: tuple[Noise, ...]
    held: Array
    friction: Array
    forms: Array

    @classmethod
    def of(cls, balances: Balances, cart: CartModel, compares: bool = False) -> Errors:
        """`cart` tells how much of the motion's noise a balance takes in. Where models are compared, balances go
        together (a force sensor's noise at a lever is a moment, too), and nothing is certain at edges of what comes and
        goes; for a fit, balances are believed to be independent."""
        moved, order = motion_noise(balances, cart)
        together, across = Noise(wrench_covariance(balances, cart), moved, order), list[Noise]()
        if balances.motion.across is not None:
            x, _, heading = balances.motion.noise.pose_density
            turned = heading * np.sqrt((balances.motion.speed**2).mean())  # what goes ahead seems to go aside
            across.append(Noise(np.array([[MIN_VELOCITY_DENSITY**2 + turned**2]]), np.array([x]), 1))
        held, friction, forms = model_error(balances, cart)
        edges = edge_error(balances, cart)
        if compares:
            return cls(balances, (together,), tuple(across), np.hypot(held, edges), friction, forms)
        return cls(balances, together.apart, tuple(across), held, friction, np.hypot(forms, edges))

    @property
    def noise(self) -> tuple[Noise, ...]:
        return self.forces + self.across

    @cached_property
    def white(self) -> Array:
        """Variance (c,) that the sensors' noise gives to a row."""
        own, overlap = [], self.balances.overlap
        for noise in self.noise:
            own.append(np.diagonal(noise.wrench) * overlap(0, 0) + noise.motion**2 * overlap(noise.order, 0))
        return np.concatenate(own)

    def _unsure(self, form: Array, friction: Array) -> Array:
        """Squares (n, f) of what the model may be off by, for shares (c,) of the errors of its forms and of its dry
        friction."""
        free = self.held.shape[1]
        return self.held**2 + (friction[:free] * self.friction) ** 2 + (form[:free] * self.forms) ** 2

    def alone(self, loudness: float) -> Errors:
        """Errors of each balance for itself, with wrenches' noise so many times as loud as from sample to sample."""
        each = (own for one in self.forces for own in one.apart)
        return replace(self, forces=tuple(own._replace(wrench=loudness**2 * own.wrench) for own in each))

    def heard(self, excess: Array, form: Array, friction: Array, loudness: float) -> Densities:
        """Densities of white noise that is as loud as rows are, where sensors of wrenches are so many times as loud."""
        free, balances = self.held.shape[1], self.balances
        same, unsure = balances.overlap(0, 0), self._unsure(form, friction)
        moved = np.concatenate([one.motion**2 * balances.overlap(one.order, 0) / same for one in self.forces])
        quiet = np.concatenate([np.diagonal(one.wrench) for one in self.forces])
        beside = excess[:free] ** 2 + unsure * balances.row_step**2 / same - (loudness**2 - 1.0) * quiet
        return Densities(loudness * balances.wrench_densities, moved + np.maximum(beside, 0.0))

    def whitening(self, excess: Array, form: Array, friction: Array, memory: Array | None = None) -> Whitening:
        """`excess` (c,) is white noise beside the sensors' (N/√Hz, N·m/√Hz, m/s/√Hz), by which a model is wrong all the
        time; `form` (c,) and `friction` (c,) are the shares of what its forms, and its dry friction near standstill,
        may be wrong by; `memory` (c,) is how much of a row's noise the next one still has."""
        free, balances = self.held.shape[1], self.balances
        off = np.zeros((len(balances.used), len(excess)))
        off[:, :free] = balances.integrated(np.sqrt(self._unsure(form, friction)))
        roots, first = [], 0
        for noise in self.noise:
            own = slice(first, first := first + len(noise.motion))
            white = noise._replace(wrench=noise.wrench + np.diag(excess[own] ** 2))
            roots.append(np.asarray(cholesky_banded(_covariance(balances, white, off[:, own]), lower=True)))
        counts = np.ones_like(off)
        whole = self.white + excess**2 * balances.overlap(0, 0) + off**2
        counts[:, :free] -= (balances.integrated(self.held) ** 2) / whole[:, :free]
        none, linked = np.zeros(len(excess)), np.diff(balances.used, prepend=-SPLINE_SUPPORT) == 1
        return Whitening(tuple(roots), none if memory is None else memory, linked, np.maximum(counts, 0.0))

    def near_standstill(self, excess: Array, form: Array) -> Array:
        """Share of each row's variance (k, c) that the model's dry friction makes if it is as wrong as it may be."""
        free = self.held.shape[1]
        found = np.zeros((len(self.balances.used), len(self.white)))
        parts = (self.friction, self.held, form[:free] * self.forms)
        own, *others = (self.balances.integrated(part) ** 2 for part in parts)
        white = (self.white + excess**2 * self.balances.overlap(0, 0))[:free]
        found[:, :free] = own / (own + sum(others) + white)
        return found


def model_error(balances: Balances, cart: CartModel) -> tuple[Array, Array, Array]:
    """What a model may be off by (n, f), but for noise: at rest, where anything may hold a cart; near it, where Coulomb
    friction takes whatever value holds things; and what its forms may be wrong by at most everywhere, and where casters
    that swing round after a reversal turn the cart; those that are not listed drag nobody knows where."""
    free = cart.constraints.n_free
    levers = np.array([1.0, 1.0, HALF_TRACK][:: 1 if free == 3 else 2][:free])
    speed, weight = balances.turning_speed, FRICTION_COEFFICIENT * GRAVITY * cart.inertia.mass
    total = balances.wrenches.planar(cart) @ cart.basis_b
    size = np.sqrt((total**2).mean(axis=0))
    own = weight * np.exp(-((speed / DRY_FRICTION_SPEED) ** 2))[:, None] * levers
    effects = np.abs(_effects(balances, cart))
    swung = np.zeros_like(effects)
    if free > 1:
        swinging = _swinging(balances)
        if not cart.wheel_set.lists_casters:
            dry = _dry(cart)
            drags = np.abs(_effects(balances, dry) - _effects(balances, dry, -balances.of_body(dry).motion.velocity))
            swung = CASTER_WEIGHT_FRACTION * swinging[:, None] * drags
        swung[:, -1] = np.hypot(swung[:, -1], weight * HALF_TRACK * swinging)
    forms = np.sqrt((BODY_FORM_ERROR_RATIO * size) ** 2 + (EFFECT_FORM_ERROR_RATIO * effects) ** 2 + swung**2)
    dry = np.sqrt(own**2 + _turned(balances, cart, levers) ** 2 + reversal_drag_errors(balances, cart) ** 2)
    return holding_forces(balances, cart), dry, forms


def _swinging(balances: Balances) -> Array:
    """How much of casters' swing round after a reversal of the motion is still to come (n,), 1 to 0."""
    way, direction = balances.motion.way, np.sign(balances.motion.velocity[:, 0])
    reversed_at = np.flatnonzero(np.diff(direction) != 0)
    last = np.searchsorted(reversed_at, np.arange(len(way)) - 1, side="right") - 1
    if not len(reversed_at):
        return np.zeros(len(way))
    since = np.where(last >= 0, way - way[reversed_at[np.maximum(last, 0)]], np.inf)
    return np.asarray(np.exp(-((since / CASTER_SWING_DISTANCE) ** 2)))


def edge_error(balances: Balances, cart: CartModel) -> Array:
    """What effects that begin and end may be off by (n, f) near their edges: real ones are soft."""
    found = np.zeros((len(balances.motion.time), cart.constraints.n_free))
    for effect in cart.effects:
        if not effect.gate.n_parameters:
            continue
        rest = cart.without_effect(effect.key)
        inner, outer = (
            balances.expected(rest.with_effect(effect.with_values(values))) for values in _with_soft_edges(effect)
        )
        found = np.maximum(found, np.abs(outer - inner) / 2)
    return np.maximum(found, _poised_error(balances, cart))


def _poised_error(balances: Balances, cart: CartModel) -> Array:
    """Half of what effects give more or less (n, f) if memories follow a motion that turns a little more or less, by
    its standard deviation: casters that a reversal left poised swing round nobody knows which way, nor when."""
    found, own = np.zeros((len(balances.motion.time), cart.constraints.n_free)), balances.of_body(cart)
    if not cart.memory_names or cart.constraints.n_free < 2:
        return found
    motion, turned = own.motion, np.zeros(cart.constraints.n_free)
    turned[-1] = motion.rate_std[2]
    given = []
    for deviations in (0.0, *POISED_YAW_RATE_SIGMAS, *(-one for one in POISED_YAW_RATE_SIGMAS)):
        memory = motion.memory(cart, deviations * turned)
        given.append(_effects_at(balances, cart, np.hstack([motion.pose, motion.velocity, memory])))
    error = np.ptp(given, axis=0) / 2
    later = max(1, round(MAX_POISED_TIME / motion.step))
    return np.asarray(maximum_filter1d(error, later, axis=0, mode="nearest", origin=(later - 1) // 2))


def _with_soft_edges(effect: Effect) -> tuple[Array, Array]:
    """Values of an effect that is there for a little less, and a little more, time or place."""
    values, edge = effect.values, np.array([LOAD_ONSET_TIME])
    if effect.gate is Gate.INSIDE:
        width = min(SOFT_EDGE_WIDTH, float(min(values[1] - values[0], values[3] - values[2])) / 3)
        edge = width * np.array([1.0, -1.0, 1.0, -1.0])
    elif effect.gate is Gate.WHILE:
        edge = PUSH_RISE_FRACTION * float(values[1]) * np.array([1.0, -2.0])
    edge = np.pad(edge, (0, len(values) - len(edge)))
    return values + edge, values - edge


def _effects(balances: Balances, cart: CartModel, faster: Array | float = 0.0) -> Array:
    """What a cart's effects give (n, f) if it goes faster by velocities (n, f) or (f,)."""
    state = balances.state(cart)
    state[:, 3 : 3 + cart.constraints.n_free] += faster
    return _effects_at(balances, cart, state)


def _effects_at(balances: Balances, cart: CartModel, state: Array) -> Array:
    """What a cart's effects give (n, f) at states (n, s), worked out at every other point."""
    found = cart.effect_wrench(state[::GRID_STRIDE], time=balances.motion.time[::GRID_STRIDE]) @ cart.basis_b
    return np.asarray(np.repeat(found, GRID_STRIDE, axis=0)[: len(state)])


def _turned(balances: Balances, cart: CartModel, levers: Array) -> Array:
    """How far dry friction may be from what a model says (n, f), where a wheel, or the cart, nearly stands: half of
    how much more it changes over a small difference of velocity than it does on the way over a larger one."""
    found, dry = np.zeros((len(balances.motion.time), len(levers))), _dry(cart)
    if not dry.effects:
        return found
    for i, lever in enumerate(levers):
        faster = np.zeros(len(levers))
        faster[i] = DRY_FRICTION_SPEED / lever
        near, far = (
            np.abs(_effects(balances, dry, k * faster) - _effects(balances, dry, -k * faster)) / k for k in (1, 3)
        )
        found = np.maximum(found, 0.75 * (near - far))
    return found


def _dry(cart: CartModel) -> CartModel:
    """The cart without drag in proportion to speed."""
    return replace(cart, effects=tuple(e for e in cart.effects if not isinstance(e, ViscousDrag)))


def _covariance(balances: Balances, noise: Noise, off: Array) -> Array:
    """Bands (SPLINE_SUPPORT b, k b) of the covariance of balances that go together: of white noise, and of model errors
    that neighbours share, by which rows are `off` (k, b)."""
    k, count = off.shape
    bands = np.zeros((SPLINE_SUPPORT * count, k, count))
    for lag in range(min(SPLINE_SUPPORT, k)):
        same, moved = balances.overlap(0, lag), balances.overlap(noise.order, lag)
        linked, alike = balances.used[lag:] - balances.used[: k - lag] == lag, same / balances.overlap(0, 0)
        for i, j in product(range(count), range(count)):
            if lag == 0 and j < i:
                continue
            value = np.full(k - lag, same * noise.wrench[j, i])
            if i == j:
                value += moved * noise.motion[i] ** 2 + alike * off[: k - lag, i] * off[lag:, i]
            bands[lag * count + j - i, : k - lag, i] = value * linked
    return bands.reshape(SPLINE_SUPPORT * count, k * count)


def motion_noise(balances: Balances, cart: CartModel) -> tuple[Array, int]:
    """Root of the density (f,) of what the noise of the motion's sensors adds to the reduced wrench, and the order of
    the test functions' derivative through which it comes."""
    free, inertia = cart.constraints.n_free, cart.inertia
    own = [0, 1, 2] if free == 3 else [0, 2][:free]
    heavy = np.array([inertia.mass, inertia.mass, inertia.phi[3]])[own]
    density, derivative = balances.motion.noise.density
    return np.asarray(heavy * density[own]), 2 - derivative


def wrench_noise(balances: Balances, cart: CartModel) -> Array:
    """Root of the density of the reduced wrench's noise (f,), N/√Hz, N·m/√Hz."""
    return np.asarray(np.sqrt(np.diagonal(wrench_covariance(balances, cart))))


def wrench_covariance(balances: Balances, cart: CartModel) -> Array:
    """Density of the reduced wrench's noise (f, f), N²/Hz, N²·m/Hz, N²·m²/Hz."""
    found = MIN_FORCE_DENSITY**2 * np.eye(cart.constraints.n_free)
    for grasp, density in zip(balances.wrenches.grasps, balances.wrench_densities, strict=True):
        own = (np.moveaxis(grasp, 1, 0) * density).reshape(3, -1)
        found += cart.basis_b.T @ (own @ own.T / len(grasp)) @ cart.basis_b
    return np.asarray(found)


def excess_noise(parts: Sequence[tuple[Errors, Array]], used: float) -> tuple[float, Array, Array, Array, Array]:
    """What makes residuals (k, c) of logs as large as they are, as `Errors.whitening` takes it: white noise (c,) beside
    the sensors' and the share (c,) of what forms may be wrong by. Forms explain what they can. `used` parameters were
    fitted to the residuals. Then the share (c,) of what friction near standstill may be wrong by, of rows there, and
    what neighbours share (c,). First how many times as loud sensors of wrenches may be as from sample to sample: no
    louder than the balance says that has least beside."""
    count, free = parts[0][1].shape[1], parts[0][0].held.shape[1]
    none, least, whole = np.full(count, MIN_EXCESS_NOISE), np.full(count, MIN_FORM_ERROR_RATIO), np.ones(count)

    def surplus(excess: Array, form: Array, loudness: float | None = None) -> Array:
        total, rows = np.zeros(count), np.zeros(count)
        for errors, left in parts:
            whiten = (errors.alone(loudness) if loudness else errors).whitening(excess, form, whole)
            total += (whiten(left) ** 2).sum(axis=0)
            rows += whiten.counts.sum(axis=0)
        return np.asarray(total / np.maximum(rows - used / count, 0.5 * rows + 1e-9)) - 1.0

    def of_sensors(loudness: Array) -> Array:
        return np.asarray(surplus(none, least, float(loudness[0]))[:free].min(keepdims=True))

    loudness = float(_root_of(of_sensors, np.ones(1), np.full(1, MAX_NOISE_SCALE))[0])
    form = _root_of(lambda share: surplus(none, share), least, whole)
    excess = 10 ** _root_of(lambda decade: surplus(10**decade, form), np.log10(none), np.full(count, 4.0))
    shares = [errors.near_standstill(excess, form) for errors, _ in parts]
    rows = sum(share.sum(axis=0) for share in shares) + PRIOR_FRICTION_ROWS

    def near_standstill(friction: Array) -> Array:
        total = np.full(count, PRIOR_FRICTION_ROWS)
        for (errors, left), share in zip(parts, shares, strict=True):
            total += (share * errors.whitening(excess, form, friction)(left) ** 2).sum(axis=0)
        return np.asarray(total / rows - 1.0)

    friction = _root_of(near_standstill, least, whole)
    most = np.exp(-parts[0][0].balances.row_step / MAX_NOISE_CORRELATION_TIME)
    memory = _memory([(errors.whitening(excess, form, friction), left) for errors, left in parts])
    return loudness, excess, form, friction, np.minimum(memory, most)


def _memory(parts: Sequence[tuple[Whitening, Array]]) -> Array:
    """How much of a row's noise the next one still has (c,): by how much differences of rows two apart are larger than
    those of neighbours, most of the time. What is slow, as what a model lacks is, hardly tells in either."""
    white = [(whiten(left), whiten.linked) for whiten, left in parts]
    near = np.concatenate([np.diff(rows, axis=0)[linked[1:]] for rows, linked in white])
    far = np.concatenate([(rows[2:] - rows[:-2])[linked[2:] & linked[1:-1]] for rows, linked in white])
    if not len(far):
        return np.zeros(white[0][0].shape[1])
    return np.asarray(np.clip(_usual(far) / np.maximum(_usual(near), 1e-300) - 1.0, 0.0, 1.0))


def _usual(differences: Array) -> Array:
    """Mean squares (c,), of which the few that are large count as little more than usual (Huber)."""
    sizes = np.abs(differences)
    return np.asarray((np.minimum(sizes, HUBER_SIGMAS * MAD_TO_STD * np.median(sizes, axis=0)) ** 2).mean(axis=0))


def _root_of(surplus: Callable[[Array], Array], low: Array, high: Array) -> Array:
    """Where functions (c,) that fall are nought, by bisection between bounds (c,); the bound, where they are not."""
    if (surplus(low) <= 0.0).all():
        return low
    for _ in range(BISECTIONS):
        middle = (low + high) / 2
        too_small = surplus(middle) > 0.0
        low, high = np.where(too_small, middle, low), np.where(too_small, high, middle)
    return high
