"""What a controller says in a tick."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

from cartgrasp.checks import brief, digits
from cartgrasp.contacts import ContactWrenches
from cartgrasp.frames import Array
from cartgrasp.motion import Disturbance, Estimate, Reference
from cartgrasp.roles import Plan

from ..plan import USABLE
from .hand import Hand, Phase, point_of


@dataclass(frozen=True, eq=False)
class Step:
    """What the arms do from `time` (s) on, and by what.

    `given` are their wrenches, with where the hands are; `reference` is where the cart is to be by now, later than its
    path says where `slowed` says why. `plan` is the plan of the hands that hold wholly, where one is on its way. `why`
    says why the contacts were chosen, `kept` by arm why a hand stays that was to go, `idle` which share of what they
    are told those arms are felt to give that give little.
    """

    time: float
    given: ContactWrenches
    plan: Plan
    estimate: Estimate
    reference: Reference
    hands: Mapping[str, Hand] = field(default_factory=dict)
    why: str = ""
    kept: Mapping[str, str] = field(default_factory=dict)
    slowed: str = ""
    idle: Mapping[str, float] = field(default_factory=dict)

    def __repr__(self) -> str:
        arms = (
            f"{name}: {digits(wrench.tolist())} at {digits(self.contacts[name].tolist())}"
            for name, wrench in self.wrenches.items()
        )
        top = brief("Step", f"t = {digits(self.time)} s", f"plan {self.plan.status}", f"health {self.health}")
        return "\n".join([top, *(f"  {arm}" for arm in arms), f"  {self.words}"])

    @property
    def wrenches(self) -> Mapping[str, Array]:
        """(6,) in {a} by arm: what each is to do to the cart, exactly zero while its hand is on its way."""
        return self.given.wrenches

    @property
    def contacts(self) -> Mapping[str, Array]:
        """(3,) in {b} by arm: where each holds, or its hand is to be."""
        return self.given.contacts

    @property
    def health(self) -> str:
        """The health of the estimate, in one word."""
        return self.estimate.health

    @property
    def disturbance(self) -> Disturbance | None:
        """What pushes the cart beside all that is known; None where nobody looks for it."""
        return self.estimate.disturbance

    @cached_property
    def words(self) -> str:
        """What each hand does, where, and why; whether the plan is not optimal, what else pushes, and what is slow."""
        hands = [self._of_hand(name, hand) for name, hand in self.placed.items()]
        pushed = self.disturbance is not None and self.disturbance.acts
        message = "" if self.plan.status in USABLE else getattr(self.plan, "message", "")
        why = f": {message}" if message else ""
        told = [] if self.plan.status == "optimal" else [f"the plan is {self.plan.status}{why}"]
        told += [stops] if (stops := getattr(self.plan, "stops", "")) else []
        told += [f"at its limit is {joint}" for joint in getattr(self.plan, "limiting_joints", ())]
        told += ["something else pushes the cart"] if pushed else []
        told += [f"{arm} is felt to give {100 * share:.0f} % of what it is told" for arm, share in self.idle.items()]
        return "; ".join([*hands, *told, *([self.slowed] if self.slowed else [])])

    @property
    def placed(self) -> Mapping[str, Hand]:
        """The hands, which all hold where regrasps take no time."""
        return self.hands or {name: Hand(point_of(contact)) for name, contact in self.contacts.items()}

    def _of_hand(self, name: str, hand: Hand) -> str:
        here = _place(hand.point)
        if name in self.kept:
            return f"keeps {name} at {here}: {self.kept[name]}"
        why = f": {self.why}" if self.why else ""
        match hand.phase:
            case Phase.HOLDS:
                return f"holds {name} at {here}{why}"
            case Phase.UNLOADS | Phase.MOVES:
                from_here = f" at {here}, to go" if hand.phase is Phase.UNLOADS else ""
                return f"{hand.phase} {name}{from_here} to {_place(hand.target or hand.point)}{why}"
        return f"{hand.phase.value.replace('takes hold', 'takes hold with')} {name} at {here}{why}"


def _place(point: tuple[float, float, float]) -> str:
    return f"({point[0]:.2f}, {point[1]:.2f})".replace("-", "−")
