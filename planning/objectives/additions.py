"""What may be added to the cost of a base, quadratic in the wrenches."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from cartgrasp.arms import Arm
from cartgrasp.checks import MAX_FLOAT, check_kind, number
from cartgrasp.errors import UsageError
from cartgrasp.frames import Array, rotation_planar
from planning.limits.internal_force import HANDLE_AXIS_B, departures_along, direction_b

from .objective import Addition, Cost, Objective, WeightedWrench


@dataclass(frozen=True)
class Smoothness(Addition):
    """Penalises change: `base + sum rate weight (F - F_previous)²`. `rate` scales each arm's own weights: 1 makes a
    change as costly as the wrench itself."""

    rate: float = 1.0
    base: Objective = field(default_factory=WeightedWrench)

    def __post_init__(self) -> None:
        number("smoothness: rate", self.rate, 0.0, MAX_FLOAT)

    @property
    def looks_back(self) -> bool:
        return True

    def cost(self, arms: Sequence[Arm], previous: Array) -> Cost:
        base = self.base.cost(arms, previous)
        added = self.rate * np.concatenate([arm.weights for arm in arms])
        n_own = len(base.weights) - len(added)
        return replace(
            base,
            weights=base.weights + np.pad(added, (0, n_own)),
            gradient=base.gradient - np.pad(2 * added * previous, (0, n_own)),
            constant=base.constant + float(added @ previous**2),
        )


@dataclass(frozen=True)
class LoadShare(Addition):
    """Penalises departure from stated shares of the load: `base + weight sum_i ‖f_i - share_i sum_j f_j‖²`, with f_i
    the horizontal force of arm i in {b}, N. Shares by arm name; they are >= 0 and add up to 1."""

    shares: Mapping[str, float]
    weight: float = 1.0
    base: Objective = field(default_factory=WeightedWrench)

    def __post_init__(self) -> None:
        check_kind("load share: shares", self.shares, Mapping, "write {'left': 0.7, 'right': 0.3}")
        shares = [number(f"load share: {arm}", share, 0.0, 1.0) for arm, share in self.shares.items()]
        if not (shares and abs(sum(shares) - 1) <= 1e-9):
            raise UsageError(f"load share: {dict(self.shares)} are not shares >= 0 that add up to 1")
        number("load share: weight", self.weight, 0.0, MAX_FLOAT)
        object.__setattr__(self, "shares", dict(self.shares))  # the caller may go on with theirs

    def cost(self, arms: Sequence[Arm], previous: Array) -> Cost:
        if {arm.name for arm in arms} != set(self.shares):
            raise UsageError(f"load share: shares of {sorted(self.shares)}, arms {sorted(a.name for a in arms)}")
        forces = np.zeros((len(arms), 2, 6 * len(arms)))  # f_i = forces[i] @ F
        for i, arm in enumerate(arms):
            forces[i, :, 6 * i : 6 * i + 2] = rotation_planar(arm.yaw)
        shares = np.array([self.shares[arm.name] for arm in arms])
        departure = (forces - shares[:, None, None] * forces.sum(axis=0)).reshape(-1, 6 * len(arms))
        return self.base.cost(arms, previous).coupled(self.weight * departure.T @ departure)


@dataclass(frozen=True)
class LeastJointTorque(Addition):
    """Penalises what the joints bear: `base + weight sum_i ‖J_iᵀ F_i + tau_0i‖²`, over arms that state their joints;
    `weight` per (N·m)²."""

    weight: float = 1.0
    base: Objective = field(default_factory=WeightedWrench)

    def __post_init__(self) -> None:
        number("least joint torque: weight", self.weight, 0.0, MAX_FLOAT)

    def cost(self, arms: Sequence[Arm], previous: Array) -> Cost:
        if all(arm.joints is None for arm in arms):
            raise UsageError(f"least joint torque: none of {[arm.name for arm in arms]} states its joints")
        base = self.base.cost(arms, previous)
        n = len(base.weights)
        coupling, gradient, constant = np.zeros((n, n)), base.gradient.copy(), base.constant
        for i, arm in enumerate(arms):
            if arm.joints is not None:
                own, jacobian, gravity = slice(6 * i, 6 * i + 6), arm.joints.jacobian, arm.joints.gravity_torque
                coupling[own, own] = self.weight * jacobian @ jacobian.T
                gradient[own] += 2 * self.weight * jacobian @ gravity
                constant += self.weight * float(gravity @ gravity)
        return replace(base.coupled(coupling), gradient=gradient, constant=constant)


@dataclass(frozen=True)
class LeastInternalForce(Addition):
    """Penalises hands that work against each other along a handle: `base + weight sum_i (a_i - mean a)²`, with a_i the
    force of hand i along `axis` in {b}, N; `weight` per N². See `planning.limits.internal_force`."""

    weight: float = 1.0
    axis: tuple[float, float, float] = HANDLE_AXIS_B
    base: Objective = field(default_factory=WeightedWrench)

    def __post_init__(self) -> None:
        number("least internal force: weight", self.weight, 0.0, MAX_FLOAT)
        object.__setattr__(self, "axis", direction_b("least internal force: axis", self.axis))

    def cost(self, arms: Sequence[Arm], previous: Array) -> Cost:
        departures = departures_along(self.axis, arms).reshape(len(arms), -1)
        return self.base.cost(arms, previous).coupled(self.weight * departures.T @ departures)


@dataclass(frozen=True)
class LeastSideForce(Addition):
    """Spares the fixed wheels: `base + weight lambda²`, lambda (N) being what the floor gives them sideways; `weight`
    per N².

    For what is asked of the cart, lambda is what they take of hands without any force across them, less the hands'
    force across. The first part changes with the wrench, the cart and its motion: the planner fills it in at each tick
    (`AllocationTemplate.cost`). A relaxed plan weighs lambda as if all that was asked were given."""

    weight: float = 1.0
    base: Objective = field(default_factory=WeightedWrench)

    def __post_init__(self) -> None:
        number("least side force: weight", self.weight, 0.0, MAX_FLOAT)

    def cost(self, arms: Sequence[Arm], previous: Array) -> Cost:
        base = self.base.cost(arms, previous)
        return replace(base, side_weight=base.side_weight + self.weight)
