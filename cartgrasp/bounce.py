"""How a cart bounces where an effect has a wall (`effects/end_stop.py`), for whoever integrates its motion in steps.

An impulse along the wall's normal, at {b}'s origin, without friction: with n = e_xᵀ R(theta) S the speed towards the
wall is n nu, and

    nu⁺ = nu⁻ - (1 + e) (n nu⁻) M⁻¹ nᵀ / (n M⁻¹ nᵀ),    so n nu⁺ = -e n nu⁻.

A step goes through the wall first. When in it the wall was reached is known from depth and speed at both ends; what
comes after is moved by the change of velocity times what is left of the step. A bounce that would be over before the
step is, so that the wall were passed again, ends at rest there: a cart that is pressed against a stop comes to stay.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from .effects.effect import Wall
from .frames import Array, body_to_world
from .model import CartModel

MIN_APPROACH_FRACTION = 1e-6
"""Least share of a cart's speeds that takes it towards a wall; below it, the cart rolls along the wall and never
reaches it."""


def walls_of(cart: CartModel) -> tuple[Wall, ...]:
    return tuple(wall for effect, _, _ in cart.force_effects if (wall := effect.wall) is not None)


def bounced(cart: CartModel, before: Array, after: Array, time: Any, step: Any) -> Array:
    """The state (..., n) at the end of a step (s), at `time`, from what it was `before` the step and what it is `after`
    it where nothing stands in the way. A cart beyond a wall gets no further, and may come back."""
    for wall in walls_of(cart):
        after = _against(cart, wall, before, after, (time, step))
    return after


def _against(cart: CartModel, wall: Wall, before: Array, after: Array, clock: tuple[Any, Any]) -> Array:
    time, step = clock
    depth, end = (wall.side * (state[..., 0] - wall.position) for state in (before, after))
    limit = np.maximum(depth, 0.0)
    rows, free = cart.velocity_slice, cart.basis_b
    normal = wall.side * body_to_world(after[..., 2])[..., 0, :]
    ways = normal @ free
    hit = (end > limit) & ((ways**2).sum(axis=-1) > MIN_APPROACH_FRACTION**2)
    if not hit.any():
        return after
    answers = cart.rate(after, np.zeros(3), time=time).by_wrench[..., rows, :]  # M⁻¹ Sᵀ, also of what swings too much
    answer = (answers @ normal[..., None])[..., 0]
    answer = answer / np.maximum((ways * answer).sum(axis=-1), np.finfo(float).tiny)[..., None]
    speeds = (wall.side * (body_to_world(s[..., 2]) @ free @ s[..., rows, None])[..., 0, 0] for s in (before, after))
    share, speed = _reached(limit - depth, end - depth, step, *speeds)
    change = -(1.0 + wall.restitution) * speed
    left = end + change * (1.0 - share) * step - limit
    stays = left > 0.0
    moved = np.where(stays, limit - end, change * (1.0 - share) * step)
    velocity = after[..., rows] + change[..., None] * answer
    inward = np.maximum((ways * velocity).sum(axis=-1), 0.0)
    velocity = velocity - np.where(stays, inward, 0.0)[..., None] * answer
    found = after.copy()
    found[..., rows] = velocity
    found[..., :3] += (body_to_world(after[..., 2]) @ free @ (moved[..., None] * answer)[..., None])[..., 0]
    return np.where(hit[..., None], found, after)


def _reached(room: Array, way: Array, step: Any, first: Array, last: Array) -> tuple[Array, Array]:
    """The share of a step after which a way (m) that is longer than the room for it fills that, and the speed there.
    The acceleration is steady; `first` and `last` are the speeds at both ends."""
    straight = step * first
    bend = way - straight
    root = np.sqrt(np.maximum(straight**2 + 4.0 * bend * room, 0.0))
    with np.errstate(invalid="ignore", divide="ignore"):
        forward = 2.0 * room / (straight + root)
        turning = (root - straight) / (2.0 * bend)
    share = np.where(straight > 0.0, forward, turning)
    share = np.clip(np.nan_to_num(share, nan=0.0, posinf=1.0, neginf=0.0), 0.0, 1.0)
    return share, np.maximum(first + share * (last - first), 0.0)
