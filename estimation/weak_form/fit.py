"""Parameters of a cart fitted to whitened rows, in coordinates in which every cart is physical.

Unknown are the logarithms of mass and inertia about the CoM, the CoM, and the effects' parameters, within their bounds.
A first guess of mass and inertia is known up to a factor, so its prior is log-normal.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cartgrasp.frames import Array
from cartgrasp.inertia import N_PHI, phi_from_physical, physical_from_phi, physical_jacobian
from cartgrasp.model import CartModel

from .balances import Balances
from .whitening import Whitening

ROUNDS, SETTLED = 12, 0.05
"""Most rounds of Gauss-Newton; standard deviations by which the last moves a parameter at most."""
MOST_STEP = 1.0
"""Largest change of a logarithm in one step."""


@dataclass(frozen=True)
class ParameterPrior:
    """Prior of the logarithms of mass and inertia, the CoM (m) and the effects' parameters, each with its mean and
    standard deviation (p,). Those that are `free` (p,) are estimated."""

    mean: Array
    std: Array
    free: np.ndarray


@dataclass(frozen=True)
class Fit:
    """Parameters (p,) of the cart, covariance (p, p) of the coordinates, and which are at a bound."""

    cart: CartModel
    covariance: Array
    free: np.ndarray
    at_bound: np.ndarray


def coordinates(cart: CartModel) -> Array:
    values = cart.parameters.copy()
    mass, x, y, inertia = physical_from_phi(values[:N_PHI])
    values[:N_PHI] = np.log(mass), x, y, np.log(inertia)
    return values


def with_coordinates(cart: CartModel, z: Array) -> CartModel:
    values = z.copy()
    is_same = np.array_equal(z[:N_PHI], coordinates(cart)[:N_PHI])  # a body that is given stays as it is, to the bit
    values[:N_PHI] = cart.parameters[:N_PHI] if is_same else phi_from_physical(np.exp(z[0]), z[1], z[2], np.exp(z[3]))
    return cart.with_parameters(values)


def jacobian(cart: CartModel) -> Array:
    """Jacobian (p, p) of the parameters with respect to the coordinates."""
    p = len(cart.parameters)
    found = np.eye(p)
    body = cart.inertia
    by_physical = np.linalg.inv(physical_jacobian(body.phi))
    found[:N_PHI, :N_PHI] = by_physical @ np.diag([body.mass, 1.0, 1.0, body.about_com])
    return found


@dataclass(frozen=True, eq=False)
class Nuisance:
    """What is unknown beside the parameters: of each log raw columns (k, c, q), and their standard deviations (q,)."""

    columns: tuple[Array, ...]
    std: Array


def fit(
    logs: Sequence[tuple[Balances, Whitening]], cart: CartModel, prior: ParameterPrior, nuisance: Nuisance
) -> tuple[Fit, Array]:
    """The most likely parameters, from the cart's on, and amplitudes (q,) of what is unknown beside them."""
    lower = np.concatenate([np.full(N_PHI, -np.inf), *([p.lower for p in e.parameters] for e in cart.effects)])
    upper = np.concatenate([np.full(N_PHI, np.inf), *([p.upper for p in e.parameters] for e in cart.effects)])
    beside = [whiten(own) for (_, whiten), own in zip(logs, nuisance.columns, strict=True)]
    p, fixed, amplitudes = len(lower), np.zeros(len(lower), dtype=bool), np.zeros(len(nuisance.std))
    for _ in range(ROUNDS):
        z = coordinates(cart)
        free = np.flatnonzero(np.append(prior.free & ~fixed, np.ones(len(amplitudes), dtype=bool)))
        information, pull = normal(logs, cart, beside)
        information += np.diag(np.append(prior.std, nuisance.std) ** -2.0)
        pull[:p] += (prior.mean - z) / prior.std**2
        covariance = np.linalg.inv(information[np.ix_(free, free)])
        step = np.zeros(p + len(amplitudes))
        step[free] = covariance @ pull[free]
        amplitudes = step[p:]
        step[[0, 3]] = np.clip(step[[0, 3]], -MOST_STEP, MOST_STEP)
        aim = np.clip(z + step[:p], lower, upper)
        hit = prior.free & ((aim <= lower) | (aim >= upper)) & (step[:p] != 0)
        own = free[free < p]
        moved = np.abs(aim - z)[own] / np.sqrt(np.diagonal(covariance)[: len(own)])
        cart = with_coordinates(cart, aim)
        fixed = fixed | hit
        if float(moved.max(initial=0.0)) < SETTLED:
            break
    whole = np.diag(np.where(prior.free, prior.std, 0.0) ** 2)
    whole[np.ix_(own, own)] = covariance[: len(own), : len(own)]
    return Fit(cart, whole, prior.free, fixed), amplitudes


def normal(logs: Sequence[tuple[Balances, Whitening]], cart: CartModel, beside: Sequence[Array]) -> tuple[Array, Array]:
    """Information (p + q, p + q) and pull (p + q,) of the coordinates and of whitened columns beside them."""
    by = jacobian(cart)
    size = len(by) + beside[0].shape[2]
    information, pull = np.zeros((size, size)), np.zeros(size)
    for (balances, whiten), columns in zip(logs, beside, strict=True):
        left, slopes = balances.residual(cart)
        white = whiten(np.concatenate([slopes @ by, left[..., None]], axis=2))
        flat = np.concatenate([white[..., :-1], columns, white[..., -1:]], axis=2).reshape(-1, size + 1)
        joint = flat.T @ flat
        information += joint[:size, :size]
        pull += joint[:size, size]
    return information, pull
