"""What is generated: nothing, each effect of the vocabulary, what the vocabulary has no name for, pairs, and a few of
these with a cart that MuJoCo simulates; all of it rough on purpose, too."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np

from .effects import VOCABULARY, sign, size, with_effect
from .lawful import FOREIGN
from .rails import along_rail
from .robots import ROBOTS
from .roughness import BARRED, ROUGHNESS, SETTINGS, parts
from .scenes import Scene, Truth, draw_scene, random_of


def flat_spot(scene: Scene, random: np.random.Generator) -> Scene:
    force = scene.world.mass * size("flat_spot", "force", random)
    period = size("flat_spot", "period", random)
    truth = Truth("flat_spot", {"force": force, "period": period}, form="by way rolled, at one wheel", outside=True)
    return with_effect(scene, truth, flat_force=force, flat_period=period)


def wind(scene: Scene, random: np.random.Generator) -> Scene:
    """It grows from nothing with gusts: a constant one would be a slope in disguise."""
    force, heading = scene.world.mass * size("wind", "force", random), random.uniform(-np.pi, np.pi)
    changes = {"wind_x": force * np.cos(heading), "wind_y": force * np.sin(heading)}
    truth = Truth("wind", {"force": force, "heading": heading}, form="grows with time, in gusts", outside=True)
    return with_effect(scene, truth, wind_time=float(scene.drive.time[-1]), **changes)


def oscillating_floor(scene: Scene, random: np.random.Generator) -> Scene:
    quake = sign(random) * size("oscillating_floor", "acceleration", random)
    frequency = size("oscillating_floor", "frequency", random)
    truth = Truth("oscillating_floor", {"period": 1 / frequency}, form="a sine in time, one way in {s}", outside=True)
    return with_effect(scene, truth, quake=quake, quake_frequency=frequency, quake_heading=random.uniform(-1, 1))


OUTSIDE = {f.__name__: f for f in (flat_spot, wind, oscillating_floor)}
LAWS = {name: partial(one.put_into, name) for name, one in FOREIGN.items()}
BESIDE = "rolling_resistance"
"""A name that a law may stand beside."""
LAW_CASES = tuple(f"{name}{beside}" for name in (*OUTSIDE, *LAWS) for beside in ("", f"+{BESIDE}"))
PAIRS = (
    "rolling_resistance+floor_slope",
    "floor_patch+force_bias",
    "caster_realignment+rolling_resistance",
    "payload_change+quadratic_drag",
    "time_delay+wheel_drag_imbalance",
    "wheel_misalignment+external_push",
    "load_slosh+rolling_resistance",
    "payload_change+floor_slope",
)
ROBOT_CASES = tuple(f"{name}{kind}" for name in ROBOTS for kind in ("", "@two_arms"))
"""Beside the vocabulary for which the other lists were made."""
KNOWN = {**VOCABULARY, **ROBOTS, **OUTSIDE, **LAWS}
CASES = ("nothing", *VOCABULARY, *OUTSIDE, *PAIRS)
AT_MUJOCO = "@mujoco"
MUJOCO_CASES = tuple(
    f"{case}{AT_MUJOCO}"
    for case in (
        *("nothing", "rolling_resistance", "caster_realignment", "force_scale"),
        "caster_realignment+rolling_resistance",
    )
)


PROOF = "proof "
"""Before a case's name, where its numbers are drawn from: another stream."""


def draw_case(case: str, seed: int, motion: str, stream: str = "") -> Scene:
    """`stream`: other numbers of the same seed."""
    names, kinds = parts(case)
    random = random_of(stream + case, seed, motion)
    scene = replace(draw_scene((*names, *kinds), motion, random), in_mujoco="mujoco" in kinds)
    for kind in (kind for kind in ROUGHNESS if kind in kinds):
        scene = ROUGHNESS[kind](scene, random)
    if "floor_patch" in names:
        scene = replace(scene, path=scene.run()[0])
    for name in names:
        scene = KNOWN[name](scene, random)
    return along_rail(scene)


def objection(case: str) -> str:
    """Why there is no such case; empty where there is."""
    names, kinds = parts(case)
    unknown = [n for n in names if n not in KNOWN]
    unknown += [k for k in kinds if k not in (*ROUGHNESS, *SETTINGS)]
    if unknown:
        return f"no case {case!r}: {unknown[0]!r} is none of {', '.join((*KNOWN, *ROUGHNESS, *SETTINGS))}"
    beside = [(kind, other) for kind in kinds for other in (*names, *kinds) if other in BARRED.get(kind, ())]
    return f"no case {case!r}: {beside[0][1]} makes no sense beside {beside[0][0]}" if beside else ""
