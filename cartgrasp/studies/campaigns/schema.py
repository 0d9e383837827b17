"""The keys of `study.yaml`, with their types and what a single value may be."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Field, PositiveFloat

from planning.contact_sources.choosing import Choosing
from planning.contact_sources.strategies import Strategy
from planning.control.caution import Caution
from planning.control.hand import RegraspTimes
from planning.problem.problem_schema import ArmEntry, CartLimitsEntry
from planning.problem.values import NotNegative, Positive

from ...yaml_file import StrictModel
from ..scenario import FIRST_GUESS, LEARNING, PAPER

ESTIMATIONS = {"learning": LEARNING, "first_guess": FIRST_GUESS, "paper": PAPER}
DEFAULT_CHOOSING, DEFAULT_REGRASP, DEFAULT_CAUTION = Choosing(), RegraspTimes(), Caution()
Pair = Annotated[list[float], Field(min_length=2, max_length=2)]


class StretchEntry(StrictModel):
    duration: PositiveFloat
    acceleration: float = 0.0
    yaw_acceleration: float = 0.0


class SwitchingEntry(StrictModel):
    every: Positive
    least_effort: bool = False


class ChoosingEntry(StrictModel):
    """The settings of `Choosing`, whose noise is the filter's."""

    every: Positive = DEFAULT_CHOOSING.every
    ahead: Positive = DEFAULT_CHOOSING.ahead
    asked: dict[str, Positive] = Field(default_factory=lambda: dict(DEFAULT_CHOOSING.asked))
    extra_effort: NotNegative = DEFAULT_CHOOSING.extra_effort
    regrasp_effort: NotNegative = DEFAULT_CHOOSING.regrasp_effort
    min_hand_distance: NotNegative = DEFAULT_CHOOSING.min_hand_distance


class RegraspEntry(StrictModel):
    """The settings of `RegraspTimes`."""

    speed: Positive = DEFAULT_REGRASP.speed
    unload: NotNegative = DEFAULT_REGRASP.unload
    take_hold: NotNegative = DEFAULT_REGRASP.take_hold
    load: NotNegative = DEFAULT_REGRASP.load


class CautionEntry(StrictModel):
    """The settings of `Caution`."""

    pace: dict[str, float] = Field(default_factory=lambda: dict(DEFAULT_CAUTION.pace))
    widen: dict[str, float] = Field(default_factory=lambda: dict(DEFAULT_CAUTION.widen))
    change: Positive = DEFAULT_CAUTION.change
    short: NotNegative = DEFAULT_CAUTION.short
    astray: Positive = DEFAULT_CAUTION.astray
    behind: Positive = DEFAULT_CAUTION.behind


class GainsEntry(StrictModel):
    along: Positive | None = None
    across: Positive | None = None
    heading: Positive | None = None
    velocity: Positive | None = None
    reach: Positive | None = None


class SensorsEntry(StrictModel):
    """The settings of `SensorNoise`; a period of null is never."""

    position: NotNegative = 0.0004
    heading: NotNegative = 0.0004
    linear_velocity: NotNegative = 0.005
    yaw_rate: NotNegative = 0.005
    force: NotNegative = 3.0
    moment: NotNegative = 0.1
    pose_period: NotNegative = 0.0
    velocity_period: NotNegative | None = 0.0
    wrench_period: NotNegative = 0.0


class FilterEntry(StrictModel):
    """The settings of `FilterNoise`; what is left out is what the sensors have, or usual."""

    position: NotNegative | None = None
    heading: NotNegative | None = None
    linear_velocity: NotNegative | None = None
    yaw_rate: NotNegative | None = None
    force: NotNegative | None = None
    moment: NotNegative | None = None
    disturbance: NotNegative = 0.1
    lever: NotNegative = 0.3
    slip: NotNegative = 0.0002
    swivel: NotNegative = 0.2
    parameter_drift: NotNegative = 0.002


class ClosedLoopEntry(StrictModel):
    cart: Any
    guess: Any = None
    path: str | list[StretchEntry] = "curves"
    speed: float = 0.6
    duration: Positive | None = None
    period: Positive = 0.01
    plant: Literal["model", "mujoco"] = "model"
    plant_timestep: Positive | None = None
    arms: list[ArmEntry] = Field(min_length=1)
    switching: SwitchingEntry | None = None
    contacts: Strategy | None = None
    choosing: ChoosingEntry | None = None
    regrasp: RegraspEntry | None = None
    cart_limits: CartLimitsEntry | None = None
    confidence: Annotated[float, Field(ge=0.5, lt=1.0)] | None = None
    caution: CautionEntry | None = None
    disturbances: bool = False
    estimation: Literal["learning", "first_guess", "paper"] = "learning"
    known: list[str] = Field(default_factory=list)
    gains: GainsEntry = GainsEntry()
    sensors: SensorsEntry = SensorsEntry()
    filter: FilterEntry = FilterEntry()


class DrawnEntry(StrictModel):
    """The distribution of a parameter of the true cart: low and high, or mean and standard deviation."""

    uniform: Pair | None = None
    normal: Pair | None = None


class LogsEntry(StrictModel):
    """`files` may hold `*`."""

    files: list[str] = Field(min_length=1)
    cart: Any
    do: Literal["estimate", "identify", "discrepancy"] = "estimate"
    method: Literal["filter", "regressor", "paper"] = "filter"
    topics: str | None = None


class StudyEntry(StrictModel):
    name: str = "campaign"
    seed: Annotated[int, Field(ge=0)] = 0
    runs: Annotated[int, Field(ge=1, le=1_000_000)] = 100
    closed_loop: ClosedLoopEntry | None = None
    drawn: dict[str, DrawnEntry] = Field(default_factory=dict)
    logs: LogsEntry | None = None
