"""A made-up push, with which an online estimator does once all that it may have to do later."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from cartgrasp.model import CartModel
from cartgrasp.motion import Measurement

WARM_UP_PERIOD, WARM_UP_SAMPLES, WARM_UP_SPEED, WARM_UP_ANGULAR_FREQUENCY = 0.02, 160, 0.5, 4.0
"""s, samples, m/s and rad/s: long enough for what looks at two seconds of rows, and with forces that tell a mass."""


def synthetic_push(cart: CartModel, arms: Sequence[str]) -> Iterator[Measurement]:
    """Faster and slower along the first of the cart's free directions, by the wrench that the model wants."""
    along = WARM_UP_SPEED * np.eye(cart.constraints.n_free)[0]
    contacts = dict.fromkeys(arms, np.array([0.0, 0.0, 1.0]))
    for time in (WARM_UP_PERIOD * np.arange(WARM_UP_SAMPLES)).tolist():
        turned = WARM_UP_ANGULAR_FREQUENCY * time
        nu, rise = (1.0 + math.sin(turned)) * along, WARM_UP_ANGULAR_FREQUENCY * math.cos(turned) * along
        fx, fy, tau = cart.planar_wrench(cart.required_wrench(cart.state(velocity=nu), rise)) / len(arms)
        wrenches = dict.fromkeys(arms, np.array([fx, fy, 0.0, 0.0, 0.0, tau]))
        way = time + (1.0 - math.cos(turned)) / WARM_UP_ANGULAR_FREQUENCY
        yield Measurement(time, way * cart.basis_b @ along, cart.basis_b @ nu, wrenches, contacts)
