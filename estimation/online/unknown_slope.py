"""No floor is level: what learns counts with a slope of which the cart's file says nothing, and does not report it.

On a floor that rises by 0.02, as one that counts as level may (ADA standards, 403.3), gravity takes 0.2 N off each kg:
an estimator that does not know learned 16 kg of 24 on the first push, surely.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from functools import partial

from cartgrasp.effects import FloorSlope, UnknownSlope
from cartgrasp.model import CartModel
from cartgrasp.motion import Estimate, ParameterEstimate

from ..parameter_report import LazyParameters
from ..prior import report_names
from .arguments import EstimatorArguments


def with_unknown_slope(made_of: EstimatorArguments) -> EstimatorArguments:
    """The arguments with a slope beside the cart's own parameters, and after them; as they are where the cart has one,
    or where the prior's `slope` says that there is none."""
    cart, arms, noise, prior, yaws = made_of
    if not prior.slope or any(isinstance(effect, FloorSlope | UnknownSlope) for effect in cart.effects):
        return made_of
    lever = math.hypot(*cart.inertia.com, *prior.deviations(cart)[1:3])
    sizes = prior.slope, prior.slope, lever * prior.slope, lever * prior.slope
    deviations = dict(zip(cart.on_slope.effects[-1].keys, sizes, strict=True))
    return cart.on_slope, arms, noise, replace(prior, std={**prior.std, **deviations}), yaws


def without_slope(estimate: Estimate, cart: CartModel) -> Estimate:
    """What is told of this cart."""
    p, covariance = len(cart.parameters), estimate.covariance
    if len(estimate.model_parameters) == p:
        return estimate
    return estimate._replace(
        parameters=LazyParameters(partial(of_cart, estimate.parameters, cart)),
        structure=cart,
        model_parameters=estimate.model_parameters[:p],
        covariance=None if covariance is None else covariance[:p, :p],
        floor=estimate.model_parameters[p:],
        covariance_on_floor=covariance,
    )


def of_cart(parameters: Mapping[str, ParameterEstimate], cart: CartModel) -> Mapping[str, ParameterEstimate]:
    """Those of the cart's own, without what is learned beside."""
    return {name: parameters[name] for name in report_names(cart)}
