"""What a planner should have in mind, kept beside it in plain numpy: arms, cart, motion, what is believed, and the
last wrench. It states all that holds at a tick over F (6n,), without a line of `planning`."""

from __future__ import annotations

from dataclasses import dataclass, field
from statistics import NormalDist
from typing import Any, NamedTuple

import numpy as np

from cartgrasp.wheels import GRAVITY
from planning import (
    InternalForce,
    LeastInternalForce,
    LeastJointTorque,
    Lexicographic,
    LoadShare,
    Nothing,
    Skid,
    Smoothness,
    TipOver,
    WorstArm,
)

from .drawn import linear_limits

STEP = 1e-20  # of a standard deviation, along the imaginary axis


class Holds(NamedTuple):
    """`rows @ F <= limits` and `values + matrix @ F` in the second-order cone, for each of `cones`; `matrix @ F` is
    what the cart gets (k,)."""

    rows: Any
    limits: Any
    cones: list
    matrix: Any


class Cost(NamedTuple):
    """`½ x P x + q x` over x = F, and behind it the worst arm's share t where there is one, with rows for it."""

    hessian: Any
    gradient: Any
    rows: Any


@dataclass
class Mirror:
    structure: Any
    arms: dict
    cart_limits: list
    objective: Any
    confidence: float | None
    period: float
    newest: float = -np.inf
    velocity: Any = None
    phi: Any = None
    covariance: Any = None
    last: Any = field(default=None)
    names: Any = field(default=None)

    def __post_init__(self):
        self.velocity = np.zeros(self.structure.constraints.n_free)
        self.phi = self.structure.inertia.phi
        self.last, self.names = np.zeros(6 * len(self.arms)), list(self.arms)

    # --- what is taken ----------------------------------------------------------------------------------------

    def take_arms(self, new):
        given, before = {one.name: one for one in new}, dict(zip(self.arms, self.last.reshape(-1, 6), strict=True))
        if given != self.arms:
            self.arms = {name: given[name] for name in self.names if name in given}
            self.start_from(np.concatenate([before.get(name, np.zeros(6)) for name in self.arms]))

    def take_estimate(self, estimate):
        self.newest = max(self.newest, estimate.time)
        if self.cart_limits:
            self.velocity, self.phi = np.asarray(estimate.motion.velocity), np.asarray(estimate.model_parameters)
            self.covariance = None if self.confidence is None else np.asarray(estimate.covariance)

    def start_from(self, wrenches):
        """Scaled towards zero as little as the arms' limits ask for."""
        rows, limits = self._own_rows()
        values = rows @ wrenches
        beyond = values > limits + 1e-9 * max(1.0, np.abs(wrenches).max())
        scale = float((limits[beyond] / values[beyond]).min(initial=1.0))
        self.last = scale * np.asarray(wrenches)

    def reset(self):
        self.last, self.newest = np.zeros(6 * len(self.arms)), -np.inf

    def objective_refuses(self, new):
        arms = new
        parts = _parts(self.objective)
        if any(isinstance(part, LoadShare) for part in parts) and len(arms) < len(self.names):
            return True  # shares are of all
        if any(isinstance(part, LeastJointTorque) for part in parts) and all(a.joints is None for a in arms):
            return True
        limits = np.array([[*a.force_limit, *a.moment_limit] for a in arms])
        limited = np.isfinite(limits) & (limits > 0)
        return any(isinstance(part, WorstArm) for part in parts) and not limited.any()

    # --- what holds -------------------------------------------------------------------------------------------

    @property
    def step(self):
        return self.period * np.concatenate([a.wrench_rate for a in self.arms.values()])

    def _own_rows(self):
        rows, limits, bounds = linear_limits(list(self.arms.values()))
        lower = np.array([-np.inf if low is None else low for low, _ in bounds])
        upper = np.array([np.inf if high is None else high for _, high in bounds])
        unit = np.eye(len(bounds))
        return _there(np.vstack([rows, unit, -unit]), np.concatenate([limits, upper, -lower]))

    def of_arms(self):
        """Rows of the arms' own limits and rates."""
        rows, limits = self._own_rows()
        unit = np.eye(len(self.last))
        with_rates = np.vstack([rows, unit, -unit])
        return _there(with_rates, np.concatenate([limits, self.last + self.step, self.step - self.last]))

    def holds(self, contacts):
        maps = np.hstack([spatial_map(contacts[name], arm.yaw) for name, arm in self.arms.items()])
        matrix = self.structure.constraints.basis_b.T @ maps[[0, 1, 5]]
        rows, limits = self.of_arms()
        sides, most = self._internal_force()
        rows, limits, cones = np.vstack([rows, sides]), np.concatenate([limits, most]), []
        of_floor, room = self._floor_sides(self.phi, maps)
        directions = self._believed()
        slopes = [self._floor_slopes(d, maps) for d in directions]
        uncertain = [i for i in range(len(room)) if any(max(np.abs(a[i]).max(), abs(b[i])) > 1e-9 for a, b in slopes)]
        if uncertain:
            q = NormalDist().inv_cdf(1 - (1 - self.confidence) / len(uncertain))
            for i in uncertain:
                axis = np.array([-of_floor[i], *(q * a[i] for a, _ in slopes)])
                cones.append((axis, np.array([room[i], *(-q * b[i] for _, b in slopes)])))
        known = [i for i in range(len(room)) if i not in uncertain]
        return Holds(np.vstack([rows, of_floor[known]]), np.concatenate([limits, room[known]]), cones, matrix)

    def _believed(self):
        """Columns L with L Lᵀ the covariance."""
        if self.covariance is None or not self.cart_limits:
            return []
        scale = np.sqrt(np.diagonal(self.covariance))
        scale = np.where(scale > 0, scale, 1.0)
        values, vectors = np.linalg.eigh(self.covariance / np.outer(scale, scale))
        kept = values > 1e-12 * max(1.0, values.max())
        return list((scale[:, None] * vectors[:, kept] * np.sqrt(values[kept])).T)

    def _internal_force(self):
        rows, most, arms = [], [], list(self.arms.values())
        for limit in self.cart_limits:
            if isinstance(limit, InternalForce):
                departs = departures(limit.axis, arms)
                rows += [*departs, *-departs]
                most += [limit.bound] * (2 * len(arms))
        return np.array(rows).reshape(len(rows), 6 * len(arms)), np.array(most)

    def _floor_sides(self, phi, maps):
        """Rows (s, 6n) and limits (s,) of skid and tip-over, from the floor's answer to none and to unit wrenches."""
        floor = [limit for limit in self.cart_limits if isinstance(limit, TipOver | Skid)]
        if not floor:
            return np.zeros((0, maps.shape[1])), np.zeros(0)
        (loads0, lateral0), ones = self._floor(phi, np.zeros(6)), [self._floor(phi, unit) for unit in np.eye(6)]
        loads = np.array([one - loads0 for one, _ in ones]).T @ maps
        lateral = np.array([one - lateral0 for _, one in ones]) @ maps
        rows, limits = [], []
        for limit in floor:
            if isinstance(limit, TipOver):
                rows += [*-loads]
                limits += [*(loads0 - limit.least_load)]
            else:
                fixed = [i for i, wheel in enumerate(self.structure.wheels) if wheel.kind == "fixed"]
                for sign in (1, -1):
                    rows.append(sign * lateral - limit.friction * loads[fixed].sum(axis=0))
                    limits.append(limit.friction * loads0[fixed].sum() - sign * lateral0)
        return np.array(rows), np.array(limits)

    def _floor_slopes(self, direction, maps):
        """Of rows and limits along a direction of phi, by a complex step: nothing is subtracted, so the step may be so
        small that its square is lost. A central difference over 1e-3 of a deviation is 0.8 % off where that deviation
        is eighty times the mass."""
        return tuple(part.imag / STEP for part in self._floor_sides(self.phi + 1j * STEP * direction, maps))

    def _floor(self, phi, wrench):
        """Wheel loads and the floor's lateral push: Newton and Euler in {b}, solved with the constraints' forces."""
        (m, mx, my, J), height, constraints = phi, self.structure.com_height, self.structure.constraints
        u, v, r = constraints.basis_b @ self.velocity
        mass = np.array([[m, 0, -my], [0, m, mx], [-my, mx, J]])
        px, py, _ = mass @ (u, v, r)
        turning = np.array([-r * py, r * px, u * py - v * px])
        k = constraints.n_rows
        held = np.array([[0, 1, constraints.axle_x or 0.0], [0, 0, 1]])[:k]
        system = np.block([[mass, -held.T], [held, np.zeros((k, k))]])
        planar = wrench[[0, 1, 5]]
        solved = np.linalg.solve(system, np.concatenate([planar - turning, np.zeros(k)]))
        along, across, _ = mass @ solved[:3] + turning
        balance = [
            GRAVITY * m - wrench[2],
            GRAVITY * mx + wrench[4] - height * along,
            GRAVITY * my - wrench[3] - height * across,
        ]
        places = np.array([[wheel.x, wheel.y] for wheel in self.structure.wheels]).T
        return np.linalg.pinv([np.ones(places.shape[1]), *places]) @ balance, across - wrench[1]

    # --- what it costs ----------------------------------------------------------------------------------------

    def cost(self):
        """Of the first objective of an order."""
        arms, n = list(self.arms.values()), len(self.last)
        hessian, gradient, rows = np.zeros((n, n)), np.zeros(n), np.zeros((0, n + 1))
        weights, worst = np.diag(np.concatenate([a.weights for a in arms])), 0.0
        parts = _parts(self.objective.first if isinstance(self.objective, Lexicographic) else self.objective)
        if not any(isinstance(part, Nothing) for part in parts):
            hessian += 2 * weights
        for part in parts:
            if isinstance(part, Smoothness):
                hessian += 2 * part.rate * weights
                gradient -= 2 * part.rate * weights @ self.last
            elif isinstance(part, LeastInternalForce):
                departs = departures(part.axis, arms)
                hessian += 2 * part.weight * departs.T @ departs
            elif isinstance(part, LeastJointTorque):
                for i, a in enumerate(arms):
                    if a.joints is not None:
                        own, lever = slice(6 * i, 6 * i + 6), a.joints.jacobian
                        hessian[own, own] += 2 * part.weight * lever @ lever.T
                        gradient[own] += 2 * part.weight * lever @ a.joints.gravity_torque
            elif isinstance(part, LoadShare):
                forces = np.zeros((len(arms), 2, n))
                for i, a in enumerate(arms):
                    forces[i, :, 6 * i : 6 * i + 3] = _turned(a.yaw)[:2]
                for force, a in zip(forces, arms, strict=True):
                    departs = force - part.shares[a.name] * forces.sum(axis=0)
                    hessian += 2 * part.weight * departs.T @ departs
            elif isinstance(part, WorstArm):
                worst = part.weight
                limits = np.concatenate([[*a.force_limit, *a.moment_limit] for a in arms])
                limited = np.isfinite(limits) & (limits > 0)
                share = np.hstack([np.diag(1 / np.where(limited, limits, 1.0)), -np.ones((n, 1))])[limited]
                rows = np.vstack([share, share * ([-1] * n + [1])])
        if not worst:
            return Cost(hessian, gradient, rows)
        wide = np.zeros((n + 1, n + 1))
        wide[:n, :n], wide[n, n] = hessian, 2 * worst
        return Cost(wide, np.append(gradient, 0.0), rows)


def _parts(objective):
    """An objective, its bases, and those of both of an order."""
    found = []
    while objective is not None:
        if isinstance(objective, Lexicographic):
            return [*_parts(objective.first), *_parts(objective.second)]
        found.append(objective)
        objective = getattr(objective, "base", None)
    return found


def _there(rows, limits):
    return rows[np.isfinite(limits)], limits[np.isfinite(limits)]


def _turned(yaw):
    return np.array([[np.cos(yaw), -np.sin(yaw), 0], [np.sin(yaw), np.cos(yaw), 0], [0, 0, 1.0]])


def spatial_map(point, yaw):
    """(6, 6): what a wrench in {a} at a point does to the cart about {b}'s origin: turned, and its lever added."""
    turned, (x, y, z) = _turned(yaw), point
    lever = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.block([[turned, np.zeros((3, 3))], [lever @ turned, turned]])


def departures(axis, arms):
    """(n, 6n): by how much each hand's force along an axis is from the mean of all."""
    along = np.zeros((len(arms), 6 * len(arms)))
    for i, a in enumerate(arms):
        along[i, 6 * i : 6 * i + 3] = np.asarray(axis) / np.linalg.norm(axis) @ _turned(a.yaw)
    return along - along.mean(axis=0)


def within(arm, point):
    """Whether a point is one of an arm's candidates, in its reach."""
    near = [np.linalg.norm(point - np.array(p)) for p in arm.contacts.points]
    for segment in arm.contacts.segments:
        ends = np.array([segment.start, segment.stop])
        apart = [np.linalg.norm(point - one) for one in ends]
        near.append(sum(apart) - np.linalg.norm(ends[1] - ends[0]))
    return min(near) <= 1e-9 and in_reach(arm, point)


def in_reach(arm, point):
    return arm.reach is None or bool((arm.reach.normals @ point <= arm.reach.offsets + 2e-9).all())


def apart(points):
    """Least distance of any two."""
    return min((np.linalg.norm(a - b) for i, a in enumerate(points) for b in points[:i]), default=np.inf)
