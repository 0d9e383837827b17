"""The keys of `PROBLEM.yaml`, with their types."""

from __future__ import annotations

from dataclasses import is_dataclass
from typing import TYPE_CHECKING, Annotated, Any, TypeAlias

from pydantic import Field

from cartgrasp.yaml_file import StrictModel

from .. import limits, objectives
from ..limits import CartLimit, Limit
from ..objectives.objective import Addition
from ..planner import MAX_PERIOD
from .class_entries import classes_in, entry_of
from .values import (
    Angle,
    LimitTriple,
    LimitValue,
    NotNegative,
    Positive,
    RateTriple,
    SwitchingCostValue,
    Triple,
    WeightValue,
    WrenchValue,
)

DEFAULT_WEIGHTS = (1.0, 1.0, 1.0, 10.0, 10.0, 10.0)
ARM_LIMITS = {key: kind for key, kind in classes_in(limits, Limit).items() if is_dataclass(kind)}  # type: ignore[type-abstract]
"""Limits of an arm with numbers of their own; others are about the arm's."""
CART_LIMITS = classes_in(limits, CartLimit)  # type: ignore[type-abstract]
ADDITIONS = classes_in(objectives, Addition)  # type: ignore[type-abstract]


class BoxEntry(StrictModel):
    force: LimitTriple | None = None
    moment: LimitTriple | None = None


if TYPE_CHECKING:
    LimitsEntry: TypeAlias = BoxEntry
else:
    LimitsEntry = entry_of("LimitsEntry", ARM_LIMITS, BoxEntry)


class RateEntry(StrictModel):
    """Per second; `last` is the wrench that it counts from."""

    force: RateTriple | None = None
    moment: RateTriple | None = None
    last: list[WrenchValue] = Field(default_factory=lambda: [0.0] * 6, min_length=6, max_length=6)


class JointsEntry(StrictModel):
    """Six rows of the Jacobian, as many columns as joints."""

    jacobian: Annotated[list[list[float]], Field(min_length=6, max_length=6)]
    gravity_torque: list[float]
    torque_limit: list[NotNegative]


class LinkMassEntry(StrictModel):
    link: str
    mass: NotNegative
    centre: Triple


class UrdfEntry(StrictModel):
    """`base` is where the root stands in {b}; roll, pitch and yaw turn it there, and the tool."""

    file: str
    tool: str
    base: Triple
    base_turned: Triple = Field(default_factory=lambda: [0.0, 0.0, 0.0])
    hand_turned: Triple = Field(default_factory=lambda: [0.0, 0.0, 0.0])
    start: list[float] | None = None
    torque_limit: list[Positive] | None = None
    added_masses: list[LinkMassEntry] = Field(default_factory=list)
    feels_gravity: bool = True


class ReachEntry(StrictModel):
    low: Triple
    high: Triple


class FrictionEntry(StrictModel):
    mu: NotNegative
    sides: Any = 4


class SoftFingerEntry(StrictModel):
    mu: NotNegative
    twist_radius: Positive
    grip: NotNegative = 0.0
    normal: str = "x"
    sides: Any = 8


class ArmEntry(StrictModel):
    name: str
    contacts: list[Triple] = Field(default_factory=list)
    segment: Annotated[list[Triple], Field(min_length=2, max_length=2)] | None = None
    yaw: Angle = 0.0
    limits: LimitsEntry = LimitsEntry()
    friction: FrictionEntry | None = None
    soft_finger: SoftFingerEntry | None = None
    weights: list[WeightValue] = Field(default_factory=lambda: [*DEFAULT_WEIGHTS], min_length=6, max_length=6)
    push_only: bool = False
    payload: LimitValue | None = None
    rate: RateEntry | None = None
    joints: JointsEntry | None = None
    urdf: UrdfEntry | None = None
    reach: ReachEntry | None = None
    held: Triple | None = None


class EffortEntry(StrictModel):
    """What adds to the effort, or without `effort` stands alone."""

    effort: bool = True


if TYPE_CHECKING:
    CartLimitsEntry: TypeAlias = StrictModel
    ObjectiveEntry: TypeAlias = EffortEntry
else:
    CartLimitsEntry = entry_of("CartLimitsEntry", CART_LIMITS)
    ObjectiveEntry = entry_of("ObjectiveEntry", ADDITIONS, EffortEntry)


class MotionEntry(StrictModel):
    """Pose of {b} in the world, and the free velocities."""

    pose: Triple = Field(default_factory=lambda: [0.0, 0.0, 0.0])
    velocity: list[float]


class ConfidenceEntry(StrictModel):
    """With what `probability` limits of the cart hold, where the cart's numbers have these standard deviations."""

    probability: Annotated[float, Field(ge=0.5, lt=1.0)]
    std: dict[str, NotNegative]


class ProblemEntry(StrictModel):
    cart: Any
    wrench: Triple
    arms: list[ArmEntry] = Field(min_length=1)
    min_hand_distance: NotNegative = 0.0
    cart_limits: CartLimitsEntry = CartLimitsEntry()
    relax: NotNegative = 0.0
    switching_cost: SwitchingCostValue = 0.0
    period: Annotated[Positive, Field(le=MAX_PERIOD)] = 1e-3
    solver: str | None = None
    objective: ObjectiveEntry = ObjectiveEntry()
    motion: MotionEntry | None = None
    confidence: ConfidenceEntry | None = None
