"""The same scenes with weaker effects, to find from which size on an effect is named.

Where it acts, how fast it fades and swings, and whatever else a scene holds stay as they are.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from .lawful import FOREIGN
from .scenes import Scene, Truth
from .sensors import Fault

IN_WORLD = {
    "viscous_drag": ("linear", "angular"),
    "rolling_resistance": ("rolling",),
    "stribeck_friction": ("stiction",),
    "quadratic_drag": ("quadratic",),
    "directional_drag": ("forward", "backward"),
    "floor_slope": ("grade_x", "grade_y"),
    "floor_patch": ("patch_rolling",),
    "caster_realignment": ("swivel", "scrub"),
    "wheel_drag_imbalance": ("brake_left", "brake_right"),
    "wheel_misalignment": ("toe",),
    "payload_change": ("load_mass",),
    "load_slosh": ("bob_mass",),
    "external_push": ("push_force", "push_moment"),
    "flat_spot": ("flat_force",),
    "wind": ("wind_x", "wind_y"),
    "oscillating_floor": ("quake",),
    **dict.fromkeys(FOREIGN, ("law_size",)),
}
OFFSETS = ("contact_offset", "pose_offset")
"""All of whose numbers are sizes."""
INVERSE = {"lateral_slip": ("cornering",)}
SIZES = {
    *("linear", "angular", "coefficient", "breakaway", "forward", "backward", "grade_x", "grade_y", "swivel_torque"),
    *("force", "moment", "angle", "mass", "fx", "fy", "tz", "delay"),
}
"""Of parameters in a truth, those that are sizes; but for gains, which are 1 where there is no effect."""


def weaker(scene: Scene, share: float) -> Scene:
    """With `share` of the size of each effect."""
    if share == 1.0:
        return scene
    world = scene.world._asdict()
    for truth in scene.truths:
        world |= {name: share * world[name] for name in IN_WORLD.get(truth.name, ())}
        world |= {name: world[name] / share for name in INVERSE.get(truth.name, ())}
    faults = {arm: _less(fault, share) for arm, fault in scene.sensors.faults.items()}
    own = scene.sensors
    sensors = replace(
        own,
        faults=faults,
        delay=share * own.delay,
        beside={arm: (share * x, share * y, z) for arm, (x, y, z) in own.beside.items()},
        tools={arm: (share * mass, *place) for arm, (mass, *place) in own.tools.items()},
        tracked=_nearer(own.tracked, share),
    )
    truths = tuple(_told(truth, share) for truth in scene.truths)
    return replace(scene, world=scene.world._replace(**world), sensors=sensors, truths=truths)


def _nearer(tracked: tuple[float, float, float], share: float) -> tuple[float, float, float]:
    """So that {b} is a share as far off in it."""
    ahead, left, turn = tracked
    point = share * complex(ahead, left) * np.exp(-1j * (1 - share) * turn)
    return float(point.real), float(point.imag), share * turn


def _less(fault: Fault, share: float) -> Fault:
    return Fault(share * fault.angle, 1 + share * (fault.gain - 1), tuple(share * value for value in fault.offset))


def _told(truth: Truth, share: float) -> Truth:
    def scaled(name: str, value: float) -> float:
        if name == "gain":
            return 1 + share * (value - 1)
        if name == "cornering_stiffness":
            return value / share
        return share * value if name in SIZES else value

    if truth.name in OFFSETS:
        return replace(truth, parameters={name: share * value for name, value in truth.parameters.items()})
    parameters, roughly = (
        {name: scaled(name, value) for name, value in group.items()} for group in (truth.parameters, truth.roughly)
    )
    return replace(truth, parameters=parameters, roughly=roughly)
