"""The filtered-regressor estimator: parameters from a regression on motion, motion from poses alone."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import final

import numpy as np

from cartgrasp.model import CartModel
from cartgrasp.motion import Estimate

from ..gaussian import Gaussian
from ..noise import FilterNoise
from ..prior import Prior
from .arguments import checked_arguments
from .online_estimator import OnlineEstimator
from .regressor.dead_reckoning import ReckoningLearner
from .unknown_slope import with_unknown_slope


@final
class RegressorEstimator(OnlineEstimator[ReckoningLearner]):
    """Learns while the cart is pushed, as `CartFilter` does and with its arguments, and what it learns."""

    aligns = False

    def __init__(
        self,
        cart: CartModel,
        arms: Sequence[str] | None = None,
        *,
        noise: FilterNoise | None = None,
        prior: Prior | None = None,
        yaws: Mapping[str, float] | None = None,
    ) -> None:
        made_of = checked_arguments(cart, arms, noise, prior, yaws)
        with np.errstate(all="ignore"):  # what is told of the noise may be beyond reason
            super().__init__(made_of, ReckoningLearner(*with_unknown_slope(made_of)))

    @property
    def belief(self) -> Gaussian:
        """Mean and covariance of the free parameters, physical or not."""
        whole, f = self._samples.state.belief, len(self.prior.free(self.cart))
        return Gaussian(whole.mean[:f], whole.covariance[:f, :f])

    @property
    def lateness(self) -> float:
        """How late wrenches are (s), beyond a quarter of a sample: held ones are not, mere samples half of one."""
        return self._samples.state.learned.wrench_delay

    def _core_estimate(self) -> Estimate:
        learner = self._core
        return learner.estimate(learner.told_motion, learner.health)
