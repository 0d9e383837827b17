"""Parameters of a cart fitted to whitened rows, in coordinates in which every cart is physical."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cartgrasp.frames import Array
from cartgrasp.model import CartModel

from .balances import Balances
from .coordinates import ParameterPrior, coordinates, jacobian
from .linearized import Linearized, MostLikely
from .whitening import Whitening

MAX_LINEARISATIONS, CONVERGENCE_SIGMAS = 12, 0.05
"""Most rounds in which rows are made linear; standard deviations by which the last moves a coordinate at most."""


@dataclass(frozen=True, eq=False)
class Nuisance:
    """What is unknown beside the parameters: of each log raw columns (k, c, q), and their standard deviations (q,)."""

    columns: tuple[Array, ...]
    std: Array


def fit(
    logs: Sequence[tuple[Balances, Whitening]], cart: CartModel, prior: ParameterPrior, nuisance: Nuisance
) -> MostLikely:
    """The most likely cart, from this one on."""
    beside = [whiten(own) for (_, whiten), own in zip(logs, nuisance.columns, strict=True)]
    for _ in range(MAX_LINEARISATIONS):
        information, pull = normal(logs, cart, beside, prior.free)
        found = Linearized(cart, prior, information, pull, nuisance.std).most_likely()
        moved = (coordinates(found.cart) - coordinates(cart))[prior.free]
        cart = found.cart
        if (np.abs(moved) < CONVERGENCE_SIGMAS * np.sqrt(np.diagonal(found.covariance)[: len(moved)])).all():
            break
    return found


def normal(
    logs: Sequence[tuple[Balances, Whitening]], cart: CartModel, beside: Sequence[Array], free: np.ndarray
) -> tuple[Array, Array]:
    """Information (f + q, f + q) and pull (f + q,) of the coordinates that are free and of whitened columns beside
    them."""
    by = jacobian(cart)[:, free]
    size = by.shape[1] + beside[0].shape[2]
    information, pull = np.zeros((size, size)), np.zeros(size)
    for (balances, whiten), columns in zip(logs, beside, strict=True):
        left, slopes = balances.residual(cart)
        white = whiten(np.concatenate([slopes @ by, left[..., None]], axis=2))
        flat = np.concatenate([white[..., :-1], columns, white[..., -1:]], axis=2).reshape(-1, size + 1)
        joint = flat.T @ flat
        information += joint[:size, :size]
        pull += joint[:size, size]
    return information, pull
