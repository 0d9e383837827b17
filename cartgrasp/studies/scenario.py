"""A closed-loop run described by values: what is pushed, believed, followed, sensed; `build` puts it together."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from estimation import CartFilter, DisturbedFilter, FilterNoise, PaperFilter, Prior
from planning import CartLimit, Caution, Choosing, Controller, RegraspTimes
from planning.contact_sources.strategies import FIXED
from planning.references import PathReference, Stretch
from planning.tracking import Gains

from ..arms import Arm
from ..effects import InertiaEffect
from ..errors import UsageError
from ..first_guess import PHYSICAL_NAMES
from ..inertia import physical_from_phi
from ..model import CartModel
from ..roles import Estimator, Plant
from ..simulation.closed_loop import Loop, run
from ..simulation.plant import ModelPlant
from ..simulation.record import RunRecord
from ..simulation.sensors import SensorNoise, Sensors

LEARNING, FIRST_GUESS, PAPER = "learning", "first guess kept", "paper's literal filter"
DEFAULT_CHOOSING = Choosing()
MODEL_PLANT, MUJOCO_PLANT = "model", "mujoco"
CONTROLLER_SETTINGS = "contacts", "choosing", "regrasp", "cart_limits", "confidence", "caution", "gains", "period"
"""What a controller calls as a scenario does."""
SHARED_NOISE_KEYS = ("position", "heading", "linear_velocity", "yaw_rate", "force", "moment")
"""What filter and sensors both have."""


@dataclass(frozen=True)
class Scenario:
    """`truth` is what is pushed, `guess` what is believed at first. `estimation` is LEARNING, FIRST_GUESS (the
    parameters stay as guessed, only the motion is filtered) or PAPER. `contacts` is the way in which the arms choose
    where to hold, by its name, `choosing` what it may ask and spend; without `regrasp` hands are there at once, as in
    the paper. `cart_limits`, `confidence` and `caution` are the controller's; with `disturbances` the filter tells what
    pushes beside all that is known, and the arms answer it."""

    truth: CartModel
    guess: CartModel
    arms: tuple[Arm, ...]
    stretches: tuple[Stretch, ...]
    sensors: SensorNoise
    noise: FilterNoise
    known: frozenset[str] = frozenset()
    estimation: str = LEARNING
    plant: str = MODEL_PLANT
    contacts: str = FIXED
    choosing: Choosing = DEFAULT_CHOOSING
    regrasp: RegraspTimes | None = None
    cart_limits: tuple[CartLimit, ...] = ()
    confidence: float | None = None
    caution: Caution | None = None
    disturbances: bool = False
    gains: Gains = Gains()
    period: float = 0.01
    plant_timestep: float | None = None
    seed: int = 0
    duration: float | None = None
    start_pose: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        if self.disturbances and self.estimation == PAPER:
            raise UsageError("disturbances: the paper's filter tells none; write `estimation: learning`")

    def run(self, progress: Callable[[float], None] | None = None) -> RunRecord:
        """The whole run, with the truth beside each estimate."""
        return with_truth(run(self.build(), self.duration, progress), self.truth)

    def build(self, **parts: Any) -> Loop:
        """The loop, warmed up and ready to run; `parts` of the controller in place of the usual ones."""
        controller = self.controller(**parts)
        controller.warm_up()
        return Loop(controller, self._plant(), Sensors(self.truth, self.sensors, self.seed))

    def controller(self, **parts: Any) -> Controller:
        """What follows the path, with the estimator and the way to hold that are described."""
        usual = {name: getattr(self, name) for name in CONTROLLER_SETTINGS} | {
            "reference": PathReference(self.stretches, self.guess.rolling, self.start_pose),
            "estimator": self._estimator(),
            "learn": self.estimation != FIRST_GUESS,
        }
        return Controller(self.guess, list(self.arms), **(usual | parts))

    def _plant(self) -> Plant:
        step = {"timestep": self.plant_timestep} if self.plant_timestep else {}
        if self.plant == MODEL_PLANT:
            return ModelPlant(self.truth, self.start_pose, **step)
        if self.plant == MUJOCO_PLANT:
            from ..simulation.mujoco_plant import MujocoPlant

            return MujocoPlant(self.truth, self.start_pose, **step)
        raise UsageError(f"plant: {self.plant!r} is neither {MODEL_PLANT!r} nor {MUJOCO_PLANT!r}")

    @property
    def prior(self) -> Prior:
        """What the filter is told."""
        known = frozenset() if self.estimation == PAPER else self.known
        if self.estimation == FIRST_GUESS:
            known = known | set(PHYSICAL_NAMES) | {e.key for e in self.guess.effects}
            return Prior(slope=0.0, known=known)
        return Prior(known=known)

    def _estimator(self) -> Estimator:
        names = [arm.name for arm in self.arms]
        yaws = {arm.name: arm.yaw for arm in self.arms}
        kind = PaperFilter if self.estimation == PAPER else DisturbedFilter if self.disturbances else CartFilter
        return kind(self.guess, names, noise=self.noise, prior=self.prior, yaws=yaws)


def with_truth(record: RunRecord, truth: CartModel) -> RunRecord:
    """The record with the true value beside each parameter that the truth has."""
    changes, n = any(isinstance(effect, InertiaEffect) for effect in truth.effects), len(record.time)
    physical = physical_from_phi(truth.phi_at(record.time if changes else record.time[:1]))
    values = dict(zip(PHYSICAL_NAMES, np.broadcast_to(physical, (n, 4)).T, strict=True))
    for effect in truth.effects:
        if not isinstance(effect, InertiaEffect):
            for key, value in zip(effect.keys, effect.values, strict=True):
                values[key] = np.full(n, value)
    parameters = {name: replace(series, truth=values.get(name)) for name, series in record.parameters.items()}
    return replace(record, parameters=parameters)


def filter_noise(sensors: SensorNoise, **own: float) -> FilterNoise:
    """What an estimator is told of sensors, and what is its `own`: unless that is given, its model lacks little."""
    shared = {name: getattr(sensors, name) for name in SHARED_NOISE_KEYS}
    return FilterNoise(**{"disturbance": 0.02, "slip": 0.0001} | shared | own)


def total_duration(stretches: Sequence[Stretch]) -> float:
    return sum(stretch.duration for stretch in stretches)


def scaled(gains: Gains, by: float) -> Gains:
    """All errors decay `by` times as fast."""
    quicker = {name: by * getattr(gains, name) for name in ("along", "heading", "velocity")}
    return replace(gains, across=by**2 * gains.across, **quicker)
