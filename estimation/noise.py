"""Noise, in physical units: of the sensors, and of what the model leaves out."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields, replace

import numpy as np

from cartgrasp.checks import MAX_FLOAT, number
from cartgrasp.frames import Array
from cartgrasp.model import CartModel

SIDE_PUSH_DENSITY = 20.0
"""N m/√s: 40 N aside for a second at 0.5 m/s."""


@dataclass(frozen=True)
class FilterNoise:
    """How loud sensors are (standard deviations of one sample), and what the model leaves out (per √s).

    Args:
        position: Of a pose, m.
        heading: Of a pose, rad.
        linear_velocity: m/s.
        yaw_rate: rad/s.
        force: Of each axis of a wrench, N.
        moment: Of each axis of a wrench, N·m.
        disturbance: A force that is not in the model, N·√s; a moment by `lever`.
        lever: m.
        slip: How far wheels creep sideways and turn, m/√s and rad/√s.
        swivel: The same of casters' headings, rad/√s; of other memories in proportion to how far they may be off at
            first.
        parameter_drift: Share of each prior's standard deviation by which a parameter drifts in the paper's filter,
            1/√s; the others forget what is older than minutes.

    Raises:
        UsageError: One is negative or not finite.

    Example:
        >>> from estimation import FilterNoise
        >>> FilterNoise(force=1.0, moment=0.05).wrench_covariance.diagonal().round(4).tolist()  # N², N²·m²
        [1.0, 1.0, 1.0, 0.0025, 0.0025, 0.0025]
    """

    position: float = 0.0005
    heading: float = 0.0005
    linear_velocity: float = 0.005
    yaw_rate: float = 0.005
    force: float = 3.0
    moment: float = 0.1
    disturbance: float = 0.05
    lever: float = 0.3
    slip: float = 0.0002
    swivel: float = 0.2
    parameter_drift: float = 0.002

    def __post_init__(self) -> None:
        for item in fields(self):
            number(f"noise: {item.name}", getattr(self, item.name), 0.0, MAX_FLOAT)

    def sideways(self, cart: CartModel) -> float:
        """How far wheels creep sideways, m/√s: what they are known to (`lateral_slip`) is no sensor of side force."""
        return math.hypot(self.slip, SIDE_PUSH_DENSITY * cart.slip_compliance)

    def wrench_scale(self, cart: CartModel) -> Array:
        """Scale of each component of the reduced wrench, for a force of 1 N: moments have the lever."""
        scale = {0: [1.0, 1.0, self.lever], 1: [1.0, self.lever], 2: [1.0]}
        return np.array(scale[cart.constraints.n_rows])

    def scaled(self, variance_factors: Array) -> FilterNoise:
        """With variances of velocities, linear and yaw (2,), that are so many times as large."""
        linear, yaw = np.sqrt(variance_factors).tolist()
        return replace(self, linear_velocity=linear * self.linear_velocity, yaw_rate=yaw * self.yaw_rate)

    @property
    def pose_covariance(self) -> Array:
        return np.diag([self.position, self.position, self.heading]) ** 2

    @property
    def velocity_covariance(self) -> Array:
        return np.diag([self.linear_velocity, self.linear_velocity, self.yaw_rate]) ** 2

    @property
    def wrench_covariance(self) -> Array:
        """Covariance (6, 6) of one arm's spatial wrench."""
        return np.diag([self.force] * 3 + [self.moment] * 3) ** 2
