"""The closed loop in simulation: plants that stand in for a robot, its sensors, and what a run leaves."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..lazy_names import lazy_names

if TYPE_CHECKING:
    from .closed_loop import Loop, run
    from .mujoco_plant import MujocoPlant
    from .plant import ModelPlant
    from .record import RunRecord, Series
    from .sensors import SensorNoise, Sensors

__all__ = ["Loop", "ModelPlant", "MujocoPlant", "RunRecord", "SensorNoise", "Sensors", "Series", "run"]

_HOMES = {
    "closed_loop": "Loop run",
    "mujoco_plant": "MujocoPlant",
    "plant": "ModelPlant",
    "record": "RunRecord Series",
    "sensors": "SensorNoise Sensors",
}

__getattr__, __dir__ = lazy_names(globals(), _HOMES)
