"""The filter that tells what pushes beside all that the model explains."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import ClassVar, final

from cartgrasp.checks import brief, positive
from cartgrasp.model import CartModel
from cartgrasp.motion import Estimate

from ...noise import FilterNoise
from ...prior import Prior
from ..arguments import checked_arguments
from ..delayed_wrenches import DelayedWrenches, with_delays_removed
from ..online_estimator import OnlineEstimator
from .disturbed_learning import DisturbedLearning

MAX_RESPONSE_TIME = 10.0


@final
class DisturbedFilter(OnlineEstimator[DelayedWrenches[DisturbedLearning] | DisturbedLearning]):
    """Learns as `CartFilter` does, and tells `estimate.disturbance`; its motion is right while something pushes.

    Args:
        cart: Structure and first guess.
        arms: Names of those whose wrenches add up; None: all that are seen.
        noise: Standard deviations of the sensors, in their units; those of `FilterNoise()` unless given.
        prior: How sure the first guess is; `Prior()` and what the cart's file says unless given.
        yaws: Of the contact frames against {b}, rad, by arm; 0 unless given.
        response: s until a push is followed to 5 % by what learns, and parameters are as much behind; what is told
            follows in 0.6 of it. Where the cart has a `time_delay`, all but the motion is that much later.

    Raises:
        UsageError: An argument is of the wrong kind or out of bounds.

    Example:
        >>> import cartgrasp as cg
        >>> from estimation import DisturbedFilter
        >>> cart_filter = DisturbedFilter(cg.load_cart("cart.yaml"))
        >>> for measurement in cg.read_log("run.csv").measurements():
        ...     estimate = cart_filter.update(measurement)
        >>> estimate.disturbance.acts
        False
    """

    tells_disturbance: ClassVar[bool] = True
    aligns = True

    def __init__(
        self,
        cart: CartModel,
        arms: Sequence[str] | None = None,
        *,
        noise: FilterNoise | None = None,
        prior: Prior | None = None,
        yaws: Mapping[str, float] | None = None,
        response: float = 0.2,
    ) -> None:
        made_of = checked_arguments(cart, arms, noise, prior, yaws)
        self.response = positive("filter: response", response, MAX_RESPONSE_TIME, "give s")
        super().__init__(made_of, with_delays_removed(DisturbedLearning(made_of, self.response), cart))

    def __repr__(self) -> str:
        return brief(type(self).__name__, self.cart.name, f"response {self.response:g} s")

    def _core_estimate(self) -> Estimate:
        return self._core.estimate()
