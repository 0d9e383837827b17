"""The online filter: `learning_filter.py` behind the interface that it shares with the regressor."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import final

import numpy as np

from cartgrasp.checks import MAX_NUMBER, number
from cartgrasp.model import CartModel
from cartgrasp.motion import Estimate

from ..gaussian import Gaussian
from ..health import SensorHealth
from ..noise import FilterNoise
from ..prior import Prior
from .arguments import EstimatorArguments, checked_arguments
from .delayed_wrenches import DelayedWrenches, with_delays_removed
from .learning_filter import LearningFilter
from .online_estimator import OnlineEstimator
from .regressor.parameter_learner import ParameterLearner
from .schmidt_filter import SchmidtFilter
from .unknown_slope import with_unknown_slope


def core_of(made_of: EstimatorArguments, least_speed: float = 0.0, unseen: float = 0.0) -> LearningFilter:
    """The filter behind a `CartFilter`, which takes samples in order, and bears with disturbances up to `unseen`
    (N·√s), where that is more than is declared."""
    made_of = with_unknown_slope(made_of)
    cart, _, noise, prior, _ = made_of
    with np.errstate(all="ignore"):  # what is told of the noise may be beyond reason
        return LearningFilter(
            ParameterLearner(*made_of, least_speed, unseen), SchmidtFilter(cart, noise, prior.free(cart))
        )


@final
class CartFilter(OnlineEstimator[DelayedWrenches[LearningFilter] | LearningFilter]):
    """Learns while the cart is pushed: `update` takes a measurement and returns the estimate at its time.

    Sensors may have rates of their own, with a measurement for each of their samples, which may be up to 0.3 s late.
    Where the cart has a `time_delay`, parameters are as much behind, and the motion is not.

    Args:
        cart: Structure and first guess.
        arms: Names of those whose wrenches add up; None: all that are seen.
        noise: Standard deviations of the sensors, in their units; those of `FilterNoise()` unless given.
        prior: How sure the first guess is; `Prior()` and what the cart's file says unless given.
        yaws: Of the contact frames against {b}, rad, by arm; 0 unless given.
        least_speed: m/s of {b}'s origin below which a regression learns nothing, as in the paper's experiments.

    Raises:
        UsageError: An argument is of the wrong kind or out of bounds, or names an arm or parameter that is not there.

    Example:
        >>> import cartgrasp as cg
        >>> from estimation import CartFilter
        >>> log, cart_filter = cg.read_log("run.csv"), CartFilter(cg.load_cart("cart.yaml"))
        >>> for measurement in log.measurements():
        ...     estimate = cart_filter.update(measurement)
        >>> estimate.parameters["mass"].identifiable, estimate.health
        (True, <Health.OK: 'ok'>)
    """

    aligns = True

    def __init__(
        self,
        cart: CartModel,
        arms: Sequence[str] | None = None,
        *,
        noise: FilterNoise | None = None,
        prior: Prior | None = None,
        yaws: Mapping[str, float] | None = None,
        least_speed: float = 0.0,
    ) -> None:
        number("filter: least_speed", least_speed, 0.0, MAX_NUMBER, "give m/s")
        made_of = checked_arguments(cart, arms, noise, prior, yaws)
        super().__init__(made_of, with_delays_removed(core_of(made_of, least_speed), cart))

    @property
    def belief(self) -> Gaussian:
        """Mean and covariance of pose, nu and effect memory."""
        return self._up_to_now.belief

    @property
    def nis(self) -> Mapping[str, tuple[float, int]]:
        """Normalised innovation squared of the last measurement's pose and velocity, with its dimension."""
        return self._up_to_now.nis

    @property
    def sensors(self) -> Mapping[str, SensorHealth]:
        """How pose, velocity and wrench do."""
        return dict(self._up_to_now.sensors)

    @property
    def _up_to_now(self) -> LearningFilter:
        """What has seen all motion, too, of which no wrench tells yet."""
        core = self._core
        return core.ahead if isinstance(core, DelayedWrenches) else core

    def _core_estimate(self) -> Estimate:
        return self._core.estimate()
