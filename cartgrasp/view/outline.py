"""How large a cart is drawn."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from ..frames import Array
from ..model import CartModel

OUTLINE_MARGIN = 0.08
"""m, from the wheels to the drawn edge of the body."""

Outline = tuple[float, float, float, float]
"""(x_min, x_max, y_min, y_max) in {b}, m."""


def body_outline(cart: CartModel | None, contacts: Iterable[Array]) -> Outline:
    """Round wheels and CoM, a box of the same inertia, or, of a cart that isn't known, round {b}'s origin and the usual
    contact of each arm, out of (n, 3)."""
    if cart is None:
        known = (contact[np.isfinite(contact[:, :2]).all(axis=1), :2] for contact in contacts)
        return _round(np.array([(0.0, 0.0), *(np.median(held, axis=0) for held in known if len(held))]))
    (x, y), about_com, mass = cart.inertia.com, cart.inertia.about_com, cart.inertia.mass
    if not cart.wheels:
        half_width = float(np.sqrt(3.0 * about_com / mass / 3.25))
        return x - 1.5 * half_width, x + 1.5 * half_width, y - half_width, y + half_width
    return _round(np.array([*((w.x, w.y) for w in cart.wheels), (x, y)]))


def _round(points: Array) -> Outline:
    centre, half = (points.min(0) + points.max(0)) / 2, (points.max(0) - points.min(0)) / 2
    half = np.maximum(half + OUTLINE_MARGIN, 0.15)
    low, high = centre - half, centre + half
    return float(low[0]), float(high[0]), float(low[1]), float(high[1])
