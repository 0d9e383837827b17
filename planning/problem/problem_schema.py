"""The keys of `PROBLEM.yaml`, with their types and what a single value may be."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import AfterValidator, Field

from cartgrasp.checks import MAX_NUMBER
from cartgrasp.yaml_file import StrictModel

from ..contacts.switching_cost import MAX_SWITCHING_COST

DEFAULT_WEIGHTS = (1.0, 1.0, 1.0, 10.0, 10.0, 10.0)


def _limit(value: float) -> float:
    if not abs(value) < float("inf"):
        raise ValueError(f"{value} is not a finite number; leave the key out for no limit")
    return _not_negative(value) if value <= MAX_NUMBER else float("inf")  # beyond it limits nothing


def _not_negative(value: float) -> float:
    if value < 0:
        raise ValueError(f"{value:g} is negative; a number >= 0 is needed")
    return value


def _positive(value: float) -> float:
    if not value > 0:
        raise ValueError(f"{value:g} is not > 0")
    return value


def _switching_cost(value: float) -> float:
    if value > MAX_SWITCHING_COST:
        raise ValueError(f"{value:g} is beyond {MAX_SWITCHING_COST:g}")
    return _not_negative(value)


NotNegative = Annotated[float, AfterValidator(_not_negative)]
Positive = Annotated[float, AfterValidator(_positive)]
LimitValue = Annotated[float, Field(allow_inf_nan=True), AfterValidator(_limit)]
Triple = Annotated[list[float], Field(min_length=3, max_length=3)]
LimitTriple = Annotated[list[LimitValue], Field(min_length=3, max_length=3)]
SwitchingCostValue = Annotated[float, AfterValidator(_switching_cost)]
RateTriple = Annotated[list[Positive], Field(min_length=3, max_length=3)]


class LimitsEntry(StrictModel):
    force: LimitTriple | None = None
    moment: LimitTriple | None = None


class RateEntry(StrictModel):
    """Per second; `last` is the wrench that it counts from."""

    force: RateTriple | None = None
    moment: RateTriple | None = None
    last: list[float] = Field(default_factory=lambda: [0.0] * 6, min_length=6, max_length=6)


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
    yaw: float = 0.0
    limits: LimitsEntry = LimitsEntry()
    friction: FrictionEntry | None = None
    soft_finger: SoftFingerEntry | None = None
    weights: list[NotNegative] = Field(default_factory=lambda: [*DEFAULT_WEIGHTS], min_length=6, max_length=6)
    push_only: bool = False
    payload: LimitValue | None = None
    rate: RateEntry | None = None
    joints: JointsEntry | None = None
    urdf: UrdfEntry | None = None
    reach: ReachEntry | None = None
    held: Triple | None = None


class SkidEntry(StrictModel):
    friction: NotNegative


class TipOverEntry(StrictModel):
    least_load: NotNegative = 0.0


class SideForceEntry(StrictModel):
    bound: NotNegative


class InternalForceEntry(StrictModel):
    bound: NotNegative
    axis: Triple = Field(default_factory=lambda: [0.0, 1.0, 0.0])


class CartLimitsEntry(StrictModel):
    """Limits of the hands together."""

    skid: SkidEntry | None = None
    tip_over: TipOverEntry | None = None
    side_force: SideForceEntry | None = None
    internal_force: InternalForceEntry | None = None


class SmoothnessEntry(StrictModel):
    rate: NotNegative = 1.0


class LoadShareEntry(StrictModel):
    shares: dict[str, float]
    weight: NotNegative = 1.0


class WeightEntry(StrictModel):
    weight: NotNegative = 1.0


class InternalWeightEntry(StrictModel):
    weight: NotNegative = 1.0
    axis: Triple = Field(default_factory=lambda: [0.0, 1.0, 0.0])


class WorstArmEntry(StrictModel):
    weight: Positive


class ObjectiveEntry(StrictModel):
    """What adds to the effort, or without `effort` stands alone."""

    effort: bool = True
    smoothness: SmoothnessEntry | None = None
    load_share: LoadShareEntry | None = None
    least_joint_torque: WeightEntry | None = None
    least_side_force: WeightEntry | None = None
    least_internal_force: InternalWeightEntry | None = None
    worst_arm: WorstArmEntry | None = None


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
    period: Positive = 1e-3
    solver: str | None = None
    objective: ObjectiveEntry = ObjectiveEntry()
    motion: MotionEntry | None = None
    confidence: ConfidenceEntry | None = None
