"""Sensors as robots have them: encoders with steps, force sensors that follow slowly, velocities from another clock."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from .scenes import Roughness, Scene
from .sizes import NOISE, POSE_STEPS, ROUGH


def quantised_poses(scene: Scene, random: np.random.Generator) -> Scene:
    """Poses in whole steps, without other noise and without velocities; headings as two encoded wheels tell them."""
    step = float(random.choice(POSE_STEPS))
    angle = step / (2.0 * scene.world.half_track)
    sensors = replace(scene.sensors, pose_noise=0.0, speed_noise=None, steps=(step, angle))
    told = Roughness("quantised_poses", {"step": step, "angle_step": angle})
    return replace(scene, sensors=sensors, roughness=(*scene.roughness, told))


def force_lag(scene: Scene, random: np.random.Generator) -> Scene:
    """All force sensors follow by one time constant. Who calls that a delay is not wrong."""
    lag = float(random.uniform(*ROUGH["force_lag"]["lag"]))
    told = Roughness("force_lag", {"lag": lag}, ("time_delay",))
    return replace(scene, sensors=replace(scene.sensors, lag=lag), roughness=(*scene.roughness, told))


def late_velocities(scene: Scene, random: np.random.Generator) -> Scene:
    delay = float(random.uniform(*ROUGH["late_velocities"]["delay"]))
    told = Roughness("late_velocities", {"delay": delay})
    sensors = replace(scene.sensors, speed_delay=delay, speed_noise=NOISE["speed"])
    return replace(scene, sensors=sensors, roughness=(*scene.roughness, told))


def large_velocities(scene: Scene, random: np.random.Generator) -> Scene:
    gain = float(random.uniform(*ROUGH["large_velocities"]["gain"]))
    told = Roughness("large_velocities", {"gain": gain})
    sensors = replace(scene.sensors, speed_gain=gain, speed_noise=NOISE["speed"])
    return replace(scene, sensors=sensors, roughness=(*scene.roughness, told))
