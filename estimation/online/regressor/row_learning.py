"""What rows teach of the parameters: a belief of them, what surprised it, and what people are told.

Rows wait until wrenches have told how heavy the cart is, and then add up (`regression_belief.py`). What surprises is a
push, a load or another floor (`load_hypotheses.py`); until that is told all of them are believed.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from contextlib import suppress
from functools import partial
from typing import Self

import numpy as np

from cartgrasp.errors import DataError
from cartgrasp.frames import Array
from cartgrasp.model import CartModel
from cartgrasp.motion import ParameterEstimate
from cartgrasp.shallow_copy import shallow_copy

from ...gaussian import Gaussian
from ...health import Health
from ...noise import FilterNoise
from ...parameter_report import LazyParameters, ParameterReport, qualified_by_health
from ...physical_set import PhysicalSet
from ...prior import Prior
from ..disturbance.observer import PUSH_FORCE_STD
from ..kernels.row_algebra import FilteredRow, UnmodelledNoise
from ..load_change import load_covariance, root_of
from .disturbance_level import DisturbanceLevel
from .filtered_row import AskedRow, Block, one_disturbance
from .load_hypotheses import HypothesesOpening, LearnedRow, LoadHypotheses
from .load_monitor import CHI2_TEST_ROWS, LoadMonitor
from .mass_products import MassProducts
from .parameter_scale import ScaleInformation
from .regression_belief import Innovation, RegressionBelief
from .row_stages import DoneStage, HypothesesStage, RowStage, TakenInStage, UndecidedStage
from .wrench_noise_scale import WrenchNoiseScale

SLICE_EVALUATIONS = 96
"""Moments at which inverse dynamics are asked for in one slice of a row."""


# Many methods: a row's way to what is told of it is one for each of its stages, so that no tick bears a whole row.
class RowLearning:
    """What is believed of the parameters `theta` (p,), with a `covariance` (p, p), and by how much wrenches are late
    (`wrench_delay`, s). `hypotheses` of what surprised are None while nothing is open."""

    theta: Array
    covariance: Array
    reported_covariance: Array
    wrench_delay: float
    mass_matrix: Array

    def __init__(self, cart: CartModel, noise: FilterNoise, prior: Prior, unseen: float) -> None:
        self.cart = cart
        self._free = prior.free(cart)
        self._root = root_of(load_covariance(cart, prior, 1.0))  # of a load's covariance, by mass
        self._products = MassProducts.of(cart, self._free)
        first = Gaussian(cart.parameters[self._free], prior.covariance(cart)[np.ix_(self._free, self._free)])
        self._first_variances = np.diagonal(first.covariance)
        self._belief = RegressionBelief(self._free, first, cart.constraints.n_free, cart.parameters, self._products)
        self._one_disturbance = one_disturbance(cart, noise)
        self._level, self.is_disturbed = DisturbanceLevel.between(noise.disturbance, unseen), False
        self.wrench_noise_scale = WrenchNoiseScale()
        self._unscaled_rows: tuple[RowStage, ...] = ()  # that wait until the parameters' scale is known
        self._parameter_scale = ScaleInformation.of(cart, prior, self._free)
        self._load_monitor = LoadMonitor(cart.constraints.n_free, len(self._free))
        self._limits = PhysicalSet.of(cart, "regressor")
        self.reporter = ParameterReport(cart, prior)
        self._report: Mapping[str, ParameterEstimate] | None = None
        self.hypotheses: LoadHypotheses | None = None
        self.last_decision = self.last_load_change = -math.inf  # s: of hypotheses, and of some for another load
        self._taken: tuple[LearnedRow, ...] = ()  # the last rows
        self._push = np.diag(PUSH_FORCE_STD * noise.wrench_scale(cart)) ** 2
        self._at_rest = cart.state(), np.zeros(cart.constraints.n_free)
        self.theta = cart.parameters
        self.conclude()

    def copy(self) -> Self:
        other = shallow_copy(self)
        other._belief, other._load_monitor = self._belief.copy(), shallow_copy(self._load_monitor)
        return other

    # --- rows ------------------------------------------------------------------------------------------------

    def row_of(self, block: Block) -> AskedRow | RowStage | None:
        """A block's row, worked out around what is believed now; see `worked_on`."""
        return self.worked_on(AskedRow.of(block, Gaussian(self.theta, self.covariance), self._spread))

    def worked_on(self, row: AskedRow) -> AskedRow | RowStage | None:
        """The row after one slice more, of which one with few moments needs no other; None while the scale of the
        parameters is not known (`parameter_scale.py`)."""
        if not row.is_answered:
            row = row.go_on(self.cart, SLICE_EVALUATIONS)
            if not row.is_answered or len(row.answers) > 1:
                return row
        weights, time = row.block.weights, float(row.block.moved.time[-1])
        stage = RowStage(time, row.filtered(self.cart, self._unmodelled_noise), weights.of_white)
        return stage if self._parameter_scale.is_known else self._once_scale_is_known(stage, row.block)

    def _once_scale_is_known(self, stage: RowStage, block: Block) -> RowStage | None:
        """The row, with which the last ones are taken in, too; None while the scale of the parameters is not known."""
        n = len(stage.row.residual)
        self._parameter_scale = self._parameter_scale.after(
            block.weights.held @ block.wrenches[:, 1 : 1 + n], stage.row
        )
        self._unscaled_rows = (*self._unscaled_rows, stage)[-CHI2_TEST_ROWS:]
        if not self._parameter_scale.is_known:
            return None
        pending, self._unscaled_rows = self._unscaled_rows, ()
        for one in pending[:-1]:
            self.take_in(*one)
        return stage

    @property
    def _unmodelled_noise(self) -> UnmodelledNoise:
        """Open hypotheses, or what is known to push, leave no row quiet: it may bear as much as any."""
        level, one = self._level, self._one_disturbance
        usual = level.highest if self.hypotheses is not None or self.is_disturbed else level.mean_density
        return UnmodelledNoise(
            level.highest * one, usual * one, self.wrench_noise_scale.variance_factor, self._products.by_mass
        )

    def take_in(self, time: float, row: FilteredRow, of_white: float) -> TakenInStage | HypothesesStage:
        """What the belief, or open hypotheses, make of a row."""
        if self.hypotheses is not None:
            return HypothesesStage(time, self.hypotheses.with_row(row, self.theta)).go_on()
        before = self._belief.copy()
        innovation = self._belief.update(row, self.theta)
        if not self.is_disturbed:
            self._level = self._level.after(innovation, of_white * self._one_disturbance)
        self._taken = (*self._taken, LearnedRow(before, row, self.theta))[-CHI2_TEST_ROWS:]
        return TakenInStage(time, innovation)

    def with_noise_scale(self, stage: TakenInStage) -> UndecidedStage:
        """Follows how loud autocorrelated noise of wrenches is."""
        self.wrench_noise_scale, following = stage.with_noise_scale(self.wrench_noise_scale)
        return following

    def drop_link(self, time: float, *, is_still: bool = False) -> None:
        """The next block does not begin where the last one ended, or stood still."""
        self._belief.drop_link()
        self._taken = self._unscaled_rows = ()
        if self.hypotheses is not None:
            self._settle(self.hypotheses.without_link(is_still=is_still), time)
            self.conclude()

    # --- loads and pushes ------------------------------------------------------------------------------------

    def note_time(self, time: float) -> None:
        """Nothing new up to a time."""
        self._load_monitor.note_time(time)

    def decide(self, time: float, told: Innovation | LoadHypotheses) -> DoneStage | HypothesesOpening:
        """What a row says of loads and pushes."""
        if isinstance(told, LoadHypotheses):
            self._load_monitor.follow(time, told.innovation, is_pushed=told.is_pushed)
            self._settle(told, time)
            return DoneStage()
        root = self._root_of_load
        if not self._load_monitor.note(time, told, root, self.wrench_noise_scale):
            return DoneStage()
        floor = self._products.floor(self.theta)[np.ix_(self._free, self._free)]
        beginning = HypothesesOpening.of(time, self._taken, root @ root.T, floor, self._push)
        self._taken = ()
        return beginning

    @property
    def _root_of_load(self) -> Array:
        """`root @ rootᵀ` (f, f) is the covariance of what a usual load changes."""
        return np.asarray((self._products.by_factors(self.theta) @ (float(self.theta[0]) * self._root))[self._free])

    def note_push(self, time: float) -> None:
        """Somebody who has heard more found that what surprised is no load."""
        if self.hypotheses is not None:
            self._belief, self.hypotheses = self.hypotheses.pushed.belief.copy(), None
            self.last_decision = time
            self._load_monitor.note_decision(time, is_load=False)
            self.conclude()

    def note_load_change(self, time: float, since: float) -> None:
        """Somebody else found another load, no earlier than some s: that is believed, if it was thought of since; else
        what was learned of the body counts as little as after one of its own."""
        if self.hypotheses is not None and self.hypotheses.time > since:
            self._belief = self.hypotheses.if_loaded
        else:
            self._belief.open(self._root_of_load @ self._root_of_load.T)
        self.hypotheses, self._taken = None, ()
        self.last_decision = self.last_load_change = time
        self._load_monitor.note_decision(time, is_load=True)
        self.conclude()

    def settle_opening(self, beginning: HypothesesOpening) -> DoneStage | HypothesesOpening:
        """Hypotheses that have just begun are believed once they have taken in the last rows; until then, goes on."""
        if beginning.left or beginning.hypotheses is None:
            return beginning
        self._settle(beginning.hypotheses, beginning.time)
        return DoneStage()

    def _settle(self, hypotheses: LoadHypotheses, time: float) -> None:
        """What is believed while a push and a load both are, and whether that is decided."""
        self.hypotheses, self._belief = None if hypotheses.is_over else hypotheses, hypotheses.belief
        if hypotheses.is_over:
            self.last_decision, self.last_load_change = time, time if hypotheses.is_loaded else self.last_load_change
        self._load_monitor.settle(time, hypotheses)

    def conclude(self) -> None:
        """The parameters to linearise at and to report; where what is believed is no body, the most likely one is
        taken, and the belief stays as it is."""
        theta, self.covariance, self._spread, self.wrench_delay = self._belief.concluded()
        if len(self._free) and not self._limits.holds(theta):
            with suppress(DataError):  # where what is believed is beyond numbers, what was stays
                self.theta = self._limits.nearest(theta, self._free, self._belief.parameters.information)
            theta = self.theta
        self.theta, self._report, self.reported_covariance = theta, None, self._covariance_to_report()
        self.mass_matrix = self.cart.inverse(*self._at_rest, theta).by_acceleration

    def _covariance_to_report(self) -> Array:
        """The covariance (p, p) that people are told: of all that is not excluded, and as innovations vary."""
        wide = None if self.hypotheses is None else self.hypotheses.not_excluded
        return self._load_monitor.excess * (self.covariance if wide is None else wide.concluded().covariance)

    # --- what is told ----------------------------------------------------------------------------------------

    @property
    def health(self) -> Health:
        return self._load_monitor.health

    @property
    def gate_ratio(self) -> float:
        """The last row's normalised square over the gate beyond which it counts less."""
        return self._load_monitor.ratio

    @property
    def belief(self) -> Gaussian:
        """Mean and covariance of the free parameters, physical or not."""
        return self._belief.parameters

    @property
    def report(self) -> Mapping[str, ParameterEstimate]:
        """What is said of the parameters."""
        if self._report is None:
            self._report = self.reported(self.reported_covariance)
        return qualified_by_health(self._report, self._load_monitor.health)

    def reported(self, covariance: Array) -> Mapping[str, ParameterEstimate]:
        """What would be said of the parameters if they had a covariance (p, p)."""
        given = self.theta, covariance, self._free, self._first_variances
        return LazyParameters(partial(self.reporter.of_free, *given))
