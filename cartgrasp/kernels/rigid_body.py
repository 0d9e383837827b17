"""The planar rigid body of `cartgrasp/rigid_body.py`, whose formulas these mirror; a test compares the two."""

from __future__ import annotations

from cartgrasp.frames import Array

from .jit import compiled
from .situation import Twist

Row = tuple[float, float, float, float]
MAX_SWINGING_FRACTION = 0.95
"""Share of the inertia along {b}'s x of a cart that nothing else holds, 1 / (M_b⁻¹)_xx, that may swing at most."""


@compiled
def regressor(velocity: Twist, acceleration: Twist) -> tuple[Row, Row, Row]:
    """Y (3, 4) with `wrench_b = Y @ phi`."""
    (u, w, r), (du, dw, turn) = velocity, acceleration
    ax, ay = du - w * r, dw + u * r
    return (ax, -r * r, -turn, 0.0), (ay, turn, -r * r, 0.0), (0.0, ay, -ax, turn)


@compiled
def mass_matrix(phi: Array) -> tuple[Twist, Twist, Twist]:
    m, mx, my, J = phi[0], phi[1], phi[2], phi[3]
    return (m, 0.0, -my), (0.0, m, mx), (-my, mx, J)


@compiled
def by_velocity(velocity: Twist, phi: Array) -> tuple[Twist, Twist, Twist]:
    """Partials (3, 3) of `Y @ phi`."""
    u, w, r = velocity
    m, mx, my = phi[0], phi[1], phi[2]
    return (
        (0.0, -m * r, -m * w - 2.0 * mx * r),
        (m * r, 0.0, m * u - 2.0 * my * r),
        (mx * r, my * r, mx * u + my * w),
    )


@compiled
def most_swinging(phi: Array) -> tuple[float, Row]:
    """Mass (kg) along {b}'s x without which M_b stays positive, with some left, and its partials by phi."""
    m, mx, my, J = phi[0], phi[1], phi[2], phi[3]
    about = J - mx**2 / m
    slope = (my / about) ** 2
    by_phi = 1.0 + slope * (mx / m) ** 2, -2.0 * slope * mx / m, -2.0 * my / about, slope
    share = MAX_SWINGING_FRACTION
    return share * (m - my**2 / about), (share * by_phi[0], share * by_phi[1], share * by_phi[2], share * by_phi[3])
