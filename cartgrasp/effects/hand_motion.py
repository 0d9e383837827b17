"""How a hand moves with the cart that it holds, for sensors that feel what hangs on them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..frames import Array, rotation_planar


class HandMotion(NamedTuple):
    """In {a}: acceleration (..., 3) of its origin, m/s², without gravity; yaw rate (...), rad/s, and its rate (...),
    rad/s²."""

    acceleration: Array
    yaw_rate: Array
    yaw_acceleration: Array

    @classmethod
    def of(cls, velocity_b: Array, rate_b: Array, contact_b: ArrayLike, yaw: ArrayLike = 0.0) -> HandMotion:
        """The motion of a hand that holds at a point (..., 3) of {b}. {b} moves at (u, w, r) (..., 3), and `rate_b`
        (..., 3) is (u', w', r'). With q the point, `a = (u' - r w, w' + r u) + r' z x q - r² q`."""
        (u, w, r), (u_rate, w_rate, r_rate) = (np.moveaxis(part, -1, 0) for part in (velocity_b, rate_b))
        x, y, _ = np.moveaxis(np.asarray(contact_b, dtype=float), -1, 0)
        forward = u_rate - r * w - r_rate * y - r * r * x
        left = w_rate + r * u + r_rate * x - r * r * y
        in_a = (rotation_planar(-np.asarray(yaw, dtype=float)) @ np.stack([forward, left], -1)[..., None])[..., 0]
        return cls(np.concatenate([in_a, np.zeros((*in_a.shape[:-1], 1))], axis=-1), r, r_rate)


HAND_AT_REST = HandMotion(np.zeros(3), np.zeros(()), np.zeros(()))
