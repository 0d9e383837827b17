"""Carts that nobody holds: given a velocity once, they roll. Without a force, all is told per mass."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from .driver import Drive
from .scenes import Roughness, Scene, Truth, draw_time
from .sizes import ROUGH

PER_MASS = {
    "viscous_drag": ("linear", "angular"),
    "stribeck_friction": ("breakaway",),
    "quadratic_drag": ("coefficient",),
    "directional_drag": ("forward", "backward"),
    "caster_realignment": ("swivel_torque",),
    "wheel_drag_imbalance": ("force", "moment"),
    "lateral_slip": ("cornering_stiffness",),
    "external_push": ("force", "moment"),
}
"""Parameters of which a log without a force tells only the ratio to the mass."""


def coasting(scene: Scene, random: np.random.Generator) -> Scene:
    """Shorter than other logs: most stop by themselves before the end."""
    drawn = {name: float(random.uniform(*limits)) for name, limits in ROUGH["coasting"].items()}
    time = draw_time(drawn["duration"], random)
    n = len(time)
    drive = Drive(
        time, np.zeros((n, 4)), np.zeros((n, 0, 3)), np.zeros((n, 0)), np.zeros((n, 0, 6)), np.zeros((n, 2)), False
    )
    speed = drawn["speed"] * float(random.choice([-1.0, 1.0]))
    yaw_rate = 0.0 if scene.world.rail else drawn["yaw_rate"]
    told = Roughness("coasting", {"speed": speed, "yaw_rate": yaw_rate})
    roughness = (*map(without_stroke, scene.roughness), told)
    return replace(scene, drive=drive, begins=(scene.begins[0], speed, yaw_rate), roughness=roughness)


def without_stroke(told: Roughness) -> Roughness:
    """Nobody turns the cart round on its rail."""
    return replace(told, parameters={name: value for name, value in told.parameters.items() if name != "stroke"})


def per_mass(truth: Truth, mass: float) -> dict[str, float]:
    """Of a truth's parameters, those that are only told per mass."""
    values = {**truth.parameters, **truth.roughly}
    return {name: values[name] / mass for name in PER_MASS.get(truth.name, ()) if name in values}
