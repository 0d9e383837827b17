"""Random problems, and small carts and arms that many tests share."""

from __future__ import annotations

from functools import cache

import numpy as np
from scipy.optimize import linprog
from scipy.spatial import ConvexHull

from cartgrasp.arms import Arm, Friction
from cartgrasp.constraints import RollingConstraints
from cartgrasp.contacts import grasp_map_planar
from cartgrasp.friction import SoftFinger
from cartgrasp.inertia import Inertia
from cartgrasp.joint_torques import JointTorques
from cartgrasp.model import CartModel

FORCE, MOMENT = (60.0, 60.0, 40.0), (8.0, 8.0, 6.0)


def cart(rows=1, axle_x=0.0):
    """With 0, 1 or 2 constraint rows."""
    constraints = RollingConstraints(None if rows == 0 else axle_x, no_rotation=rows == 2)
    return CartModel(Inertia(24.0, (0.3, 0.0), 2.0), constraints)


def arm(name="left", contacts=((-0.25, 0.2, 1.0),), **changes):
    values = {
        "force_limit": FORCE,
        "moment_limit": MOMENT,
        "friction": Friction(0.6, 4),
    } | changes
    return Arm(name, contacts, **values)


def bar(name="left", low=-0.25, high=0.25, **changes):
    """An arm that may hold anywhere on a straight handle along y."""
    return arm(name, (), segment=((-0.25, low, 1.0), (-0.25, high, 1.0)), **changes)


class StretchedArm:
    """Postures of one joint that bears fx: 40 N near, 20 N beyond 0.3 m from {b}'s origin."""

    near, far = (JointTorques(np.eye(6)[:, :1], [0.0], [limit]) for limit in (40.0, 20.0))

    def joints_at(self, contact, _yaw):
        return self.far if abs(contact[0]) > 0.3 else self.near


def random_cart(rng):
    return cart(int(rng.integers(0, 3)), float(rng.uniform(-0.3, 0.3)))


def random_arms(rng, n, n_points=1, sides=None):
    """Arms with every mix of limits: with and without friction, unlimited, and with limits of zero."""
    arms = []
    for i in range(n):
        force, moment = rng.uniform(5, 60, 3), rng.uniform(0.5, 8, 3)
        if rng.random() < 0.2:
            moment[rng.integers(3)] = 0.0
        if rng.random() < 0.2:
            force[:] = np.inf
        kind = rng.choice([0, 3, 4, 8]) if sides is None else sides
        friction = None if kind == 0 else Friction(float(rng.uniform(0.2, 1.0)), kind if sides else int(kind))
        points = rng.uniform((-0.5, -0.5, 0.8), (0.5, 0.5, 1.2), (n_points, 3))
        weights = rng.uniform(0.5, 12, 6)
        more = {} if sides is not None else random_strength(rng)
        arms.append(
            Arm(
                f"arm{i}",
                points.tolist(),
                yaw=float(rng.uniform(-0.8, 0.8)),
                force_limit=force,
                moment_limit=moment,
                friction=friction,
                weights=weights,
                **more,
            )
        )
    return arms


def random_strength(rng):
    """What some arms state beside a wrench box: push only, a payload, joints that bear so much, soft fingers."""
    more = {}
    if rng.random() < 0.2:
        more["push_only"] = True
    if rng.random() < 0.2:
        more["payload"] = float(rng.uniform(0.1, 5))
    if rng.random() < 0.2:
        at_rest, n = rng.uniform(-5, 5, 7), 7
        more["joints"] = JointTorques(rng.uniform(-1, 1, (6, n)), at_rest, np.abs(at_rest) + rng.uniform(0, 30, n))
    if rng.random() < 0.2:
        grip, sides = float(rng.choice([0.0, 30.0])), int(rng.choice([3, 4, 8]))
        more["soft_finger"] = SoftFinger(float(rng.uniform(0.2, 1)), float(rng.uniform(0.01, 0.1)), grip, "z", sides)
    return more


def replace_friction(a, friction):
    return Arm(
        a.name,
        a.contacts,
        yaw=a.yaw,
        force_limit=a.force_limit,
        moment_limit=a.moment_limit,
        friction=friction,
        weights=a.weights,
        push_only=a.push_only,
        payload=a.payload,
        joints=a.joints,
        soft_finger=a.soft_finger,
    )


def first_contacts(arms):
    return {a.name: np.array(a.contacts.first) for a in arms}


def linear_limits(arms):
    """Limits as (C, d, bounds) written down independently of planning.limits."""
    rows, limits, bounds = [], [], []
    for i, a in enumerate(arms):
        for j, limit in enumerate([*a.force_limit, *a.moment_limit]):
            limit = min(limit, 9.81 * a.payload) if j == 2 else limit
            low = 0.0 if (a.friction is not None or a.push_only) and j == 0 else -limit
            bounds.append((None if np.isinf(low) else low, None if np.isinf(limit) else limit))
        if a.joints is not None:
            wide = np.zeros((a.joints.n_joints, 6 * len(arms)))
            wide[:, 6 * i : 6 * i + 6] = a.joints.jacobian.T
            at_rest, most = a.joints.gravity_torque, a.joints.torque_limit
            rows += [*wide[np.isfinite(most)], *-wide[np.isfinite(most)]]
            limits += [*(most - at_rest)[np.isfinite(most)], *(most + at_rest)[np.isfinite(most)]]
        if a.soft_finger is not None:
            normals, distances = soft_finger_sides(a.soft_finger)
            wide = np.zeros((len(normals), 6 * len(arms)))
            wide[:, 6 * i : 6 * i + 6] = normals
            rows += [*wide]
            limits += [*distances]
            if not a.soft_finger.grip:
                bounds[6 * i + 2] = (0.0, bounds[6 * i + 2][1])
        if a.friction is None:
            continue
        sides, mu = a.friction.sides, a.friction.mu
        angles = 2 * np.pi * np.arange(sides) / sides
        corners = list(np.stack([np.cos(angles), np.sin(angles)], axis=-1))  # times mu: a mu of 0 has sides too
        for one, other in zip(corners, corners[1:] + corners[:1], strict=True):
            normal = np.array([other[1] - one[1], one[0] - other[0]])  # outward for a walk against the clock
            normal /= np.linalg.norm(normal)
            row = np.zeros(6 * len(arms))
            row[6 * i : 6 * i + 3] = [-mu * (normal @ one), *normal]
            rows.append(row)
            limits.append(0.0)
    matrix = np.array(rows).reshape(len(rows), 6 * len(arms))
    return matrix, np.array(limits), bounds


@cache
def soft_finger_sides(finger):
    """Of pads whose normal is z, as the hull of corners on the ellipsoid: rows (k, 6) and limits (k,)."""
    rings = max(1, round(finger.sides / 4))
    up, around = np.pi / 2 * np.arange(-rings, rings + 1) / rings, 2 * np.pi * np.arange(finger.sides) / finger.sides
    corners = [(np.cos(b) * np.cos(a), np.cos(b) * np.sin(a), np.sin(b)) for b in up for a in around]
    sides = ConvexHull(np.unique(np.round(corners, 14), axis=0)).equations  # of triangles, some in one plane
    rows = np.zeros((len(sides), 6))
    rows[:, :2], rows[:, 5] = sides[:, :2], sides[:, 2] / finger.twist_radius
    if not finger.grip:
        rows[:, 2] = finger.mu * sides[:, 3]
    return rows, -sides[:, 3] * finger.mu * 2 * finger.grip


def effective_matrix(model, arms, contacts):
    maps = [grasp_map_planar(contacts[a.name], a.yaw) for a in arms]
    return model.constraints.basis_b.T @ np.hstack(maps)


def support(model, arms, contacts, direction):
    """Most that the arms can give along a direction of (fx, fy, tau), by HiGHS; infinite if without limit."""
    matrix, limits, bounds = linear_limits(arms)
    maps = np.hstack([grasp_map_planar(contacts[a.name], a.yaw) for a in arms])
    found = linprog(-(np.asarray(direction) @ maps), matrix, limits, bounds=bounds, method="highs")
    return np.inf if found.status == 3 else -found.fun


def is_feasible(model, arms, contacts, wrench):
    matrix, limits, bounds = linear_limits(arms)
    equality = effective_matrix(model, arms, contacts)
    target = model.constraints.basis_b.T @ np.asarray(wrench)
    found = linprog(np.zeros(6 * len(arms)), matrix, limits, equality, target, bounds=bounds, method="highs")
    return found.status == 0


def largest_scale(model, arms, contacts, wrench):
    """The largest t such that t times the wrench is feasible, by HiGHS; infinite if every t is."""
    matrix, limits, bounds = linear_limits(arms)
    equality = effective_matrix(model, arms, contacts)
    target = model.constraints.basis_b.T @ np.asarray(wrench)
    cost = np.zeros(6 * len(arms) + 1)
    cost[-1] = -1.0
    wide = np.hstack([matrix, np.zeros((len(matrix), 1))])
    equal = np.hstack([equality, -target[:, None]])
    tight = {"primal_feasibility_tolerance": 1e-10, "dual_feasibility_tolerance": 1e-10}
    wider = [*bounds, (0, None)]
    zero = np.zeros(len(target))
    found = linprog(cost, wide, limits, equal, zero, bounds=wider, method="highs", options=tight)
    return np.inf if found.status == 3 else -found.fun


def violation(arms, wrenches):
    """By how much wrenches break the limits, written down independently."""
    matrix, limits, bounds = linear_limits(arms)
    x = np.concatenate([wrenches[a.name] for a in arms])
    lower = np.array([-np.inf if low is None else low for low, _ in bounds])
    upper = np.array([np.inf if high is None else high for _, high in bounds])
    rows = matrix @ x - limits if len(matrix) else np.zeros(1)
    return max(0.0, float(np.max(x - upper)), float(np.max(lower - x)), float(np.max(rows)))
