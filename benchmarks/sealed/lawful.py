"""Scenes with a force that has no name, and what it follows."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from . import foreign
from .effects import sign, with_effect
from .scenes import Scene, Truth
from .world import GRAVITY

Draw = np.random.Generator


@dataclass(frozen=True)
class Foreign:
    """`size` is per kg of the cart; `numbers` draws the two others for a scene; `period` says that the first is one."""

    kind: float
    size: tuple[float, float]
    numbers: Callable[[Scene, Draw], tuple[float, float]]
    form: str
    period: bool = False
    both_signs: bool = False

    def put_into(self, name: str, scene: Scene, random: Draw) -> Scene:
        size = scene.world.mass * random.uniform(*self.size) * (sign(random) if self.both_signs else 1.0)
        a, b = self.numbers(scene, random)
        values = {"size": size} | ({"period": a} if self.period else {})
        truth = Truth(name, values, form=self.form, outside=True)
        return with_effect(scene, truth, law=self.kind, law_size=float(size), law_a=float(a), law_b=float(b))


def _between(low: float, high: float, other: tuple[float, float] = (0.0, 1.0)):
    return lambda scene, random: (random.uniform(low, high), random.uniform(*other))


def _place(scene: Scene, random: Draw) -> tuple[float, float]:
    """Somewhere in the middle of where the cart goes."""
    x, y = _path(scene)
    return random.uniform(*np.quantile(x, [0.25, 0.75])), random.uniform(*np.quantile(y, [0.25, 0.75]))


def _side(scene: Scene, random: Draw) -> tuple[float, float]:
    x, _ = _path(scene)
    return random.uniform(*np.quantile(x, [0.35, 0.65])), 0.2 * float(np.ptp(x))


def _duration(scene: Scene, random: Draw) -> tuple[float, float]:
    return float(scene.drive.time[-1]), 0.0


def _path(scene: Scene) -> np.ndarray:
    return scene.run()[0][:, :2].T


FOREIGN = {
    "pulses": Foreign(foreign.PULSES, (0.6, 1.4), _between(0.7, 2.5), "a push once a period", period=True),
    "hum": Foreign(foreign.HUM, (0.15, 0.4), _between(0.4, 2.0), "two harmonics in time", period=True),
    "bent_wheel": Foreign(
        foreign.BENT_WHEEL, (0.06, 0.15), _between(0.3, 0.7), "a moment by the left wheel", period=True
    ),
    "tether": Foreign(foreign.TETHER, (0.08, 0.25), _place, "a spring to a place"),
    "warming": Foreign(foreign.WARMING, (0.3, 0.8), _between(10.0, 25.0), "viscous drag that fades"),
    "grain": Foreign(foreign.GRAIN, (0.1, 0.3), _between(-1.5, 1.5), "dry drag, twice round"),
    "cubic_drag": Foreign(foreign.CUBIC_DRAG, (0.5, 1.2), _between(0.0, 1.0), "by the cube of the speed"),
    "scrub": Foreign(foreign.SCRUB, (0.4, 1.0), _between(0.0, 1.0), "dry drag that grows with the yaw rate"),
    "ridges": Foreign(foreign.RIDGES, (0.15, 0.4), _between(0.4, 1.2), "a force along x by x", period=True),
    "axle_drag": Foreign(foreign.AXLE_DRAG, (0.1, 0.3), _between(0.0, 1.0), "dry drag at the axle alone"),
    "drift": Foreign(foreign.DRIFT, (0.2, 0.5), _duration, "grows with time", both_signs=True),
    "rough_side": Foreign(foreign.ROUGH_SIDE, (0.15, 0.4), _side, "dry drag on one side of the floor"),
}
FOLLOWS = {
    "flat_spot": ("travelled_distance", "m"),
    "wind": ("time", "s"),
    "oscillating_floor": ("time", "s"),
    "pulses": ("time", "s"),
    "hum": ("time", "s"),
    "bent_wheel": ("travelled_distance", "m"),
    "tether": ("place", "m"),
    "warming": ("time", "s"),
    "grain": ("heading", "rad"),
    "cubic_drag": ("speed", "m/s"),
    "scrub": ("yaw_rate", "rad/s"),
    "ridges": ("place", "m"),
    "axle_drag": ("speed", "m/s"),
    "drift": ("time", "s"),
    "rough_side": ("place", "m"),
}
"""Of what each is a function, and the unit of a period."""
AS_WELL = {
    "cubic_drag": {"quadratic_drag"},
    "axle_drag": {"rolling_resistance", "stribeck_friction", "wheel_drag_imbalance"},
    "drift": {"force_bias"},
}
"""Names that say as much of them as a law does."""


def with_law(true: Mapping[str, Any], law: Mapping[str, Any], mass: float) -> Mapping[str, Any]:
    """A true effect with a law that its name says as much of, where no law is told: rolling resistance takes dry drag
    at an axle, for every wheel is behind it."""
    if (law["name"], true["name"]) != ("axle_drag", "rolling_resistance"):
        return true
    more = law["parameters"]["size"] / (mass * GRAVITY)
    return {**true, "parameters": {"coefficient": true["parameters"]["coefficient"] + more}}
