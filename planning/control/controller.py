"""`Controller`: what a robot's loop calls once a tick: tracker, filter, planner, contacts and regrasps as one."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike

from cartgrasp.arms import Arm
from cartgrasp.checks import brief, check_kind, check_known, listed, number, positive, shown
from cartgrasp.errors import UsageError
from cartgrasp.frames import Array, body_to_world
from cartgrasp.garbage_collection import freeze_live_objects
from cartgrasp.model import CartModel
from cartgrasp.motion import Estimate, Measurement, Reference
from cartgrasp.roles import ContactChoice, ContactQuery, ContactSource, Estimator, Plan, Planner, ReferencePath, Tracker

from ..contact_sources.by_name import contact_source
from ..contact_sources.choosing import Choosing
from ..contact_sources.strategies import FIXED
from ..limits import CartLimit, WrenchRate
from ..objectives import Objective
from ..planner import MAX_PERIOD, WrenchPlanner
from ..quadratic_program import OPTIMAL
from ..tick.stopping import Stop
from ..tracking import Gains, build_tracker
from .caution import IDLE, MAX_STEP_GAP, NO_ARM, OK, Caution, Pace, behind_of
from .command_tracking import CommandTracking, probed
from .controller_checks import (
    check_chosen,
    check_for_cart,
    check_learns_from,
    check_period,
    checked_contacts,
    made_estimator,
)
from .default_filter import default_filter
from .hand import RegraspTimes
from .progress import Progress
from .protective_stop import ProtectiveStop, Stage, braking_wrench
from .regrasps import Ahead, Given, Regrasps
from .rejection import Rejection
from .saved_state import Saved, as_first_guess, read_saved
from .step import Step

LOST_MOTION_HEALTHS = ("stale", "clock_went_back")
SENSES_LOST_HEALTHS = (*LOST_MOTION_HEALTHS, "no_wrench")
"""Healths under which no hand lets go, and nothing is fed forward."""
WAITING_FOR_POSE, STOPS, HELD = "waits for a first pose", "stops along its path, as it was told", "stopped"
MAX_DRIFT = 10.0
DEFAULT_REGRASP_TIMES, DEFAULT_CHOOSING = RegraspTimes(), Choosing()
DEFAULT_CAUTION, DEFAULT_REJECTION = Caution(), Rejection()


# Many methods: a step is one short stage after the other, each with its name.
class Controller:
    """Follows a reference with one cart and its arms; `step` is called once a tick.

    Args:
        cart: What is pushed, as it is first believed to be.
        arms: What holds it.
        reference: Where the cart shall be: a `PathReference`, which begins with the first step, whatever its time.
        contacts: Where to hold: "fixed", "periodic", "least-effort", "teach", "schedule", or a source of one's own.
        choosing: What these ways to choose contacts may ask, spend and take.
        regrasp: What a regrasp takes; None: hands are where they are wanted at once, as in the paper.
        held: Where the hands hold already, (3,) in {b} by arm; else they take hold where they are first wanted.
        objective: What is least, as for `WrenchPlanner`.
        cart_limits: Limits of the hands together, such as `Skid` and `TipOver`, for the cart as now estimated.
        confidence: The probability with which those of the floor hold, by the estimate's covariance; others, and with
            None all, hold for the cart as it is believed to be.
        caution: What to do less of while the estimate's health is not ok, no plan can be given, or the cart is behind;
            None: nothing.
        rejection: How much of `estimate.disturbance` is fed forward, where the estimator tells one; None: nothing.
        drift: m from its path that a cart may coast while its only hand regrasps.
        gains: Of the tracker.
        estimator: What learns; an `estimation.CartFilter` unless given.
        tracker: The law from errors to a wrench; the one that suits the cart unless given.
        planner: What spreads the wrench over the arms; a `WrenchPlanner` that relaxes unless given. With `regrasp` it
            must be a `WrenchPlanner`.
        period: s between ticks.
        learn: Whether tracker and contacts use the cart as estimated, not as first believed. While signs, units, axes
            or frames of sensors are surely wrong (`estimate.suspicions`) the cart is as first believed in any case.

    Raises:
        UsageError: An argument is of the wrong kind or out of bounds.

    Example:
        >>> import cartgrasp as cg
        >>> from planning import Controller, PathReference, chain, straight
        >>> cart = cg.CartModel(cg.Inertia(24.0, (0.3, 0.0), 2.0))
        >>> hands = [cg.Arm("left", [(-0.25, 0.2, 1.0)]), cg.Arm("right", [(-0.25, -0.2, 1.0)])]
        >>> controller = Controller(cart, hands, PathReference(chain(straight(2.0, 0.5))))
        >>> step = controller.step(cg.Measurement(0.0, pose=[0, 0, 0], velocity=[0, 0, 0]))
        >>> step.plan.status, step.words.split(";")[0]
        ('optimal', 'holds left at (−0.25, 0.20): fixed')
    """

    # Many parameters: the roles that a controller composes, each with a default.
    def __init__(
        self,
        cart: CartModel,
        arms: Sequence[Arm],
        reference: ReferencePath,
        *,
        contacts: str | ContactSource = FIXED,
        choosing: Choosing = DEFAULT_CHOOSING,
        regrasp: RegraspTimes | None = DEFAULT_REGRASP_TIMES,
        held: Mapping[str, ArrayLike] | None = None,
        objective: Objective | None = None,
        cart_limits: Sequence[CartLimit] = (),
        confidence: float | None = None,
        caution: Caution | None = DEFAULT_CAUTION,
        rejection: Rejection | None = DEFAULT_REJECTION,
        drift: float = 0.05,
        gains: Gains | None = None,
        estimator: Estimator | None = None,
        tracker: Tracker | None = None,
        planner: Planner | None = None,
        period: float = 0.01,
        learn: bool = True,
    ) -> None:
        positive("controller: period", period, MAX_PERIOD, "give s")
        number("controller: drift", drift, 0.0, MAX_DRIFT, "give m")
        if not callable(getattr(reference, "at", None)):
            raise UsageError(f"controller: reference: {shown(reference)} is no path; write PathReference(chain(…))")
        check_for_cart(reference, cart)
        check_kind("controller: choosing", choosing, Choosing, "write Choosing(every=3.0)")
        for name, given, kind in (
            ("caution", caution, Caution),
            ("rejection", rejection, Rejection),
            ("gains", gains, Gains),
        ):
            if given is not None:
                check_kind(f"controller: {name}", given, kind, f"write {kind.__name__}(), or None")
        self.cart, self.reference, self.period, self.learns = cart, reference, float(period), bool(learn)
        self._arms = listed("controller: arms", arms, Arm, "write [Arm(…)]")
        if planner is None:
            limits: dict[str, Any] = {"cart_limits": cart_limits, "confidence": confidence}
            planner = WrenchPlanner(cart, arms, objective=objective, period=period, relax=math.inf, **limits)
        elif cart_limits or confidence is not None or objective is not None:
            raise UsageError("controller: objective, cart_limits and confidence are the planner's; give them to yours")
        check_period(planner, self.period)
        self._planner, self._caution, self._rejection = planner, caution, rejection
        self._has_margins = isinstance(planner, WrenchPlanner) and planner.confidence is not None
        self._needs_estimate = isinstance(planner, WrenchPlanner) and planner.needs_estimate
        self._estimator = default_filter(cart, arms) if estimator is None else estimator
        self._names = frozenset(arm.name for arm in self._arms)
        self._rates = {arm.name: WrenchRate.of([arm], self.period) for arm in self._arms}
        check_learns_from(self._estimator, self._names, cart)
        told = rejection is not None and getattr(self._estimator, "tells_disturbance", False)
        self._tracker = build_tracker(cart.constraints, gains, told) if tracker is None else tracker
        if isinstance(contacts, str):
            contacts = contact_source(contacts, cart, arms, reference, choosing, regrasp or RegraspTimes())
        self._source: ContactSource = contacts
        self._regrasps: Regrasps | None = None
        if regrasp is not None:
            check_kind("controller: regrasp", regrasp, RegraspTimes, "write RegraspTimes(speed=0.5)")
            whole = self._planner
            check_kind("controller: planner", whole, WrenchPlanner, "or give regrasp=None")
            assert isinstance(whole, WrenchPlanner)
            self._regrasps = Regrasps(whole, self._arms, regrasp, drift, choosing.min_hand_distance)
        self._held: Mapping[str, Array] = checked_contacts(held, self._arms)
        self._last: Step | None = None
        self._first: Estimate | None = None
        self._observed: Estimate | None = None
        self._used: Estimate | None = None  # of which the cart was
        self._progress = Progress()
        self._knows_where = False  # once a pose was seen
        self._command_tracking = CommandTracking()
        self.is_stopped = False
        """Whether it was told to `stop`; it stands once the velocity of `step.reference` is zero."""

    def __repr__(self) -> str:
        source, arms = type(self._source).__name__, ", ".join(arm.name for arm in self._arms)
        return brief("Controller", self.cart.name, f"arms {arms}", source, f"period {self.period:g} s")

    def warm_up(self) -> None:
        """Does now what would cost at the first ticks, of all parts that have something to do."""
        for part in (self._planner, self._estimator, self._regrasps, self._source):
            getattr(part, "warm_up", lambda: None)()
        self.reference.at(0.0)  # which works out its pieces
        freeze_live_objects()

    def step(self, measurement: Measurement) -> Step:
        """One tick: takes in what was sensed, and says what the arms are to do."""
        estimate = self.observe(measurement)
        time = measurement.time
        progress, slowed = self._goes_on(estimate, time)
        pace, reference = progress.pace, progress.pace.reference(self.reference, time)
        believed = self._believed(estimate)
        model = self._used_by(believed).cart_on_floor() if self.learns else self.cart
        wanted = self._wanted(reference, believed, model, progress.stop)
        query = ContactQuery(pace.along, wanted, believed, self._held)
        chosen = ContactChoice(self._held, HELD) if self.is_stopped and self._held else self._source.contacts(query)
        check_chosen(chosen, self._names)
        told = self._for_planner(believed, progress.steady_time)
        stop = self._braking(believed, model, time)
        if self._regrasps is None:
            plan = self._planned(wanted, chosen.contacts, told, stop)
            gave = {} if self._last is None else self._last.wrenches
            given = Given(probed(plan.contact_wrenches, self._idle, self._rates, gave), plan)
            if self._idle and isinstance(self._planner, WrenchPlanner):
                self._planner.start_from(given.wrenches.wrenches, given.wrenches.contacts)
        else:
            ahead = Ahead(self.reference, model, estimate.motion, pace.along, wanted, told, stop, pace.share)
            elapsed = self._progress.elapsed(time, self._longest_gap)
            given = self._with_hands(self._regrasps, chosen, ahead, estimate.health, (elapsed, progress.steady_time))
        self._progress = progress
        self._held = given.wrenches.contacts
        hands, kept = ({}, {}) if self._regrasps is None else (dict(self._regrasps.hands), dict(self._regrasps.kept))
        self._last = Step(
            time, given.wrenches, given.plan, estimate, reference, hands, chosen.why, kept, slowed, self._idle
        )
        return self._last

    def observe(self, measurement: Measurement) -> Estimate:
        """Takes in what was sensed between two ticks, such as the wrenches that the arms then gave. Arms without a
        contact hold where they were to hold."""
        check_kind("controller", measurement, Measurement, "write Measurement(time, pose=…, velocity=…)")
        if not self._names.issuperset(measurement.wrenches):
            check_known("measurement: wrenches", measurement.wrenches, self._names)
        if not measurement.contacts.keys() >= measurement.wrenches.keys():
            measurement = replace(measurement, contacts={**self._held, **measurement.contacts})
        estimate = self._estimator.update(measurement)
        if self._last is not None:
            self._command_tracking = self._command_tracking.heard(self._last.wrenches, measurement)
        self._first, self._observed = self._first or estimate, estimate
        self._knows_where = self._knows_where or estimate.health != "stale"
        return estimate

    def stop(self) -> None:
        """Until `resume`: the cart comes to rest along its path, by the ramp of `Caution.change`, and is held there. No
        further hand lets go."""
        self.is_stopped = True
        if self._last is None:  # nothing has begun that a ramp would end
            self._progress = self._progress._replace(pace=Pace(self._progress.pace.along, 0.0))

    def resume(self) -> None:
        """Goes on along the path from where it stopped, by the same ramp."""
        self.is_stopped = False

    @property
    def is_done(self) -> bool:
        """Whether the last step was at the end of the reference, which a cautious controller reaches later."""
        return self._last is not None and self._progress.pace.along >= self.reference.duration

    # --- saved and restored -------------------------------------------------------------------------------

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Writes where the hands are, what they gave, and the cart as it is now known, each parameter with its standard
        deviation; the filter's correlations and recent samples are not kept (saved_state.py)."""
        last, now = self._last, self._observed
        if last is None or now is None:
            raise UsageError("controller: there is nothing to save before the first step")
        cart = as_first_guess(self._believed(now)) if self.learns else self.cart
        motion, pace = now.motion if self._knows_where else None, self._progress.pace
        how = pace.along, pace.share, self.is_stopped
        return Saved(self._progress.time, *how, cart, last.placed, last.wrenches, motion).save(path)

    @classmethod
    def restored(
        cls, path: str | os.PathLike[str], arms: Sequence[Arm], reference: ReferencePath, **options: Any
    ) -> Self:
        """One that goes on from what was saved, and along the path from where it was by then; `options` are those of
        the constructor, which are not kept. `estimator` may be what makes one of the cart that was saved, such as
        `lambda cart: DisturbedFilter(cart, ["left"])`; one that is made already goes on from what it knows."""
        saved, given = read_saved(path), options.get("estimator")
        is_new = given is None or (callable(given) and not hasattr(given, "update"))
        if given is not None and is_new:
            options["estimator"] = made_estimator(given, saved.cart)
        if set(saved.hands) != {arm.name for arm in arms}:
            raise UsageError(f"controller: {path} has the hands of {', '.join(saved.hands)}; give these arms")
        controller = cls(saved.cart, arms, reference, **options)
        controller._progress = Progress(saved.time, pace=Pace(saved.along, saved.share))
        controller._held = {name: np.array(hand.point) for name, hand in saved.hands.items()}
        controller.is_stopped = saved.is_stopped
        if saved.motion is not None and is_new:
            pose, nu = saved.motion[:2]
            controller.observe(Measurement(saved.time, pose, body_to_world(pose[2]) @ saved.cart.basis_b @ nu))
        if controller._regrasps is not None:
            controller._regrasps.restart(saved.hands, saved.wrenches)
        elif isinstance(controller._planner, WrenchPlanner):
            controller._planner.start_from(saved.wrenches, controller._held)
        return controller

    # --- within a tick ------------------------------------------------------------------------------------

    @property
    def _longest_gap(self) -> float:
        """s between ticks; longer is a pause, in which neither path nor hands go on."""
        return max(MAX_STEP_GAP, 2.0 * self.period)

    def _goes_on(self, estimate: Estimate, time: float) -> tuple[Progress, str]:
        """How far the loop is by now, and why the cart is to be behind where its path says."""
        caution, last, before = self._caution, self._last, self._progress
        pace, now = before.pace, before.at(time)
        waits = "" if self._knows_where else WAITING_FOR_POSE
        if caution is None:
            elapsed = before.elapsed(time, self._longest_gap)
            wanted, slowed = (0.0, STOPS) if self.is_stopped else (1.0, waits)
            return now._replace(pace=pace.after(elapsed, wanted, DEFAULT_CAUTION.change)), slowed
        there = last.reference if last is not None and pace.share > 0.0 else self.reference.at(pace.along)
        if self._knows_where:
            stop = before.stop.after(now.steady_time, self.cart, there, estimate, caution.astray)
            now = now._replace(stop=stop)
        if now.stop.stage is not Stage.DRIVES:
            return now._replace(pace=Pace(pace.along, 0.0)), now.stop.why
        planned, behind, health = (OPTIMAL, ""), 0.0, OK  # nothing was to be given before the first step
        if last is not None:
            planned, health = (last.plan.status, getattr(last.plan, "stops", "")), estimate.health
            if health == OK and self._idle:
                health = NO_ARM if self._idle.keys() == self._names else IDLE
            behind = behind_of(there, estimate.motion.pose_sb)
        wanted, slowed = caution.wanted(health, planned, behind) if self._knows_where else (0.0, waits)
        wanted, slowed = (0.0, STOPS) if self.is_stopped else (wanted, slowed)
        if self._has_margins and (wider := caution.wider(health)):
            slowed = f"{slowed}; {wider}" if slowed else wider
        elapsed = time - before.time if math.isfinite(before.time) else 0.0
        return now._replace(pace=pace.after(elapsed, wanted, caution.change, self._longest_gap)), slowed

    def _wanted(self, reference: Reference, believed: Estimate, model: CartModel, stop: ProtectiveStop) -> Array:
        """The planar wrench (3,) in {b} that the cart should feel."""
        if not self._knows_where or stop.stage is Stage.LETS_GO:
            return np.zeros(3)
        if stop.stage is Stage.BRAKES:
            # What was learned may be wrong by now, and so may be what pushes: nothing is fed forward.
            model = max(model, self.cart, key=lambda cart: cart.inertia.mass)
            return braking_wrench(model, believed.motion, reference.time, stop.share, stop.crept)
        return self._tracker.wrench_b(reference, believed.motion, model) + self._against(believed)

    def _believed(self, estimate: Estimate) -> Estimate:
        """What is acted on: where sensors surely don't mean what they say, nothing that was learned from them."""
        first = self._first
        if first is None or not self._is_misled:
            return estimate
        time, motion, health, suspicions = estimate.time, estimate.motion, estimate.health, estimate.suspicions
        return first._replace(time=time, motion=motion, health=health, suspicions=suspicions, disturbance=None)

    def _used_by(self, believed: Estimate) -> Estimate:
        """The estimate of whose cart the tracker thinks."""
        used, caution = self._used, self._caution
        if used is None or caution is None or self._is_misled or caution.is_used(believed, used):
            self._used = believed
        return self._used or believed

    @property
    def _is_misled(self) -> bool:
        """Whether sensors surely don't mean what they say."""
        observed = self._observed
        return observed is not None and any(getattr(one, "is_refused", False) for one in observed.suspicions)

    @property
    def _idle(self) -> Mapping[str, float]:
        """The arms that give little of what they are told, with how much; by sensors that mean what they say."""
        return {} if self._is_misled else self._command_tracking.idle

    def _against(self, estimate: Estimate) -> Array:
        """Planar wrench (3,) against what pushes beside all that is known."""
        if self._rejection is None or estimate.disturbance is None or estimate.health in SENSES_LOST_HEALTHS:
            return np.zeros(3)
        return self.cart.planar_wrench(self._rejection.fed_forward(estimate.disturbance))

    def _braking(self, believed: Estimate, model: CartModel, time: float) -> Stop | None:
        """What brings the cart to rest; where nobody knows how it moves, nothing is what stops it."""
        if not self._needs_estimate:
            return None
        if not self._knows_where or believed.health in LOST_MOTION_HEALTHS:
            return lambda share: np.zeros(3)
        return lambda share: braking_wrench(model, believed.motion, time, share) + self._against(believed)

    def _planned(self, wanted: Array, contacts: Mapping[str, Array], told: Estimate | None, stop: Stop | None) -> Plan:
        if isinstance(self._planner, WrenchPlanner):
            return self._planner.plan_or_hold(wanted, contacts, told, stop=stop)
        return self._planner.plan_or_hold(wanted, contacts, told)

    def _for_planner(self, estimate: Estimate, time: float) -> Estimate | None:
        """The estimate; to a planner that only tells by it what wheels take, none whose motion is lost."""
        told = estimate._replace(time=time)  # stamps may go back, and then it would be taken for stale
        if not self._needs_estimate:
            return None if estimate.health in LOST_MOTION_HEALTHS else told
        return told if self._caution is None else self._caution.widened(told)

    def _with_hands(
        self, regrasps: Regrasps, chosen: ContactChoice, ahead: Ahead, health: str, times: tuple[float, float]
    ) -> Given:
        """One that regrasps goes on; another may only leave while the senses are there. `times` are the s elapsed and
        those that never go back."""
        elapsed, steady_time = times
        if not regrasps.hands:
            regrasps.begin(self._held or chosen.contacts)
        regrasps.go_on(elapsed, self._idle.keys())
        if health not in SENSES_LOST_HEALTHS:
            regrasps.send(chosen.contacts, ahead, steady_time)
        return regrasps.plan(ahead.wrench_b, ahead.estimate, ahead.stop)
