"""Rows of the regression, and what a model leaves out of them, as declared."""

from __future__ import annotations

from estimation.online.kernels.row_algebra import UnmodelledNoise
from estimation.online.regressor.filtered_row import AskedRow, one_disturbance


def unmodelled_noise(cart, noise, by_mass):
    """Disturbances are as loud as ever; a row is linear in the products of the parameters `by_mass` with the mass."""
    density = noise.disturbance**2 * one_disturbance(cart, noise)
    return UnmodelledNoise(density, density, 1.0, by_mass)


def filtered_row(cart, known, spread, block, unmodelled):
    """In slices of a size that blocks are no multiple of."""
    row = AskedRow.of(block, known, spread)
    while not row.is_answered:
        row = row.go_on(cart, 7)
    return row.filtered(cart, unmodelled)
