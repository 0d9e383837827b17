"""Effects and situations as hypothesis draws them, from what each effect says of its own parameters."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from hypothesis import assume
from hypothesis import strategies as st

from cartgrasp.effects import (
    KNOWN_EFFECTS,
    ConstraintEffect,
    Effect,
    ForceEffect,
    InertiaEffect,
    LearnedForce,
    SensorEffect,
)
from cartgrasp.effects.effect import Situation
from cartgrasp.frames import rotation_planar
from cartgrasp.wheels import WheelSet
from tests.core.drawn import WHEELS, no_wheel_just_lifts, numbers, phis, poses, vectors, velocities

LAWS = (
    LearnedForce("forward_force", "travelled_distance", lever=0.27, period=0.525, harmonics=(1, 3)),
    LearnedForce("forward_force", "time", knots=(0.0, 2.0, 11.0, 12.5)),
    LearnedForce("forward_force", "speed", lever=-0.3, knots=(-0.7, 0.0, 0.6)),
    LearnedForce("lateral_force", "yaw_rate", knots=(-1.0, 0.1)),
    LearnedForce("yaw_moment", "heading", harmonics=(1, 2)),
    LearnedForce("yaw_moment", "since_reversal", knots=(0.05, 0.3, 1.0)),
    LearnedForce("drag", "place", knots=(-1.0, 0.5, 2.0), knots_y=(-0.5, 1.0)),
    LearnedForce("drag", "speed", lever=0.27, knots=(0.1, 0.5, 1.5)),
    LearnedForce("drag", "travelled_distance", lever=-0.2, knots=(0.1, 0.4)),
    LearnedForce("drag", "heading"),
    LearnedForce("world_force", "place", direction=0.7, period=0.8),
    LearnedForce("world_force", "place", direction=-2.0, knots=(-1.0, 0.3)),
    LearnedForce("world_force", "time", direction=2.5),
)
"""Forms of `learned_force`, absent."""
FIXED = [kind() for kind in KNOWN_EFFECTS.values() if kind is not LearnedForce]
"""One, absent, of each effect whose parameters are the same for all of its class."""
EFFECTS: list[Effect] = [*FIXED, *LAWS]
FORCE_EFFECTS = [e for e in EFFECTS if isinstance(e, ForceEffect)]
INERTIA_EFFECTS = [e for e in EFFECTS if isinstance(e, InertiaEffect)]
CONSTRAINT_EFFECTS = [e for e in EFFECTS if isinstance(e, ConstraintEffect)]
SENSOR_EFFECTS = [e for e in EFFECTS if isinstance(e, SensorEffect)]


@dataclass(frozen=True)
class Trial:
    """An effect in a situation, with some memory."""

    effect: ForceEffect
    situation: Situation
    memory: np.ndarray

    @property
    def values(self) -> np.ndarray:
        return self.effect.values

    def wrench(self, **changed: np.ndarray) -> np.ndarray:
        """The wrench with pose, velocity, phi, memory or parameters changed, (..., 3)."""
        return self.contribution("wrench_b", **changed).value

    def contribution(self, method="wrench_b", memory=None, parameters=None, **changed):
        situation = replace(self.situation, **changed)
        memory = self.memory if memory is None else memory
        return getattr(self.effect, method)(situation, memory, self.values if parameters is None else parameters)


def title(effect: Effect) -> str:
    """Its name, and of which form it is."""
    return " ".join(
        [effect.name, *(str(getattr(effect, setting.name)) for setting in effect.settings if setting.words)]
    )


def without(effect: Effect) -> Effect:
    """The same effect at the values at which it is absent."""
    return effect.with_values([p.absent for p in effect.parameters])


@st.composite
def effects(draw: st.DrawFn, kind: Effect, at_least: float = -np.inf) -> Effect:
    """Values within three times the usual distance from absence, inside the bounds."""
    values = {}
    for p in kind.parameters:
        low = max(p.lower, p.absent - 3 * p.typical, at_least)
        values[p.name] = draw(numbers(low, min(p.upper, p.absent + 3 * p.typical)))
    for low, high in kind.ordered:
        values[low], values[high] = sorted((values[low], values[high]))
    if kind.name == "caster_realignment":  # 0 stands for the listed trail; one of a millimetre does not exist
        values["trail"] = draw(st.one_of(st.just(0.0), numbers(0.02, 0.2)))
    if kind.name == "lateral_slip":  # none is a billion N/rad
        values["cornering_stiffness"] = draw(numbers(100.0, 20000.0))
    if kind.name == "end_stop":  # no bumper has a softer spring; one of 0 would have a corner there
        values["stiffness"] = draw(numbers(1000.0, 50_000.0))
    label = draw(st.sampled_from(["", "left"]))
    return replace(kind, label=label).with_values([values[p.name] for p in kind.parameters])


@st.composite
def trials(draw: st.DrawFn, kind: ForceEffect, at_least: float = -np.inf) -> Trial:
    effect = draw(effects(kind, at_least))
    wheels = WheelSet.of(draw(st.sampled_from(WHEELS)), rolls_along_x=draw(st.booleans()))
    pose, phi = draw(poses()), draw(phis())
    assume(no_wheel_just_lifts(phi, wheels))
    if kind.name == "floor_patch" and draw(st.booleans()):
        pose = _at_an_edge(draw, effect, pose, wheels)
    if kind.name == "end_stop" and draw(st.booleans()):
        pose = np.array([effect.position + draw(numbers(-0.01, 0.01)), *pose[1:]])
    time = draw(_times(effect))
    n = len(effect.memory_names(wheels))
    memory = draw(vectors(n, -4.0, 4.0)) if n else np.zeros(0)
    return Trial(effect, Situation(time, pose, draw(velocities()), phi, wheels), memory)


def _at_an_edge(draw: st.DrawFn, effect: Effect, pose: np.ndarray, wheels: WheelSet) -> np.ndarray:
    """The pose moved so that one wheel is within 2 cm of a corner of the patch."""
    wheel = draw(st.sampled_from(list(wheels.positions)))
    corner = np.array([draw(st.sampled_from([effect.x_min, effect.x_max])), effect.y_min])
    return np.append(corner + draw(vectors(2, -0.02, 0.02)) - rotation_planar(pose[2]) @ wheel, pose[2])


def _times(effect: Effect) -> st.SearchStrategy[float]:
    """Any time, and, for what begins at one, within 20 ms of its beginning."""
    start = getattr(effect, "start", 0.0)
    return st.one_of(numbers(-1.0, 40.0), numbers(start - 0.02, start + 0.02))
