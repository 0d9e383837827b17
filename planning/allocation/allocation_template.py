"""What stays the same from tick to tick: arms, limits, objective and the cart's effective rows.

With S the basis of the free velocities, k = n_free, and G_i the grasp map of arm i at its contact, the
equality is `Sᵀ sum_i G_i F_i = Sᵀ wrench_b` (physics.md): k rows of full rank, free of the cart's parameters.

A contact enters the effective rows only where there is a moment, and linearly. So where contacts may vary over a
convex set with vertices v, the wrenches within reach are the union over pairs of vertices (high, low) of

    m(high) F >= tau,    m(low) F <= tau,    the other rows as equalities,

because m(.) F takes every value between its largest and its smallest: a `range` program, linear and convex. Limits
of the cart (limits/cart_limit.py) depend on contacts too. A range program has them at the middle of the vertices, and
wider by the most that any contact of the set makes of it: not exact, but never too tight, and exact as the set shrinks.

Unknowns are the wrenches F (6n,), and behind them the objective's own (`Cost.epigraph`). Rows are, in this order, the
arms' limits, the objective's, the cart's limits and the effective rows; only the last two depend on contacts.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from types import NoneType
from typing import Self

import numpy as np

from cartgrasp.arms import Arm
from cartgrasp.checks import check_kind, listed
from cartgrasp.contacts import grasp_map_planar, grasp_map_spatial
from cartgrasp.errors import UsageError
from cartgrasp.frames import Array, rotation_planar
from cartgrasp.model import CartModel

from ..limits import CartLimit, CartRows, LimitRows, PushedCart, cart_rows, joined, limits_of
from ..objectives import Cost, Lexicographic, Objective, WeightedWrench
from ..objectives.cost_checks import check_costs
from ..quadratic_program import QuadraticProgram

PLANAR_NAMES = ("fx", "fy", "tau")


# Many methods: the parts of one program (costs, rows, limits, slacks), each kept until what it depends on changes, and
# the few ways to another template that keep the rest.
@dataclass(frozen=True, eq=False)
class AllocationTemplate:
    """n arms, their limits side by side over F (6n,), limits of the cart, and an objective; basis_b is S, (3, k)."""

    arms: tuple[Arm, ...]
    basis_b: Array
    limits: LimitRows
    objective: Objective
    cart_rows: CartRows

    def __post_init__(self) -> None:
        check_costs(self.objective, self.arms)
        _ = self._first_cost  # raises what the objective has against these arms
        if isinstance(self.objective, Lexicographic):
            self.second_cost(np.zeros(self.n))

    @classmethod
    def of(
        cls,
        cart: CartModel,
        arms: Sequence[Arm],
        objective: Objective | None = None,
        cart_limits: Sequence[CartLimit] = (),
    ) -> Self:
        """`cart_limits` are those of the cart at rest, until `with_cart_rows`."""
        check_kind("cart", cart, CartModel, 'load it first: load_cart("cart.yaml")')
        check_kind("objective", objective, (Objective, NoneType), "write LoadShare({'left': 0.7, 'right': 0.3}), …")
        arms = listed("arms", arms, Arm, 'write [Arm("left", contacts=[(x, y, z)])]')
        names = [arm.name for arm in arms]
        if not arms:
            raise UsageError("arms: none given; at least one arm is needed")
        if twice := [name for name in names if names.count(name) > 1]:
            raise UsageError(f"arms: {twice[0]} stands twice; names must differ")
        basis_b = cart.basis_b
        if np.any(basis_b[2, :-1]):
            raise UsageError("constraints: only the last free velocity may turn the cart; choose another basis")
        limits, rows = joined(names, map(limits_of, arms)), cart_rows(cart_limits, PushedCart(cart, None, arms))
        return cls(arms, basis_b, limits, objective or WeightedWrench(), rows)

    def with_arms(self, arms: tuple[Arm, ...], rows: CartRows) -> Self:
        """A template for other arms of the same names, with `rows` for the cart's limits."""
        other = type(self)(arms, self.basis_b, joined(self.names, map(limits_of, arms)), self.objective, rows)
        same = {"names", "row_names", "looks_at_wheels"}
        if all(one.yaw == before.yaw for one, before in zip(arms, self.arms, strict=True)):
            same |= {"yaws", "across", "_along_axes"}
        other.__dict__.update({name: self.__dict__[name] for name in same & self.__dict__.keys()})
        return other

    def with_cart_rows(self, rows: CartRows) -> Self:
        """A template with other rows for the cart's limits. Cached values stay where the new rows are like the old
        ones."""
        other = object.__new__(type(self))
        other.__dict__.update(self.__dict__, cart_rows=rows)
        if not rows.is_like(self.cart_rows):
            for blank in ("at_points", "_over_ranges"):
                other.__dict__.pop(blank, None)
        return other

    def with_bounds(self, limits: LimitRows) -> Self:
        """A template with other bounds on F; the rest of `limits` must be unchanged."""
        other = object.__new__(type(self))
        other.__dict__.update(self.__dict__, limits=limits)
        other.__dict__.pop("fixed", None)
        names = limits.lower_names, limits.upper_names
        for blank in other.__dict__.keys() & {"at_points", "_over_ranges"}:
            other.__dict__[blank] = other.__dict__[blank].with_bounds(limits.lower, limits.upper, names)
        return other

    # --- structure ----------------------------------------------------------------------------------------

    @property
    def n(self) -> int:
        """Number of wrench components, 6 per arm."""
        return 6 * len(self.arms)

    @cached_property
    def names(self) -> tuple[str, ...]:
        return tuple(arm.name for arm in self.arms)

    @cached_property
    def yaws(self) -> Array:
        return np.array([arm.yaw for arm in self.arms])

    @cached_property
    def effort_weights(self) -> Array:
        return np.concatenate([arm.weights for arm in self.arms])

    @cached_property
    def moment_row(self) -> int | None:
        """The effective row that depends on the contacts, which is the last; None on a rail."""
        return self.basis_b.shape[1] - 1 if self.basis_b[2].any() else None

    @cached_property
    def row_names(self) -> tuple[str, ...]:
        """Effective rows in words: `fx`, `tau`, `tau - 0.3 fy`."""
        return tuple(in_words(column) for column in self.basis_b.T)

    @cached_property
    def _first_cost(self) -> Cost:
        """The cost at the first tick, and at any tick where the objective looks neither back nor at the wheels."""
        return self._with_side_force(self.objective.cost(self.arms, np.zeros(self.n)), 0.0)

    @cached_property
    def looks_at_wheels(self) -> bool:
        """Whether costs change with what the fixed wheels would take of hands that push straight."""
        costs = [self.objective.cost(self.arms, np.zeros(self.n))]
        if isinstance(self.objective, Lexicographic):
            costs.append(self.objective.second_cost(self.arms, np.zeros(self.n)))
        return any(cost.side_weight for cost in costs)

    def _with_side_force(self, cost: Cost, straight: float) -> Cost:
        if cost.side_weight and len(self.basis_b.T) == 3:
            raise UsageError("least side force: a cart on casters alone has no fixed wheels to spare")
        return cost.with_side_force(self.across, straight) if cost.side_weight else cost

    @cached_property
    def across(self) -> Array:
        """The hands' force across the fixed wheels, to their left, by their wrenches, (6n,)."""
        across, along = np.zeros((len(self.arms), 6)), self.basis_b[:2, 0]
        across[:, :2] = [np.array([-along[1], along[0]]) @ rotation_planar(yaw) for yaw in self.yaws]
        return across.ravel()

    @cached_property
    def hessian(self) -> Array:
        return self._first_cost.hessian

    @cached_property
    def fixed(self) -> LimitRows:
        """What doesn't depend on contacts, over all unknowns: the arms' limits, then the objective's rows."""
        limits, epigraph = self.limits, self._first_cost.epigraph
        if epigraph is None:
            return limits
        n_own = len(epigraph.lower)
        cones = tuple(replace(c, rows=np.pad(c.rows, ((0, 0), (0, n_own)))) for c in limits.cones)
        wide = replace(limits, rows=np.pad(limits.rows, ((0, 0), (0, n_own))), cones=cones)
        return wide.followed_by(epigraph)

    def cost(self, previous: Array, straight: float = 0.0) -> Cost:
        """The cost after wrenches (6n,), where the fixed wheels take `straight` from hands without any force across
        them: N, to their left (`floor_reaction.straight_force`)."""
        if not (self.objective.looks_back or self.looks_at_wheels):
            return self._first_cost
        return self._with_side_force(self.objective.cost(self.arms, previous), straight)

    def second_cost(self, previous: Array, straight: float = 0.0) -> Cost:
        """The second cost of a lexicographic objective; arguments as for `cost`."""
        assert isinstance(self.objective, Lexicographic)
        return self._with_side_force(self.objective.second_cost(self.arms, previous), straight)

    def effort(self, wrenches: Array) -> float:
        """`sum weight component²` by the arms' own weights, whatever the objective."""
        return float(wrenches.dot(self.effort_weights * wrenches))

    # --- programs -----------------------------------------------------------------------------------------

    def contact_rows(self, points: Array, owners: Array | None = None) -> Array:
        """Rows of the cart's limits and then `Sᵀ G`, shape (..., c + k, 6), of contact points (..., n, 3), or of
        points (v, 3) that belong to the arms `owners` (v,)."""
        yaws = self.yaws if owners is None else self.yaws[owners]
        effective = np.asarray(self.basis_b.T @ grasp_map_planar(points, yaws))
        if not len(self.cart_rows.low):
            return effective
        return np.concatenate([self.cart_rows.over(grasp_map_spatial(points, yaws), owners), effective], axis=-2)

    def affine_rows(self) -> Array:
        """`contact_rows` with all arms at the origin, and how much they grow along x, y and z: (4, n, c + k, 6)."""
        effective, grasp_maps = self._along_axes
        rows = np.concatenate([self.cart_rows.over(grasp_maps), effective], axis=-2)
        rows[1:] -= rows[0]
        return rows

    @cached_property
    def _along_axes(self) -> tuple[Array, Array]:
        """Effective rows (4, n, k, 6) and grasp maps with all arms at the origin, and at 1 m along x, y and z."""
        places = np.concatenate([np.zeros((1, 3)), np.eye(3)])[:, None].repeat(len(self.arms), axis=1)
        return self.basis_b.T @ grasp_map_planar(places, self.yaws), grasp_map_spatial(places, self.yaws)

    def contact_limits(self, target: Array) -> tuple[Array, Array]:
        """What `contact_rows` are limited by, low and high (c + k,), for an effective wrench (k,)."""
        rows = self.cart_rows
        if not len(rows.low):
            return target, target
        return np.concatenate([rows.low, target]), np.concatenate([rows.high, target])

    def program(self, rows: Array, target: Array, cost: Cost) -> QuadraticProgram:
        """One contact an arm: `rows` (n, c + k, 6) from `contact_rows`, `target` = Sᵀ wrench_b (k,)."""
        return self._filled(self.at_points, self._in_line(rows), self.contact_limits(target), cost)

    def range_program(self, rows: tuple[Array, Array], hull: Array, target: Array, cost: Cost) -> QuadraticProgram:
        """Contacts between two vertices: `rows` at the high and the low one, `hull` (v, n, c + k, 6) at all that
        span them. Rows: the cart's, then high, low, and the equalities."""
        k, moment = len(target), self.moment_row
        high, low = (self._in_line(part[:, -k:]) for part in rows)
        if moment is None:
            matrix, below, above = high, target, target
        else:
            others = [i for i in range(k) if i != moment]
            matrix = np.concatenate([high[moment, None], low[moment, None], high[others]])
            below = np.concatenate([[target[moment], -np.inf], target[others]])
            above = np.concatenate([[np.inf, target[moment]], target[others]])
        if len(self.cart_rows.low):
            fixed_part = self._turning * target[-1]
            middle, spread = self._spread(hull[..., :-k, :] - self._turning[:, None] * hull[..., -1:, :])
            matrix = np.concatenate([middle, matrix])
            below = np.concatenate([self.cart_rows.low - fixed_part - spread, below])
            above = np.concatenate([self.cart_rows.high - fixed_part + spread, above])
            return self._filled(self._over_ranges, matrix, (below, above), cost, (fixed_part, spread))
        return self._filled(self._over_ranges, matrix, (below, above), cost)

    def slack_map(self, is_range: bool) -> Array:
        """T, (contact rows of the program, k): where a slack of each effective row of `target` enters."""
        effective, moment = np.eye(self.basis_b.shape[1]), self.moment_row
        of_cart = np.zeros((len(self.cart_rows.low), len(effective)))
        if is_range:
            of_cart[:, -1] = -self._turning
        if is_range and moment is not None:
            others = [i for i in range(len(effective)) if i != moment]
            effective = np.vstack([effective[moment], effective[moment], effective[others]])
        return np.vstack([of_cart, effective])

    def _in_line(self, rows: Array) -> Array:
        """Rows (n, m, 6) of each arm as rows (m, unknowns) of the program."""
        matrix = rows.transpose(1, 0, 2).reshape(-1, self.n)
        n_own = len(self.hessian) - self.n
        return np.pad(matrix, ((0, 0), (0, n_own))) if n_own else matrix

    @property
    def _turning(self) -> Array:
        """How much of the moment row is in the cart's rows (c,). Ranges are without that part: the equality says what
        it is, so contacts don't change it."""
        return self.cart_rows.of_sum[:, 5] if self.moment_row is not None else np.zeros(len(self.cart_rows.low))

    def _spread(self, hull: Array) -> tuple[Array, Array]:
        """The cart's rows (c, unknowns) at the middle of vertices, and by how much others may differ in value (c,)."""
        each = np.array([self._in_line(rows) for rows in hull])
        middle = each.mean(axis=0)
        largest = np.maximum(np.abs(self.fixed.lower), np.abs(self.fixed.upper))
        apart = np.abs(each - middle).max(axis=0)
        return middle, np.where(apart > 0, apart * np.where(apart > 0, largest, 0.0), 0.0).sum(axis=1)

    @cached_property
    def at_points(self) -> QuadraticProgram:
        """At contact points, but for the rows that depend on them, which come last."""
        return self._blank(self.basis_b.shape[1], self.basis_b.shape[1])

    @cached_property
    def _over_ranges(self) -> QuadraticProgram:
        split = self.moment_row is not None
        return self._blank(self.basis_b.shape[1] + split, self.basis_b.shape[1] - split)

    def _blank(self, n_effective: int, n_equalities: int) -> QuadraticProgram:
        fixed, cart = self.fixed, self.cart_rows
        effective, last = ("effective row",) * n_effective, np.zeros(len(cart.low) + n_effective)
        return QuadraticProgram(
            hessian=self.hessian,
            gradient=np.zeros(len(self.hessian)),
            rows=np.concatenate([fixed.rows, np.zeros((len(last), len(self.hessian)))]),
            lower=np.concatenate([fixed.lower, fixed.low_limits, last]),
            upper=np.concatenate([fixed.upper, fixed.limits, last]),
            n_equalities=n_equalities,
            lower_names=fixed.lower_names + fixed.low_names + cart.low_names + effective,
            upper_names=fixed.upper_names + fixed.names + cart.high_names + effective,
            cones=fixed.cones,
        )

    def _filled(
        self,
        blank: QuadraticProgram,
        matrix: Array,
        values: tuple[Array, Array],
        cost: Cost,
        moved: tuple[Array, Array] | None = None,
    ) -> QuadraticProgram:
        program = blank.with_last_rows(matrix, *values).with_gradient(cost.gradient, cost.constant)
        if not self.cart_rows.cone_names:
            return program
        return program.with_cones((*blank.cones, *self.cart_rows.cones_over(matrix, len(self.fixed.rows), moved)))


def in_words(direction: Array) -> str:
    """A combination of (fx, fy, tau), as `fx` or `tau - 0.3 fy`."""
    parts = sorted(zip(direction, PLANAR_NAMES, strict=True), key=lambda part: part[1] != "tau" or part[0] < 0)
    text = ""
    for factor, name in parts:
        if abs(factor) > 1e-9:
            sign = (" - " if factor < 0 else " + ") if text else ("-" if factor < 0 else "")
            text += sign + ("" if abs(abs(factor) - 1) < 1e-9 else f"{abs(factor):.4g} ") + name
    return text or "0"
