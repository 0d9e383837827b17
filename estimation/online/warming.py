"""A made-up push, with which an online estimator does once all that it may have to do later."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from cartgrasp.model import CartModel
from cartgrasp.motion import Measurement

PERIOD, COUNT, SPEED = 0.02, 160, 0.5
"""s, samples, m/s: long enough for what looks at two seconds of rows."""


def made_up_push(cart: CartModel, arms: Sequence[str]) -> Iterator[Measurement]:
    """At a constant speed along the first of the cart's free directions, by the wrench that the model wants."""
    n = cart.constraints.n_free
    nu = SPEED * np.eye(n)[0]
    along = cart.basis_b @ nu
    fx, fy, tau = cart.planar_wrench(cart.required_wrench(cart.state(velocity=nu), np.zeros(n))) / len(arms)
    wrenches = dict.fromkeys(arms, np.array([fx, fy, 0.0, 0.0, 0.0, tau]))
    contacts = dict.fromkeys(arms, np.array([0.0, 0.0, 1.0]))
    for i in range(COUNT):
        yield Measurement(i * PERIOD, i * PERIOD * along, along, wrenches, contacts)
