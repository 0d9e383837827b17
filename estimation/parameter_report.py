"""What is said of parameters to people: physical values with standard deviations, and whether a motion taught them."""

from __future__ import annotations

from collections.abc import Callable, ItemsView, Iterator, Mapping, ValuesView
from dataclasses import replace
from functools import cached_property
from typing import final

import numpy as np

from cartgrasp.frames import Array
from cartgrasp.inertia import N_PHI, physical_from_phi, physical_jacobian
from cartgrasp.model import CartModel
from cartgrasp.motion import ParameterEstimate

from .health import Health
from .physical_set import BOUND_MARGIN, PhysicalSet
from .prior import Prior, report_names, report_units

BOUND_TOLERANCE = 2.0 * BOUND_MARGIN
"""Share of the first standard deviation: a value that is no farther from a bound is at it."""
IDENTIFIABLE_STD_RATIO = 0.25
"""Share of the prior's standard deviation below which a parameter counts as taught."""


class ParameterReport:
    """Reports a cart's parameters against what was believed of them at first."""

    def __init__(self, cart: CartModel, prior: Prior) -> None:
        self.cart = cart
        self._prior_std = prior.deviations(cart)
        self._names = tuple(zip(report_names(cart), report_units(cart), strict=True))
        limits, margin = PhysicalSet.of(cart, cart.name), BOUND_TOLERANCE * self._prior_std
        self._lower = np.array([limits.mass, -np.inf, -np.inf, limits.about_com, *limits.lower]) + margin
        self._upper = np.append(np.full(N_PHI, np.inf), limits.upper) - margin

    def of(self, theta: Array, covariance: Array, share: Array) -> dict[str, ParameterEstimate]:
        """The model's parameters (p,) and their covariance (p, p) by name. `share` (p,) is what is left of the first
        standard deviation of the number that was estimated behind each: a deviation of a physical value also shrinks
        where the value runs away. At a bound of an effect, or as light as a cart may be, nothing is taught."""
        values, std = self.numbers(theta, covariance)
        learned = (share < IDENTIFIABLE_STD_RATIO) & (std < IDENTIFIABLE_STD_RATIO * self._prior_std)
        learned &= (self._lower < values) & (values < self._upper)
        rows = zip(self._names, values.tolist(), std.tolist(), learned.tolist(), strict=True)
        return {
            name: ParameterEstimate(value, deviation, unit, known) for (name, unit), value, deviation, known in rows
        }

    def of_free(self, theta: Array, covariance: Array, free: np.ndarray, first: Array) -> dict[str, ParameterEstimate]:
        """The parameters by name, as in `of`. The free ones (indices) were believed with variances (f,) at first, and
        are estimated as they are."""
        share = np.ones(len(theta))
        share[free] = np.sqrt(np.maximum(np.diagonal(covariance)[free] / first, 0.0))
        return self.of(theta, covariance, share)

    def numbers(self, theta: Array, covariance: Array) -> tuple[Array, Array]:
        """Physical values and their standard deviations (..., p)."""
        to_report = np.broadcast_to(np.eye(theta.shape[-1]), covariance.shape).copy()
        to_report[..., :N_PHI, :N_PHI] = physical_jacobian(theta[..., :N_PHI])
        std = np.sqrt(np.maximum(((to_report @ covariance) * to_report).sum(axis=-1), 0.0))
        values = np.array(theta)
        values[..., :N_PHI] = physical_from_phi(theta[..., :N_PHI])
        if self.cart.constraints.no_rotation:
            body = self.cart.inertia
            values[..., 1:N_PHI] = *body.com, body.about_com
            std[..., 1:N_PHI] = self._prior_std[1:N_PHI]
        return values, std


@final
class LazyParameters(Mapping[str, ParameterEstimate]):
    """Parameters by name, which are worked out when somebody looks: at a controller's rate hardly anybody does."""

    def __init__(self, work_out: Callable[[], Mapping[str, ParameterEstimate]]) -> None:
        self._work_out = work_out

    @cached_property
    def _found(self) -> Mapping[str, ParameterEstimate]:
        with np.errstate(all="ignore"):  # whoever asks is told of what is beyond reason by the numbers
            return self._work_out()

    def __getitem__(self, name: str) -> ParameterEstimate:
        return self._found[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._found)

    def __len__(self) -> int:
        return len(self._found)

    def values(self) -> ValuesView[ParameterEstimate]:
        return self._found.values()

    def items(self) -> ItemsView[str, ParameterEstimate]:
        return self._found.items()

    def __repr__(self) -> str:
        return repr(self._found)


def qualified_by_health(
    parameters: Mapping[str, ParameterEstimate], learner: Health
) -> Mapping[str, ParameterEstimate]:
    """The parameters as taught by an estimator of this health. One that is inconsistent was taught nothing: its
    deviations hold for a model that fits, and its values are of one that doesn't. Nor was one whose load may have
    changed: it begins anew."""
    if learner not in (Health.INCONSISTENT, Health.LOAD_CHANGED):
        return parameters
    return LazyParameters(lambda: {name: replace(one, identifiable=False) for name, one in parameters.items()})
