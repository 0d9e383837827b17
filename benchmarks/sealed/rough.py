"""The same scenes through worse sensors: poses and velocities whose noise remembers, poses that are off, lost rows."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from .scenes import Scene

REMEMBERS, WITH_SPEEDS = 0.6, 0.5
"""How often noise does; how often velocities are recorded."""
COLOUR, POSE, SPEED = (0.01, 0.15), (5e-4, 2.5e-3), (5e-3, 1.5e-2)
"""s; m and rad; m/s and rad/s."""
LOST, MOST_OFF = (0.002, 0.03), 6
"""Of the rows; poses."""


def rough(scene: Scene, random: np.random.Generator) -> Scene:
    def colour() -> float:
        return random.uniform(*COLOUR) if random.random() < REMEMBERS else 0.0

    sensors = replace(
        scene.sensors,
        pose_noise=random.uniform(*POSE),
        pose_colour=colour(),
        speed_noise=random.uniform(*SPEED) if random.random() < WITH_SPEEDS else None,
        speed_colour=colour(),
        lost=random.uniform(*LOST) if random.random() < 0.5 else 0.0,
        off=int(random.integers(0, MOST_OFF + 1)),
    )
    return replace(scene, sensors=sensors)
