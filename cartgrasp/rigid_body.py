"""The planar rigid body in body components, linear in phi (physics.md).

With `a = (u' - w r, w' + u r)` the acceleration of {b}'s origin and r' the yaw acceleration,

    fx  = m ax - m dx r² - m dy r'
    fy  = m ay + m dx r' - m dy r²
    tau = m dx ay - m dy ax + J r'
"""

from __future__ import annotations

import numpy as np

from .frames import Array, components


def regressor_b(velocity_b: Array, acceleration_b: Array) -> Array:
    """Y with `wrench_b = Y @ phi`, (..., 3, 4), from (u, w, r) and its rate (u', w', r')."""
    u, w, r = components(velocity_b)
    du, dw, dr = components(acceleration_b)
    ax, ay = du - w * r, dw + u * r
    regressor = np.zeros((*np.broadcast_shapes(u.shape, du.shape), 3, 4))
    regressor[..., 0, 0], regressor[..., 0, 1], regressor[..., 0, 2] = ax, -(r**2), -dr
    regressor[..., 1, 0], regressor[..., 1, 1], regressor[..., 1, 2] = ay, dr, -(r**2)
    regressor[..., 2, 1], regressor[..., 2, 2], regressor[..., 2, 3] = ay, -ax, dr
    return regressor


def mass_matrix_b(phi: Array) -> Array:
    """M_b, (..., 3, 3), with `wrench_b = M_b @ (u', w', r') + bias`."""
    m, mx, my, J = components(phi)
    matrix = np.zeros((*m.shape, 3, 3))
    matrix[..., 0, 0] = matrix[..., 1, 1] = m
    matrix[..., 0, 2] = matrix[..., 2, 0] = -my
    matrix[..., 1, 2] = matrix[..., 2, 1] = mx
    matrix[..., 2, 2] = J
    return matrix


def bias_b(velocity_b: Array, phi: Array) -> tuple[Array, Array]:
    """Velocity-dependent wrench (..., 3) and its partials by (u, w, r), (..., 3, 3)."""
    u, w, r = components(velocity_b)
    m, mx, my, _ = components(phi)
    value = np.empty((*np.broadcast_shapes(u.shape, m.shape), 3))
    value[..., 0] = -m * w * r - mx * r**2
    value[..., 1] = m * u * r - my * r**2
    value[..., 2] = mx * u * r + my * w * r
    partials = np.zeros((*value.shape, 3))
    partials[..., 0, 1], partials[..., 0, 2] = -m * r, -m * w - 2 * mx * r
    partials[..., 1, 0], partials[..., 1, 2] = m * r, m * u - 2 * my * r
    partials[..., 2, 0], partials[..., 2, 1] = mx * r, my * r
    partials[..., 2, 2] = mx * u + my * w
    return value, partials
