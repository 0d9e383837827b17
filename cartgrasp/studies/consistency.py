"""Whether the filter is right about how wrong it is: NEES and NIS over many carts that are drawn from its prior.

A cart that nobody knows is drawn, driven in curves, and learned from the guess that it was drawn around. Nothing is
left out of the model, and the filter is told so; so the normalised squares of its errors and innovations are
chi-squared (Bar-Shalom 2001, 5.4), at each step over the runs. The same runs with rolling resistance left out of the
filter's model are the counter-proof.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from estimation import CartFilter, FilterNoise
from estimation.gaussian import normalised_square
from estimation.prior import Prior

from ..effects import RollingResistance, ViscousDrag
from ..frames import Array, wrap_angle
from ..inertia import N_PHI, Inertia, physical_from_phi
from ..model import CartModel
from .estimators import HANDS, SENSOR_SETS, Drive, Job, drive_cart, guess
from .parallel import run_all
from .scenario import filter_noise

DURATION = 12.0
"""s: up to where the cart stops."""
PRIOR_STD = {"viscous_drag.linear": 0.5, "viscous_drag.angular": 0.25, "rolling_resistance.coefficient": 0.004}
"""So small beside the guess that a draw is hardly ever negative, which would not be from the prior any more."""
PRIOR = Prior(mass=0.2, com=0.05, inertia=0.2, slope=0.0, std=PRIOR_STD)
MATCHED_MODEL, WRONG_MODEL = "matched", "rolling resistance left out"
MODELS = MATCHED_MODEL, WRONG_MODEL
MOTION_NEES, PARAMETER_NEES = "NEES of motion", "NEES of parameters"
POSE_NIS, VELOCITY_NIS = "NIS of pose", "NIS of velocity"
SQUARES = MOTION_NEES, PARAMETER_NEES, POSE_NIS, VELOCITY_NIS


@dataclass(frozen=True, eq=False)
class Trace:
    """The normalised errors of a run: each of SQUARES (n,) and its dimension, and the parameters' errors in standard
    deviations (n, p)."""

    squares: dict[str, Array]
    dimensions: dict[str, int]
    scores: Array


def drawn_cart(seed: int) -> CartModel:
    """A cart drawn from PRIOR around the guess; what is no cart is drawn again."""
    random, first = np.random.default_rng(seed), guess()
    root = np.linalg.cholesky(PRIOR.covariance(first))
    while True:
        values = first.parameters + root @ random.standard_normal(len(root))
        mass, x, y, about_com = physical_from_phi(values[:N_PHI])
        if mass > 0 and about_com > 0 and (values[N_PHI:] > 0).all():
            break
    linear, angular, coefficient = values[N_PHI:].tolist()
    effects = ViscousDrag(linear=linear, angular=angular), RollingResistance(coefficient=coefficient)
    return CartModel(Inertia(float(mass), (float(x), float(y)), float(about_com)), first.constraints, effects)


def believed(model: str) -> tuple[CartModel, Prior]:
    """What a filter begins with."""
    cart = guess()
    if model == MATCHED_MODEL:
        return cart, PRIOR
    return CartModel(cart.inertia, cart.constraints, cart.effects[:1]), replace(
        PRIOR, std={name: std for name, std in PRIOR_STD.items() if "rolling" not in name}
    )


def exact_noise(sensors: str) -> FilterNoise:
    """What the simulation adds, and nothing else."""
    return filter_noise(SENSOR_SETS[sensors], disturbance=0.0, slip=0.0)


def follow(drive: Drive, cart: CartModel, model: str, noise: FilterNoise) -> Trace:
    """The filter along a drive of `cart`."""
    first, prior = believed(model)
    estimator = CartFilter(first, list(HANDS), noise=noise, prior=prior)
    told = []
    for measurement in drive.log.measurements():
        estimate, belief = estimator.update(measurement), estimator.belief
        nis = [estimator.nis.get(sensor, (np.nan, 0))[0] for sensor in ("pose", "velocity")]
        told.append((belief.mean, belief.covariance, estimate.model_parameters, estimate.covariance, *nis))
    motion, motion_covariance, parameters, covariance, pose_nis, velocity_nis = map(np.array, zip(*told, strict=True))
    off = motion - drive.motion
    off[:, 2] = wrap_angle(off[:, 2])
    wrong = parameters - cart.parameters[: parameters.shape[1]]
    squares = {
        MOTION_NEES: normalised_square(off, motion_covariance),
        PARAMETER_NEES: normalised_square(wrong, covariance),
        POSE_NIS: pose_nis,
        VELOCITY_NIS: velocity_nis,
    }
    sizes = dict(zip(SQUARES, (off.shape[1], wrong.shape[1], 3, first.constraints.n_free), strict=True))
    return Trace(squares, sizes, wrong / np.sqrt(np.diagonal(covariance, axis1=1, axis2=2)))


def trace_both(seed: int) -> dict[str, Trace]:
    """A cart's drive with each of MODELS."""
    cart = drawn_cart(seed)
    drive = drive_cart(cart, Job("curves", "usual", seed), DURATION)
    return {model: follow(drive, cart, model, exact_noise("usual")) for model in MODELS}


run_seeds = partial(run_all, trace_both)
"""Each seed's traces."""
