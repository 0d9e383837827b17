"""What a model leaves out of a row, as declared."""

from __future__ import annotations

from estimation.online.kernels.row_algebra import UnmodelledNoise
from estimation.online.regressor.filtered_row import one_disturbance


def unmodelled_noise(cart, noise, scaled):
    """Disturbances are as loud as ever; a row is linear in the products of the `scaled` parameters with the mass."""
    density = noise.disturbance**2 * one_disturbance(cart, noise)
    return UnmodelledNoise(density, density, 1.0, scaled)
