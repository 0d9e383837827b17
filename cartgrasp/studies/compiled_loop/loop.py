"""A scenario's run by compiled code, with the regression's rows and what has no proven plan done in Python."""

from __future__ import annotations

import math
from functools import cached_property
from typing import NamedTuple

import numpy as np

from estimation.health import overall_health
from estimation.online.cart_filter import core_of
from estimation.online.kernels.row_algebra import BLOCK_END_WIDTH, ROW_BLOCK_DURATION, SMOOTHING_LAG
from estimation.online.kernels.sensor_health import said_of
from estimation.online.learning_filter import LearningFilter
from estimation.online.unknown_slope import of_cart
from planning.allocation.allocation_template import AllocationTemplate
from planning.contact_sources.strategies import FIXED, PERIODIC
from planning.planner import WrenchPlanner
from planning.tick.compiled_allocation import CompiledAllocation

from ...bounce import walls_of
from ...compiled_dynamics import MAX_STEP_STIFFNESS
from ...effects.compiled import WheelForce
from ...errors import PlantError
from ...frames import Array, body_to_world
from ...inertia import N_PHI, physical_jacobian
from ...kernels.jit import Ints
from ...logs.run_log import ArmLog, RunLog
from ...motion import Measurement
from ...simulation.plant import MAX_STEP
from ...simulation.record import RunRecord
from ...simulation.record import Series as Estimated
from ..scenario import LEARNING, MODEL_PLANT, Scenario, with_truth
from . import tick
from .run_inputs import inputs_of, noise_of
from .values import LoopState, Workspaces

MAX_CONTROL_PERIOD = 0.05
SPARE_MOMENTS = 8
"""Moments that there is room for beside those of a row."""


def covers(scenario: Scenario) -> bool:
    """Whether `compiled_run` does what `Scenario.run` does: our plant, a cart that is steered and meets no stop,
    effects with kernels, none of sensors, a filter that learns from noisy wrenches, contacts that are fixed or go
    round at once, linear limits, none of the cart, no caution."""
    truth, guess = scenario.truth, scenario.guess
    if walls_of(truth) or any(effect.quickness(1.0) for effect, _, _ in truth.force_effects):
        return False
    at_once = scenario.contacts == FIXED or (scenario.contacts == PERIODIC and scenario.regrasp is None)
    if scenario.estimation != LEARNING or scenario.plant != MODEL_PLANT or not at_once:
        return False
    if scenario.cart_limits or scenario.caution is not None or scenario.disturbances:
        return False
    plain = all(cart.is_compiled and not cart.slip_compliance and not cart.sensor_effects for cart in (truth, guess))
    steered = guess.constraints.n_rows == 1 and truth.rolling == guess.rolling and scenario.period <= MAX_CONTROL_PERIOD
    plain_arms = all(arm.reach is None and arm.postures is None for arm in scenario.arms)
    still = plain_arms and not any(np.isfinite(arm.wrench_rate).any() for arm in scenario.arms)
    headings_alone = all(isinstance(effect, WheelForce) for effect in guess.memory_drivers)
    if not (plain and steered and still and headings_alone):
        return False
    return _allocation(scenario) is not None


def compiled_run(scenario: Scenario) -> RunRecord:
    """As `Scenario.run`, to round-off, of what is covered; of the estimate's healths the last alone."""
    return with_truth(_Run(scenario).record(), scenario.truth)


def _allocation(scenario: Scenario) -> CompiledAllocation | None:
    template = AllocationTemplate.of(scenario.guess, scenario.arms)
    return CompiledAllocation.of(template, template.cost(np.zeros(template.n)))


class Belief(NamedTuple):
    """What is believed of the parameters (p,) from a step on, with covariance (p, p)."""

    step: int
    theta: Array
    covariance: Array


class _Run:
    """One run, from its beginning on."""

    def __init__(self, scenario: Scenario) -> None:
        self.scenario, truth = scenario, scenario.truth
        self.names, yaws = [arm.name for arm in scenario.arms], {arm.name: arm.yaw for arm in scenario.arms}
        self.core: LearningFilter = core_of((scenario.guess, self.names, scenario.noise, scenario.prior, yaws))
        allocation = _allocation(scenario)
        assert allocation is not None
        self.course = inputs_of(scenario)
        state = truth.state()
        self.series = noise_of(scenario, self.course.time, len(state))
        self._begin(state)
        self.blocks = self._blocks(allocation)
        self.held = self._held(state)
        self.at: Ints = np.array([0, tick.STAGE_TRACK, 1, -1, 0])
        self.statuses = ["optimal"] * len(self.course.time)
        self.known = [Belief(0, self.core.learner.learned.theta, self.core.learner.learned.reported_covariance)]

    # --- to the end -------------------------------------------------------------------------------------------

    def record(self) -> RunRecord:
        s = self.scenario
        stable = MAX_STEP_STIFFNESS if s.truth.effects else np.inf
        limits = s.period, s.plant_timestep or MAX_STEP, stable
        given = self.course, self.blocks, self.held, self.series, self.at, limits
        while (code := tick.run_steps(*given)) != tick.RUN_DONE:
            if code == tick.ROW_DUE:
                self._take_row()
            elif code == tick.PLAN_MISSING:
                self._plan()
            else:
                time = self.course.time[self.at[tick.I_STEP]] + s.period
                raise PlantError(f"the simulated cart's state is not finite at t = {time:.3f} s")
        return self._recorded()

    def _take_row(self) -> None:
        """What `LearningFilter.take` does with a row, and with what it teaches."""
        k, learner = int(self.at[tick.I_STEP]), self.core.learner
        self.at[tick.I_MOMENTS] = learner.note_moments(int(self.at[tick.I_MOMENTS]), float(self.course.time[k - 1]))
        self.at[tick.I_UNFINISHED] = learner.unfinished is not None
        learned = learner.learned
        self.core.motion.believe(learned.theta, learned.covariance)
        if learned.theta is not self.known[-1].theta:
            self.held.theta[:], self.held.believed[:] = learned.theta, learner.believed
            self.known.append(Belief(k, learned.theta, learned.reported_covariance))

    def _plan(self) -> None:
        """A wrench whose plan isn't proven by the kernels alone."""
        k = self.at[tick.I_STEP]
        before = self.course.points[self.course.place[max(k - 1, 0)]]
        self._planner.start_from(self._by_arm(self.held.wrenches), dict(zip(self.names, before, strict=True)))
        contacts = dict(zip(self.names, self.course.points[self.course.place[k]], strict=True))
        plan = self._planner.plan_or_hold(self.held.wanted, contacts=contacts)
        self.held.wrenches[:] = np.concatenate([plan.contact_wrenches.wrenches[name] for name in self.names])
        self.statuses[k] = plan.status
        self.at[tick.I_STAGE] = tick.STAGE_APPLY

    @cached_property
    def _planner(self) -> WrenchPlanner:
        s = self.scenario
        planner = WrenchPlanner(s.guess, list(s.arms), period=s.period, relax=np.inf)
        planner.warm_up()
        return planner

    # --- what the kernels are given ---------------------------------------------------------------------------

    def _begin(self, state: Array) -> None:
        """The first sample of the motion."""
        series, basis = self.series, self.scenario.truth.basis_b
        series.pose[0] += state[:3]
        series.velocity[0] += body_to_world(state[2]) @ basis @ state[3 : 3 + basis.shape[1]]
        velocity = None if np.isnan(series.velocity[0]).any() else series.velocity[0]
        self.core.take(Measurement(0.0, series.pose[0], velocity))

    def _blocks(self, allocation: CompiledAllocation) -> Workspaces:
        s, tracker = self.scenario, self.core.learner.tracker
        tracker.make_room(math.ceil((ROW_BLOCK_DURATION + BLOCK_END_WIDTH + SMOOTHING_LAG) / s.period) + SPARE_MOMENTS)
        truth, learned = s.truth.dynamics, self.core.cart.dynamics
        carts = truth.floats, truth.ints, learned.floats, learned.ints
        return Workspaces(*carts, *allocation.blocks, *self.core.motion.blocks, *tracker.blocks)

    def _held(self, state: Array) -> LoopState:
        cart, N, P = self.core.cart, len(state), self.scenario.truth.parameters
        n, p, k, f = len(cart.state_names), len(cart.parameters), len(cart.memory_names), cart.constraints.n_free
        dynamics = cart.dynamics
        widest = max(f * (1 + n + f + p) + k * (1 + n + p), dynamics.n_sums + k + 3 * dynamics.most_stictions)
        given = np.concatenate([np.zeros(N + 1), P, np.zeros(3 + 2)])[None]
        return LoopState(
            state=state,
            theta=self.core.learner.learned.theta.copy(),
            believed=self.core.learner.believed.copy(),
            wrenches=np.zeros(6 * len(self.names)),
            wanted=np.zeros(3),
            seen=np.full(6, np.nan),
            unfelt=np.full(1, np.nan),
            given=given,
            found=np.zeros((1, N * (4 + N + len(P)))),
            nothing=np.zeros((1, 0)),
            asked=np.zeros((1, n + 1 + p + f)),
            states=np.zeros((2, n + 1 + p)),
            told=np.zeros((2, widest)),
        )

    # --- what is left behind ----------------------------------------------------------------------------------

    def _by_arm(self, values: Array) -> dict[str, Array]:
        return {name: values[..., 6 * i : 6 * i + 6] for i, name in enumerate(self.names)}

    def _recorded(self) -> RunRecord:
        series, course, truth = self.series, self.course, self.scenario.truth
        points, felt = course.points[course.place], self._by_arm(series.felt)
        arms = {name: ArmLog(points[:, i], felt[name]) for i, name in enumerate(self.names)}
        velocity = None if np.isnan(series.velocity).all() else series.velocity
        steps, theta, covariance = (np.array(part) for part in zip(*self.known, strict=True))
        steps = np.diff(np.append(steps, len(course.time)))
        partials, of_phi = physical_jacobian(theta[:, :N_PHI])[:, 1:3], covariance[:, :N_PHI, :N_PHI]
        headings = [i for i, name in enumerate(truth.state_names) if "heading" in name]
        learned = self.core.learner.learned
        report = of_cart(learned.report, self.scenario.guess)
        values, std = (np.repeat(part, steps, axis=0) for part in learned.reporter.numbers(theta, covariance))
        return RunRecord(
            log=RunLog(course.time, series.pose, velocity, arms),
            cart=self.scenario.guess,
            pose=series.state[:, :3].copy(),
            velocity=series.state[:, truth.velocity_slice].copy(),
            reference_pose=course.pose,
            reference_velocity=course.velocity,
            wrenches=self._by_arm(series.wrenches),
            parameters={
                name: Estimated(values[:, i], std[:, i], None, one.unit) for i, (name, one) in enumerate(report.items())
            },
            caster_headings=series.state[:, headings] if headings else None,
            statuses=tuple(self.statuses),
            identifiable={name: one.identifiable for name, one in report.items()},
            healths=(str(overall_health(said_of(self.core.motion.now.health), self.core.learner.health)),),
            com_covariance=np.repeat(partials @ of_phi @ np.swapaxes(partials, 1, 2), steps, axis=0),
        )
