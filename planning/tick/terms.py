"""What holds at a tick: the arms with their limits and candidate contacts, the cart with its own, the last wrench.

Nothing is built anew for a new wrench or contact. A new estimate changes the numbers of the cart's limits, a rate
the bounds about the last wrench; new arms cost their rows.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from operator import is_
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from cartgrasp.arms import Arm
from cartgrasp.contacts import ContactSet
from cartgrasp.errors import UsageError
from cartgrasp.floor_reaction import WheelForces, straight_force
from cartgrasp.frames import PLANAR, Array
from cartgrasp.reach import Reach

from ..allocation.allocation_template import AllocationTemplate
from ..contacts.contact_bounds import Candidates
from ..limits import CartRows, LimitRows, PushedCart, WrenchRate
from ..limits.robust import RobustLimits
from ..objectives import Cost, Objective
from ..plan import INVALID_INPUT
from .estimate_inputs import read_cart, read_covariance
from .plan_inputs import MAX_WRENCH, RefusedError, read_contacts

if TYPE_CHECKING:
    from cartgrasp.model import CartModel
    from cartgrasp.motion import Estimate

WRENCH_TOLERANCE = 1e-9  # of the largest component, at least 1 N


@dataclass(frozen=True)
class Settings:
    """What a planner was made with, the arms aside; `period` in s, `min_hand_distance` in m."""

    cart: CartModel
    objective: Objective | None
    cart_limits: RobustLimits
    min_hand_distance: float
    period: float
    relax: float
    switching_cost: float | Mapping[str, float]
    solver: str | None

    def costs_of(self, names: Sequence[str]) -> float | Mapping[str, float]:
        """Switching costs of these arms alone."""
        costs = self.switching_cost
        return {n: cost for n, cost in costs.items() if n in names} if isinstance(costs, Mapping) else costs


# Many methods: one for each kind of news between two ticks (estimate, arms, postures, last wrench, margins).
class Terms:
    """`base` is the template but for the rate of change, `template` with it."""

    base: AllocationTemplate
    template: AllocationTemplate
    candidates: Candidates
    rate: WrenchRate | None
    sets: dict[str, ContactSet]
    has_postures: bool
    yaws: dict[str, float]

    def __init__(self, settings: Settings, arms: Sequence[Arm]) -> None:
        cart, self._settings, self._cart_limits = settings.cart, settings, settings.cart_limits
        base = AllocationTemplate.of(cart, arms, settings.objective)
        self._pushed, self._on_floor = PushedCart(cart, None, base.arms), self._cart_limits.on_floor(cart)
        self._covariance: Array | None = None
        self.estimate: Estimate | None = None
        self.wheel_forces: Callable[[Array], WheelForces] = partial(WheelForces.of, cart)
        """What the wheels take under a spatial wrench (6,) of the hands."""
        self.straight = 0.0
        """N that they take of hands which give what is asked, and nothing across the wheels."""
        self.beside: Array | None = None
        """What others give the cart besides: a spatial wrench (6,) about {b}'s origin."""
        self._places: list[tuple[ContactSet, Reach | None]] = []
        self._last = np.zeros(base.n)
        self._rows = self._cart_limits.rows(self._pushed, None, self._on_floor)
        self._use(base.with_cart_rows(self._rows))

    def take_postures(self, contacts: Mapping[str, ArrayLike] | None) -> bool:
        """The limits of the postures at contacts (3,), given by arm, and where an arm has no choice; others stay as
        they are. True if that changed anything."""
        held = {} if contacts is None else read_contacts(contacts, self.base.names)
        if len(held) < len(self.sets):
            single = (name for name, it in self.sets.items() if len(it.points) == 1 and not it.segments)
            held = {name: self.sets[name].points[0] for name in single} | held
        try:
            now = [arm.at(held[arm.name]) if arm.name in held else arm for arm in self.base.arms]
        except UsageError as error:
            raise RefusedError(INVALID_INPUT, str(error)) from error
        return not all(map(is_, now, self.base.arms)) and self.take_arms({arm.name: arm for arm in now})

    def take_arms(self, new: Mapping[str, Arm]) -> bool:
        """Puts these in the place of all arms, by their names; True if that changed anything."""
        changed = tuple(new[arm.name] for arm in self.base.arms)
        if all(one is other for one, other in zip(changed, self.base.arms, strict=True)):
            return False
        try:
            pushed, rows = self._pushed.by(changed), self._rows
            if any(limit.looks_at_arms for limit in self._cart_limits.limits):
                rows = self._cart_limits.rows(pushed, self._covariance, self._on_floor)
            self._use(self.base.with_arms(changed, self._less_beside(rows)))
        except UsageError as error:
            raise RefusedError(INVALID_INPUT, str(error)) from error
        self._pushed, self._rows = pushed, rows
        return True

    def rest_of(self, asked: tuple[float, float, float]) -> tuple[float, float, float]:
        """What is left of a planar wrench (3,) for these arms."""
        if self.beside is None:
            return asked
        (fx, fy, tau), (x, y, turn) = asked, self.beside[[*PLANAR]].tolist()
        return fx - x, fy - y, tau - turn

    def cost(self, last: Array, asked: Sequence[float]) -> Cost:
        """The cost after wrenches (6n,), where the cart is to get a planar wrench (3,)."""
        if self.base.looks_at_wheels:
            slope, besides = self._straight_force
            self.straight = float(slope.dot(asked)) + besides
            if self.beside is not None:
                along_x, along_y = self.base.basis_b[:2, 0].tolist()
                self.straight -= float(self.beside[1] * along_x - self.beside[0] * along_y)
        return self.base.cost(last, self.straight)

    @cached_property
    def _straight_force(self) -> tuple[Array, float]:
        """The straight force (`floor_reaction.straight_force`) for the estimate given last, or for the cart at rest
        before the first."""
        if self.estimate is None:
            return straight_force(self._pushed.cart)
        cart = read_cart(self.estimate, self.base.basis_b)
        return straight_force(cart, self.estimate.motion, self.estimate.time)

    @property
    def first(self) -> Array:
        """Each arm's first candidate, (n, 3)."""
        return np.array([contacts.first for contacts in self.sets.values()])

    @property
    def looks_back(self) -> bool:
        """Whether the last wrench matters to the next plan."""
        return self.rate is not None or self.base.objective.looks_back

    def shrink(self, wrenches: Array, factor: float) -> float:
        """The smallest factor from `factor` on by which wrenches (6n,) may be scaled in one call."""
        return factor if self.rate is None else self.rate.shrink(wrenches, factor)

    def reaching(self, names: Iterable[str]) -> list[tuple[str, Reach]]:
        """The named arms that have a reach, with it."""
        return [(arm.name, arm.reach) for arm in self.base.arms if arm.name in names and arm.reach is not None]

    def take_estimate(self, estimate: Estimate) -> None:
        """The cart's limits for the cart and motion as now estimated."""
        if estimate is self.estimate:
            return
        cart = read_cart(estimate, self.base.basis_b)  # refused before it is believed
        if not self._cart_limits.limits:
            self._believe(estimate)
            return
        covariance = None if self._cart_limits.confidence is None else read_covariance(estimate)
        try:
            with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
                pushed, on_floor = PushedCart(cart, estimate.motion, self.base.arms, estimate.time), self._on_floor
                if cart.structure is not self._pushed.cart.structure:
                    on_floor = self._cart_limits.on_floor(cart)
                rows = self._cart_limits.rows(pushed, covariance, on_floor)
        except (UsageError, np.linalg.LinAlgError) as error:
            raise RefusedError(INVALID_INPUT, f"estimate: {error}") from error
        if not rows.are_numbers(MAX_WRENCH):
            what = f"by it a limit of the cart is not finite, or beyond {MAX_WRENCH:g}"
            raise RefusedError(INVALID_INPUT, f"estimate: {what}; its motion, parameters or covariance can't be true")
        self._pushed, self._on_floor, self._covariance = pushed, on_floor, covariance
        self._believe(estimate)
        self._take_rows(rows)

    def take_beside(self, wrench_b: Array | None) -> None:
        """What others give besides from now on."""
        before = self.beside
        if wrench_b is before or (wrench_b is not None and before is not None and np.array_equal(wrench_b, before)):
            return
        self.beside = wrench_b
        self._take_rows(self._rows)

    def keep(self, share: float | None) -> None:
        """That share of the margins of `confidence`, until another is kept or an estimate is taken; None: not even the
        cart's limits on the floor."""
        self._take_rows(self._cart_limits.rows(self._pushed, self._covariance, self._on_floor, share))

    @property
    def has_margins(self) -> bool:
        return self._covariance is not None

    @property
    def limits_floor(self) -> bool:
        return len(self._on_floor.low) > 0

    def _take_rows(self, rows: CartRows) -> None:
        self._rows = rows
        self.template = self.base = self.base.with_cart_rows(self._less_beside(rows))
        self.take_last(self._last)

    def _less_beside(self, rows: CartRows) -> CartRows:
        return rows if self.beside is None else rows.beside(self.beside)

    def _believe(self, estimate: Estimate) -> None:
        self.__dict__.pop("_straight_force", None)
        self.estimate, self.wheel_forces = estimate, partial(_wheel_forces, estimate, self.base.basis_b)

    def take_last(self, wrenches: Array) -> None:
        """Bounds about the last wrenches (6n,), where an arm has a rate."""
        self._last = wrenches
        if self.rate is not None:
            limits = self.base.limits
            last = np.clip(wrenches, limits.lower, limits.upper)
            self.template = self.base.with_bounds(limits & self.rate.around(last))

    def _use(self, base: AllocationTemplate) -> None:
        """Candidates stay the same object where arms may hold as before."""
        places = [(arm.contacts, arm.reach) for arm in base.arms]
        if places != self._places:
            sets = {arm.name: possible_contacts(arm) for arm in base.arms}
            self.candidates = Candidates.of(list(sets.values()), self._settings.min_hand_distance)
            self.sets, self._places = sets, places
        self.template = self.base = base
        self.yaws = {arm.name: arm.yaw for arm in base.arms}
        self.has_postures = any(arm.postures is not None for arm in base.arms)
        self.rate = WrenchRate.of(base.arms, self._settings.period)


def scaled_into(limits: LimitRows, wrenches: Array) -> Array:
    """Wrenches (6n,) scaled towards zero, which the limits hold, as little as brings them within. Rounding is no
    reason: at the edge of a friction it would scale them to zero."""
    values = np.concatenate([wrenches, limits.rows @ wrenches])
    low, high = np.concatenate([limits.lower, limits.low_limits]), np.concatenate([limits.upper, limits.limits])
    rounding = WRENCH_TOLERANCE * max(1.0, float(np.abs(wrenches).max(initial=0.0)))
    beyond = (values > high + rounding) | (values < low - rounding)
    scale = 1.0
    if beyond.any():
        scale = float((np.where(values > 0, high, low)[beyond] / values[beyond]).min(initial=1.0))
    for cone in limits.cones:
        along = cone.rows @ wrenches
        s = cone.offset + along
        if np.linalg.norm(s[1:]) > s[0] + rounding:
            scale = min(scale, _share_within(cone.offset, along))
    return scale * wrenches


def _share_within(offset: Array, along: Array) -> float:
    """The share t at which `offset + t along` (k,) leaves the second-order cone, which holds the offset: the least
    positive root of `a t² + 2 b t + c`. Zero where the offset is on the cone's edge."""
    signs = np.append(1.0, np.full(len(offset) - 1, -1.0))
    a, b, c = float(signs @ along**2), float(signs @ (offset * along)), max(0.0, float(signs @ offset**2))
    root = math.sqrt(max(0.0, b * b - a * c))
    return c / (root - b) if root > b else 0.0


def _wheel_forces(estimate: Estimate, basis_b: Array, wrench_b: Array) -> WheelForces:
    return WheelForces.of(read_cart(estimate, basis_b), wrench_b, estimate.motion, estimate.time)


def possible_contacts(arm: Arm) -> ContactSet:
    """The arm's candidates that are within its reach, and of which it has a posture; a `UsageError` if none is."""
    left = arm.contacts if arm.reach is None else arm.reach.clip(arm.contacts)
    if left is None:
        ends = [*arm.contacts.points, *(end for s in arm.contacts.segments for end in (s.start, s.stop))]
        least = float(arm.reach.excess(ends).min()) if arm.reach is not None else 0.0
        raise UsageError(f"arm {arm.name}: reach: no candidate contact is within; the nearest is {least:.3g} m beyond")
    why = {point: why_no_posture(arm, point) for point in left.points}
    if all(why.values()) and not left.segments:
        raise UsageError(next(iter(why.values())))
    return replace(left, points=tuple(point for point in left.points if not why[point])) if any(why.values()) else left


def why_no_posture(arm: Arm, contact: ArrayLike) -> str:
    """Why the arm can't hold at a contact (3,), in words; empty if it can, or tells no postures."""
    try:
        arm.at(contact)
    except UsageError as error:
        return str(error)
    return ""
