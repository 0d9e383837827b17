"""What is believed of a motion before anything is known of it but, in parts, the pose."""

from __future__ import annotations

import numpy as np

from cartgrasp.frames import Array
from cartgrasp.model import CartModel

from ..noise import FilterNoise

MAX_TRACKING_GAP = 1.0
"""s without a sample after which the motion may be any again."""


def first_motion(cart: CartModel, noise: FilterNoise, pose: Array) -> tuple[Array, Array]:
    """Mean and variances (n,) of `(pose, nu, memory)`, from a pose (3,) that may be NaN in parts."""
    known = np.isfinite(pose)
    mean = cart.state(np.where(known, pose, 0.0))
    variances = np.ones(len(mean))
    variances[:3] = np.where(known, np.diag(noise.pose_covariance), 100.0)
    variances[cart.memory_slice] = cart.memory_spread**2
    return mean, variances
