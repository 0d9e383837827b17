"""`Plan`: what a planner answers, with its proof."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple, Self

from cartgrasp.arms import Arm
from cartgrasp.checks import brief, digits
from cartgrasp.contacts import ContactWrenches
from cartgrasp.errors import UsageError
from cartgrasp.floor_reaction import WheelForces
from cartgrasp.frames import PLANAR, Array

from .allocation.infeasibility import Certificate, Nearest, arms_as_dict
from .quadratic_program import INFEASIBLE, NUMERICAL, OPTIMAL, QPSolution, QuadraticProgram, Residuals

if TYPE_CHECKING:
    from .polytopes.wrench_polytope import WrenchPolytope

RELAXED, INVALID_INPUT, STALE_ESTIMATE, TIMEOUT = "relaxed", "invalid_input", "stale_estimate", "timeout"
USABLE = OPTIMAL, RELAXED
"""Statuses of a plan that gives what is asked, or what is nearest."""
UNSOLVED = INFEASIBLE, NUMERICAL, TIMEOUT
"""Statuses where what was asked is understood, and no wrench was found."""


class ChoiceProof(NamedTuple):
    """No choice of contacts costs less than `bound` (of the objective and of switching); `gap` is relative to
    max(1, cost); `solved` counts programs; `switching` is what the plan's contacts cost beside the objective."""

    bound: float
    gap: float
    solved: int
    switching: float = 0.0

    def as_dict(self) -> dict[str, Any]:
        document = {"bound": _finite(self.bound), "gap": _finite(self.gap), "solved": self.solved}
        return document | ({"switching": self.switching} if self.switching else {})


class Figures(NamedTuple):
    """Figures of a plan that has wrenches: `effort` is `sum weight component²`, `active` names the limits whose
    multipliers are not negligible."""

    effort: float | None = None
    active: tuple[str, ...] = ()
    residuals: Residuals | None = None
    choice: ChoiceProof | None = None


# Many methods: what users read of a plan, each worked out when it is asked for, since a tick asks for none of it.
@dataclass(frozen=True, eq=False)
class Plan:
    """A status, and when it is `optimal` or `relaxed` wrenches (6,) in {a} at contacts (3,) in {b}, by arm.

    When `infeasible`, `certificate` proves it and holds the nearest plan; `relaxed` is that nearest plan. `held` is
    what `plan_or_hold` gives instead where there are no wrenches, and `stops` says how far within the cart's limits
    that stops the cart, if it does. `switched` are the arms that hold elsewhere than at the last plan, told where
    switching has a cost. `tell` makes `figures`, `prove` makes `proof`, and `wheel_forces` what the wheels take, when
    asked; and `found_why` the plan that says why a wrench can't be given, where `plan_or_hold` leaves that open. `arms`
    have the limits that held.
    """

    status: str
    wrenches: Mapping[str, Array] = field(default_factory=dict)
    contacts: Mapping[str, Array] = field(default_factory=dict)
    yaws: Mapping[str, float] = field(default_factory=dict)
    certificate: Certificate | None = field(default_factory=lambda: None)  # these two may be left open
    solve_time: float = 0.0
    solver: str = ""
    message: str = field(default_factory=str)
    held: ContactWrenches | None = None
    stops: str = ""
    switched: tuple[str, ...] = ()
    tell: Callable[[], Figures] = field(default=Figures, repr=False)
    prove: Callable[[], tuple[QuadraticProgram, QPSolution]] | None = field(default=None, repr=False)
    found_why: Callable[[], Plan] | None = field(default=None, repr=False)
    wheel_forces: Callable[[Array], WheelForces] | None = field(default=None, repr=False)
    arms: tuple[Arm, ...] = field(default=(), repr=False)
    beside: Array | None = field(default=None, repr=False)

    def __repr__(self) -> str:
        if not self.is_usable:
            return brief("Plan", self.status, self.message)
        arms = (
            f"{name}: {digits(wrench.tolist())} at {digits(self.contacts[name].tolist())}"
            for name, wrench in self.wrenches.items()
        )
        effort = "" if self.effort is None else f"effort {digits(self.effort)}"
        cart = "" if self.cart_wrench is None else f"on the cart {digits(self.cart_wrench.tolist())}"
        return "\n".join([brief("Plan", self.status, effort, cart), *(f"  {arm}" for arm in arms)])

    @classmethod
    def of(cls, fields: dict[str, Any]) -> Self:
        """Builds a plan as the constructor does, in a third of the time. `fields` must hold every field without a
        default, except those that may be left open."""
        plan = object.__new__(cls)
        object.__setattr__(plan, "__dict__", fields)
        return plan

    def __getattr__(self, name: str) -> Any:
        """What is left open: found when it is asked for, once."""
        if name not in ("certificate", "message") or "status" not in self.__dict__:
            raise AttributeError(f"a plan has no attribute {name!r}")
        why = self.explain()
        self.__dict__["certificate"] = None if why is self else why.certificate
        self.__dict__.setdefault("message", "" if why is self else why.message)
        return self.__dict__[name]

    def explain(self) -> Plan:
        """The plan with its certificate, the nearest wrench and remedies; itself where these are told, or where there
        is nothing to explain. What `plan_or_hold` leaves open takes milliseconds, once."""
        return self if self.found_why is None else self.found_why()

    @cached_property
    def proof(self) -> tuple[QuadraticProgram, QPSolution] | None:
        """The program with its solution, of which the proof consists; without wrenches None."""
        return None if self.prove is None else self.prove()

    @cached_property
    def figures(self) -> Figures:
        return self.tell()

    @property
    def effort(self) -> float | None:
        return self.figures.effort

    @property
    def active(self) -> tuple[str, ...]:
        return self.figures.active

    @property
    def residuals(self) -> Residuals | None:
        return self.figures.residuals

    @property
    def choice(self) -> ChoiceProof | None:
        return self.figures.choice

    @property
    def is_usable(self) -> bool:
        """Whether it has wrenches: it is optimal, or relaxed as the caller allows."""
        return self.status in USABLE

    @property
    def contact_wrenches(self) -> ContactWrenches:
        """What the arms should do: the plan, or what is held instead of one."""
        if self.is_usable:
            return ContactWrenches(self.wrenches, self.contacts, self.yaws)
        if self.held is None:
            raise UsageError(f"this plan is {self.status}: {self.message or 'it has no wrenches'}; use plan_or_hold")
        return self.held

    @cached_property
    def cart_wrench(self) -> Array | None:
        """What the arms, or what is held, and what is given besides, give the cart: (fx, fy, tau) (3,) in {b}. Its
        effective rows are those asked for; a side force that fixed wheels take is whatever costs the arms least. None
        where there are no wrenches."""
        if not (self.is_usable or self.held):
            return None
        given = self.contact_wrenches.wrench_b
        return given if self.beside is None else given + self.beside[[*PLANAR]]

    @cached_property
    def _wheels(self) -> WheelForces | None:
        if self.wheel_forces is None or self.cart_wrench is None:
            return None
        given = self.contact_wrenches.spatial_wrench_b
        return self.wheel_forces(given if self.beside is None else given + self.beside)

    @property
    def wheel_side_force(self) -> float | None:
        """N that the floor gives the fixed wheels, to their left, under `cart_wrench`, at the motion of the estimate
        given last or at rest: m (u r + dx r' - dy r²) - fy for an axle through {b}'s origin. None without wrenches."""
        return None if self._wheels is None else self._wheels.side

    @property
    def wheel_loads(self) -> Array | None:
        """N on each wheel of the cart's file, in its order, as `TipOver` and `Skid` count them, at the same motion.
        None without wrenches, and where the cart tells no wheels or no `com_height`."""
        return None if self._wheels is None else self._wheels.loads

    @property
    def nearest(self) -> Nearest | None:
        return None if self.certificate is None else self.certificate.nearest

    @property
    def missing(self) -> Mapping[str, float]:
        """What a relaxed plan leaves out of the wrench asked for, N or N·m by effective row (`fx`, `tau`, …)."""
        return self.nearest.missing if self.status == RELAXED and self.nearest else {}

    @cached_property
    def margins(self) -> Mapping[str, float]:
        """How far the wrenches are from each limit, by its name, in its unit; empty without wrenches."""
        if not self.is_usable or self.proof is None:
            return {}
        program, solution = self.proof
        return program.margins(solution.x)

    @cached_property
    def polytopes(self) -> Mapping[str, WrenchPolytope]:
        """All that each arm could give, in {a}, by its name."""
        from .polytopes.wrench_polytope import WrenchPolytope  # with HiGHS, which a tick does without

        return {arm.name: WrenchPolytope.of(arm) for arm in self.arms}

    @property
    def limiting_joints(self) -> tuple[str, ...]:
        """The joint limits among the `active` ones, such as `left: joint A6 torque upper`."""
        if not any(arm.joints for arm in self.arms):
            return ()
        return tuple(name for name in self.active if "torque" in name.rpartition(":")[2].split())

    def as_dict(self) -> dict[str, Any]:
        """The JSON of `cartgrasp plan`; `margins` only with wrenches, `wheel_loads` only of a cart that tells its
        wheels and `com_height`, `nearest` only with a certificate, `missing` only when relaxed, `switched` only where
        arms have, `message` only where neither wrenches nor a certificate say it all."""
        document: dict[str, Any] = {
            "status": self.status,
            "effort": self.effort,
            "arms": arms_as_dict(self.contacts, self.wrenches),
            "active": list(self.active),
            "residuals": None if self.residuals is None else self.residuals.as_dict(),
            "choice": None if self.choice is None else self.choice.as_dict(),
            "certificate": None if self.certificate is None else self.certificate.as_dict(),
            "solve_time_s": self.solve_time,
        }
        if self.is_usable:
            document["margins"] = dict(self.margins)
            document["cart_wrench"] = None if self.cart_wrench is None else self.cart_wrench.tolist()
            document["wheel_side_force"] = self.wheel_side_force
            if self.wheel_loads is not None:
                document["wheel_loads"] = self.wheel_loads.tolist()
        if self.certificate is not None:
            document["nearest"] = None if self.nearest is None else self.nearest.as_dict()
        elif self.status != OPTIMAL:
            document["message"] = self.message
        if self.status == RELAXED:
            document["missing"] = dict(self.missing)
        if self.switched:
            document["switched"] = list(self.switched)
        return document


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
