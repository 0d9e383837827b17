"""The arms' plan while a hand may be on its way: what it gives rises and falls along ramps, the others bear the rest.

One hand at a time lets go. A hand with share s of its wrench gives s times what the plan of all arms asks of it, and
the others are planned for what is left, so that the cart gets what it is to get as long as they can give it. Where its
rate of change is limited, a ramp takes as long as that needs. So it is with an arm that gives little of what it is
told (command_tracking.py): the others bear what it does not, and when it is back it is loaded along a ramp.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from cartgrasp.arms import Arm
from cartgrasp.contacts import ContactWrenches
from cartgrasp.frames import Array, wrap_angle
from cartgrasp.model import CartModel
from cartgrasp.motion import Estimate, Motion
from cartgrasp.roles import Plan as AnyPlan
from cartgrasp.roles import ReferencePath
from cartgrasp.simulation.integrate import held

from ..contacts.contact_regions import DISTANCE_TOLERANCE
from ..limits import WrenchRate
from ..limits.wrench_rate import towards
from ..plan import RELAXED, Plan
from ..planner import WrenchPlanner
from ..quadratic_program import OPTIMAL
from ..schedule.schedule import wanted_wrench
from ..tick.stopping import Stop
from ..tick.terms import why_no_posture
from .command_tracking import probing
from .hand import Hand, Phase, Point, RegraspTimes, point_of

RETRY_INTERVAL = 0.2  # s until a hand that may not let go is asked again
LOOKAHEAD_SPACING = 0.1
"""s at most between the times within a regrasp at which the others' plans are made ahead; what a path asks for in less
takes a cart hardly off it."""
LOOKS_PER_TICK = 2
"""How many of these times plans are made at in a tick; each takes as long as a plan."""
COAST_STEP = 0.01  # s
NO_OTHER_HAND = "no other hand holds: the cart coasts"
Doing = tuple[str, Phase, bool] | None
"""The arm that gives less than it is planned to, what its hand does, and whether it is idle."""


class Given(NamedTuple):
    """What the arms give, and the plan that says so."""

    wrenches: ContactWrenches
    plan: AnyPlan


class Ahead(NamedTuple):
    """What is known of the time to come: the reference, the cart as it is believed to be and to move at `time` (s), and
    the wrench (3,) in {b} that it is to feel now; `estimate`, and what would `stop` it, are for planners with limits of
    the cart. It goes on at a `pace`, as a share of the reference's speed."""

    reference: ReferencePath
    cart: CartModel
    motion: Motion
    time: float
    wrench_b: Array
    estimate: Estimate | None = None
    stop: Stop | None = None
    pace: float = 1.0


class LookAhead(NamedTuple):
    """Up to which time of the path, `until` (s), the others can bear what is asked while a hand goes to a target."""

    name: str
    target: Point
    until: float


# Many methods: what passes between two ticks, who may leave, and what each arm is told meanwhile.
class Regrasps:
    """The hands of some arms, from tick to tick, and what they give."""

    def __init__(
        self, planner: WrenchPlanner, arms: Sequence[Arm], times: RegraspTimes, drift: float, apart: float = 0.0
    ) -> None:
        """Hands stay so many m `apart`."""
        self._planner, self._times, self._drift, self._apart = planner, times, drift, apart
        names = [arm.name for arm in arms]
        self._arms = {arm.name: arm for arm in arms}
        self._yaws = {arm.name: arm.yaw for arm in arms}
        rest = {name: [other for other in names if other != name] for name in names if len(names) > 1}
        self._others = {name: planner.for_arms(others) for name, others in rest.items()}
        self._rates = {arm.name: WrenchRate.of([arm], planner.period) for arm in arms}
        self._in_time = self._others
        """The others after as long as it takes: what they can give without limits of rates."""
        if any(self._rates.values()):
            self._in_time = {name: planner.for_arms(others, at_any_rate=True) for name, others in rest.items()}
        self.hands: dict[str, Hand] = {}
        self.kept: dict[str, str] = {}
        """Why hands stay that were to go."""
        self._asked: dict[str, tuple[Point, float]] = {}
        self._look: LookAhead | None = None
        self._idle: frozenset[str] = frozenset()
        self._last: tuple[Doing, Mapping[str, Array]] = (None, {})

    def warm_up(self) -> None:
        for planner in {*self._others.values(), *self._in_time.values()}:
            planner.warm_up()

    @property
    def contacts(self) -> dict[str, Array]:
        return {name: np.array(hand.point) for name, hand in self.hands.items()}

    def _beside(self, name: str) -> dict[str, Array]:
        """Contacts of the others."""
        return {other: point for other, point in self.contacts.items() if other != name}

    def go_on(self, duration: float, idle: Collection[str] = ()) -> None:
        """So many s later; the arms that are `idle` give little of what they are told."""
        back, self._idle = self._idle.difference(idle), frozenset(idle)
        for name in back:
            if self.hands[name].phase is Phase.HOLDS:
                self.hands[name] = replace(self.hands[name], phase=Phase.LOADS, share=0.0)
        if self.busy is not None:
            free = {name: not self._towards(name, np.zeros(6)).any() for name in self.hands}
            self.hands = {name: hand.after(duration, self._times, free[name]) for name, hand in self.hands.items()}

    def begin(self, contacts: Mapping[str, Array]) -> None:
        """With hands that hold."""
        self.hands = {name: Hand(point_of(contacts[name])) for name in self._yaws}

    def restart(self, hands: Mapping[str, Hand], wrenches: Mapping[str, Array]) -> None:
        """With hands that may be on their way, and what they gave."""
        self.hands = {name: hands[name] for name in self._yaws}
        self._last = None, wrenches
        self._start_from(self.busy)

    def send(self, contacts: Mapping[str, Array], ahead: Ahead, time: float) -> None:
        """The first hand that is to hold elsewhere, and may, is sent there; `time` (s) goes on where the cart waits. To
        look ahead takes some ticks."""
        look, self._look = self._look, None
        for name, hand in self.hands.items():
            target = point_of(contacts[name])
            if target == hand.point or hand.phase is not Phase.HOLDS:
                self.kept.pop(name, None)
            elif self._may_ask(name, look) and self._is_due(name, target, time):
                why = self._why_not(name, target, ahead, look)
                if why is None:
                    continue
                if why:
                    self.kept[name], self._asked[name] = why, (target, time)
                    continue
                self.kept.pop(name, None)
                self.hands[name] = hand.sent(target)

    @property
    def busy(self) -> str | None:
        """The arm whose hand does not hold wholly: one that leaves or is away before one that is loaded again."""
        partly = [name for name, hand in self.hands.items() if hand.phase is not Phase.HOLDS]
        return min(partly, key=lambda name: self.hands[name].phase is Phase.LOADS, default=None)

    def plan(self, wrench_b: Array, estimate: Estimate | None = None, stop: Stop | None = None) -> Given:
        """What the arms give for a planar wrench (3,) in {b}; `estimate` is for planners with limits of the cart, and
        `stop` says which wrench (3,) brings it to rest where nothing is within these."""
        name, contacts = self.busy or min(self._idle, default=None), self.contacts
        doing = None if name is None else (name, self.hands[name].phase, name in self._idle)
        if doing != self._last[0] and self._last[1]:
            self._start_from(name)
        if name is None:
            plan = self._planner.plan_or_hold(wrench_b, contacts, estimate, stop=stop)
            given = plan.contact_wrenches
        else:
            plan, given = self._shared(name, wrench_b, estimate, stop)
        self._last = doing, given.wrenches
        return Given(given, plan)

    def _shared(
        self, name: str, wrench_b: Array, estimate: Estimate | None, stop: Stop | None
    ) -> tuple[Plan, ContactWrenches]:
        share, own, contacts = self.hands[name].share, np.zeros(6), self.contacts
        if share > 0:
            whole = self._planner.plan_or_hold(wrench_b, contacts, estimate, stop=stop)
            own = self._borne(name, whole.contact_wrenches.wrenches[name])
            if name in self._idle and name not in self._others:
                return whole, ContactWrenches({name: own}, contacts, self._yaws)
        elif not self.hands[name].is_away:
            own = self._towards(name, own)
        away = frozenset({name}) if self.hands[name].is_away else frozenset()
        if name not in self._others:
            plan = Plan(RELAXED, {name: own}, contacts, self._yaws, message=NO_OTHER_HAND)
            return plan, ContactWrenches({name: own}, contacts, self._yaws, away)
        felt = np.zeros(6) if name in self._idle else own
        beside = ContactWrenches({name: felt}, {name: contacts[name]}, self._yaws)
        plan = self._others[name].plan_or_hold(wrench_b, self._beside(name), estimate, stop=stop, beside=beside)
        given = plan.contact_wrenches.wrenches
        wrenches = {other: own if other == name else self._borne(other, given[other]) for other in contacts}
        return plan, ContactWrenches(wrenches, contacts, self._yaws, away)

    def _borne(self, name: str, planned: Array) -> Array:
        """What an arm is told of a wrench (6,) that is planned for it."""
        wrench = self.hands[name].share * planned
        return self._towards(name, probing(wrench) if name in self._idle else wrench)

    def _towards(self, name: str, wanted: Array) -> Array:
        """A wrench (6,) as near to what is wanted as the arm's rates allow from what it gave last."""
        return towards(self._rates[name], self._last[1].get(name), wanted)

    def _start_from(self, name: str | None) -> None:
        """Planners go on from what was given last, where the hands that they plan for change."""
        given, contacts = self._last[1], self.contacts
        self._planner.start_from(given, contacts)
        if name in self._others:
            held = self._beside(name)
            self._others[name].start_from({other: given[other] for other in held}, held)

    def _may_ask(self, name: str, look: LookAhead | None) -> bool:
        return self.busy is None and self._look is None and (look is None or look.name == name)

    def _is_due(self, name: str, target: Point, time: float) -> bool:
        asked = self._asked.get(name)
        return asked is None or asked[0] != target or time >= asked[1] + RETRY_INTERVAL - 1e-9

    def _why_not(self, name: str, target: Point, ahead: Ahead, look: LookAhead | None) -> str | None:
        """In words; empty where it may go, None where it is still to look ahead."""
        if why := why_no_posture(self._arms[name], target):
            return why
        if idle := sorted(self._idle - {name}):
            return f"{', '.join(idle)} gives little of what it is told"
        for other in self._beside(name):
            if self._come_too_near(name, target, other):
                return f"it would come nearer than {self._apart:g} m to {other}"
        distance = math.dist(self.hands[name].point, target)
        if name in self._others:
            fresh = LookAhead(name, target, ahead.time - LOOKAHEAD_SPACING)
            look = fresh if look is None or look.target != target else look
            return self._why_others_cannot(look, ahead, ahead.time + self._times.lasting(distance))
        lasting = self._times.away(distance) + (self._times.unload + self._times.load) / 2
        return _why_cart_cannot_coast(ahead, lasting, self._drift)

    def _why_others_cannot(self, look: LookAhead, ahead: Ahead, end: float) -> str | None:
        """In words, what of the path up to its time `end` (s), or now, is too much for the other arms. Empty if
        nothing is, None where the next tick is to go on."""
        name = look.name
        times = np.minimum(look.until + LOOKAHEAD_SPACING * np.arange(1, LOOKS_PER_TICK + 1), end).tolist()
        wrenches = [wanted_wrench(ahead.reference, ahead.cart, time) for time in times]
        for wrench in [*wrenches, ahead.wrench_b] if times[-1] >= end else wrenches:
            plan = self._in_time[name].plan_or_hold(wrench, self._beside(name), ahead.estimate, stop=ahead.stop)
            if plan.status != OPTIMAL:
                force, moment = float(np.hypot(*wrench[:2])), float(wrench[2])
                return f"the others can't bear {force:.0f} N with {moment:.1f} N·m"
        self._look = look._replace(until=times[-1]) if times[-1] < end else None
        return "" if self._look is None else None

    def _come_too_near(self, name: str, target: Point, other: str) -> bool:
        """Whether a hand does at its target, or on its straight way there, where it isn't so near already."""
        start, there = self.hands[name].point, self.hands[other].point
        way, off = np.subtract(target, start), np.subtract(there, start)
        passed = start + way * np.clip(way @ off / (way @ way), 0.0, 1.0)
        on_its_way = math.dist(passed, there) < min(self._apart, math.dist(start, there)) - DISTANCE_TOLERANCE
        return on_its_way or math.dist(target, there) < self._apart - DISTANCE_TOLERANCE


def _why_cart_cannot_coast(ahead: Ahead, lasting: float, drift: float) -> str:
    """In words, by how much a cart that nobody holds for `lasting` s leaves its path beyond `drift` (m; rad as at 1 m);
    empty if it does not."""
    steps = max(1, round(lasting / COAST_STEP))
    state = ahead.cart.state(ahead.motion.pose_sb, ahead.motion.velocity)
    there = held(ahead.cart, state, np.zeros(3), ahead.time, (lasting / steps, steps))[:3]
    wanted = ahead.reference.at(ahead.time + ahead.pace * lasting).pose_sb
    off = max(float(np.hypot(*(there - wanted)[:2])), abs(float(wrap_angle(there[2] - wanted[2]))))
    return "" if off <= drift else f"the cart would coast {off:.2f} m off its path in {lasting:.1f} s"
