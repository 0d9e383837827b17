"""How much a model leaves, in N and N·m: what its residual scatters beyond noise, and what pushes rollouts away."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from cartgrasp.frames import Array
from cartgrasp.model import CartModel

from .gap import Gap
from .generic import Dependence
from .held_out import BEYOND_NOISE, HORIZON
from .polygon import Polygon
from .rollouts import COORDINATES
from .scatter import Scatter

FREE = {1: (0,), 2: (0, 2), 3: (0, 1, 2)}
"""Which coordinates of a rollout are free directions."""


def beyond_noise(scatter: Scatter) -> Array:
    """Root mean square of the residual's means (f,), less their noise."""
    return np.asarray(np.sqrt(np.maximum((scatter.mean**2 - scatter.std**2).mean(axis=0), 0.0)))


def followed(polygon: Polygon, dependences: Sequence[Dependence]) -> Array:
    """Root mean square (f,) of the largest part of the residual that follows something, as of a constant that is as
    sure."""
    found = np.zeros(polygon.value.shape[1])
    for one in dependences:
        constant = np.square(polygon.whitened(one.direction, np.ones((len(polygon.time), 1)))).sum()
        taken = one.share * np.square(polygon.standard(one.direction)).sum()
        found[one.direction] = max(found[one.direction], np.sqrt(taken / constant))
    return found


def missing_push(gap: Gap, cart: CartModel) -> Array:
    """Wrench (f,) that is missing all along rollouts from the held-out stretches, root mean square, where they end
    farther away than noise takes them: an acceleration a misses by `a T² / 2`."""
    f = cart.constraints.n_free
    if gap.after <= BEYOND_NOISE * gap.noise_floor:
        return np.zeros(f)
    told = [gap.per_coordinate[COORDINATES[i]] for i in FREE[f]]
    missed = np.sqrt([max(one["after"] ** 2 - one["noise_floor"] ** 2, 0.0) for one in told])
    mass = cart.regressor(np.zeros((f, f)), np.eye(f)) @ cart.inertia.phi
    return np.asarray(np.sqrt((mass**2) @ (2 * missed / HORIZON**2) ** 2))
