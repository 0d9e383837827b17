"""How a person pushes: in bursts, and leaning to and fro with the effort."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from .scenes import Roughness, Scene
from .sizes import BY_HAND, ROUGH


def bursts(scene: Scene, random: np.random.Generator) -> Scene:
    """Each arm gives its forward force in strokes, whose mean is what it would have given all the while."""
    drawn = {name: float(random.uniform(*limits)) for name, limits in ROUGH["bursts"].items()}
    drive = scene.drive
    shares = drive.shares * strokes(drive.time, drive.shares.shape[1], drawn, random)
    told = (*scene.roughness, Roughness("bursts", drawn))
    return replace(scene, drive=drive._replace(shares=shares), firmness=BY_HAND, roughness=told)


def strokes(time: np.ndarray, k: int, drawn: dict[str, float], random: np.random.Generator) -> np.ndarray:
    """(n, k), of mean 1: half-sines at a rhythm, each of another length, and in each arm of another height."""
    pattern, at = np.zeros((len(time), k)), time[0] - random.uniform(0.0, 1.0) / drawn["rhythm"]
    while at < time[-1]:
        period = max(1.0 + drawn["jitter"] * random.standard_normal(), 0.5) / drawn["rhythm"]
        since = (time - at) / (drawn["pushed"] * period)
        heights = np.maximum(1.0 + drawn["uneven"] * random.standard_normal(k), 0.2)
        pattern += np.where((since >= 0.0) & (since < 1.0), np.sin(np.pi * since), 0.0)[:, None] * heights
        at += period
    return pattern / pattern.mean(axis=0)


def leaning_load(scene: Scene, random: np.random.Generator) -> Scene:
    """A rider, part of the mass, leans ahead as the push grows: below its own frequency force and acceleration agree on
    the mass, above it the push moves the rider too (`at_once`: the share that does), and the cart feels less."""
    drawn = {name: float(random.uniform(*limits)) for name, limits in ROUGH["leaning_load"].items()}
    own = 2.0 * np.pi * drawn["frequency"]
    world = scene.world._replace(
        lean_mass=drawn["rider"] * scene.world.mass,
        lean_per_force=drawn["at_once"] / (drawn["rider"] * scene.world.mass * own**2),
        lean_frequency=drawn["frequency"],
        lean_damping=drawn["damping"],
    )
    return replace(scene, world=world, firmness=BY_HAND, roughness=(*scene.roughness, Roughness("leaning_load", drawn)))
