"""MuJoCo's `sysid` with everything free, as a method that names effects: what its model has, and what is not zero.

Its model has no loads, patches, pushes or delays, no casters, of a single sensor nothing but its gain, and drags that
are linear or dry; so some effects can't be named.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from .mujoco_sysid import HALF_TRACK, Course, Fit, Free, fit
from .physics import told
from .recorded import Cart, Recorded

WINDOW = 1.0
"""s: in longer ones what the wrenches' noise adds up to is taken for effects."""
DRAG = ("linear", "angular")
EFFECTS = {
    "viscous_drag": DRAG,
    "rolling_resistance": ("rolling", "turning"),
    "wheel_drag_imbalance": ("imbalance",),
    "floor_slope": ("grade_x", "grade_y"),
    "wheel_misalignment": ("toe",),
    "lateral_slip": ("slip",),
    "force_bias": ("pull", "twist"),
}
"""Names of effects, with what they are in the model."""
MEANT = {
    **{name: (name, 1.0) for name in ("linear", "angular", "grade_x", "grade_y")},
    "imbalance": ("moment", HALF_TRACK),
    "toe": ("angle", 1.0),
    "pull": ("fx", -1.0),
    "twist": ("tz", -1.0),
}
"""Parameters of effects, and in which unit; a sensor's bias is against what the cart feels of it."""


def rolled_out(log: Recorded, cart: Cart, stop: float) -> dict[str, Any]:
    """A report. Named is what has a value outside of its interval from 'absent', and without which `stop` or more of
    what would then be left is left besides."""
    free = freed(log, cart)
    found = fit(course(log), free, WINDOW)
    places = {one.name: i for i, one in enumerate(free)}
    groups = [(name, "", parts) for name, parts in EFFECTS.items() if name != "viscous_drag" or cart.drag is None]
    groups += [("force_scale", arm, (f"gain {arm}",)) for arm in log.wrenches if f"gain {arm}" in places]
    shares = [
        missed(found, [places[part] for part in parts], float(name == "force_scale")) for name, _, parts in groups
    ]
    order = [int(i) for i in np.argsort(-np.array(shares)) if shares[i] > 0 and shares[i] >= stop]
    effects = [entry(found, cart, places, groups[i]) for i in order]
    return told(cart, effects, [(float(value), deviation(found, i)) for i, value in enumerate(found.values[:6])])


def course(log: Recorded) -> Course:
    c, s = np.cos(log.heading), np.sin(log.heading)
    motion = np.column_stack([log.x, log.y, log.heading, c * log.u - s * log.v, s * log.u + c * log.v, log.r])
    wrenches = {}
    for arm, wrench in log.wrenches.items():
        forward, moment = log.planar(arm).T
        wrenches[arm] = np.column_stack([forward, wrench[:, 1], moment])
    return Course(log.time, motion, wrenches)


def freed(log: Recorded, cart: Cart) -> list[Free]:
    """All arms but one may have another gain: were all free, so would be the unit of force."""
    m, (x, y), weight = cart.mass, cart.com, cart.weight
    linear, angular = cart.drag or (0.0, 0.0)
    return [
        Free("mass", m, 0.2 * m, 5 * m),
        Free("com_x", x, x - 0.5, x + 0.5),
        Free("com_y", y, y - 0.5, y + 0.5),
        Free("inertia", cart.inertia, 0.1 * cart.inertia, 10 * cart.inertia),
        Free("linear", linear, 0.0, 2 * m),
        Free("angular", angular, 0.0, m),
        Free("rolling", 0.0, 0.0, 0.1 * weight),
        Free("imbalance", 0.0, -0.1 * weight, 0.1 * weight),
        Free("turning", 0.0, 0.0, 0.05 * weight),
        Free("grade_x", 0.0, -0.2, 0.2),
        Free("grade_y", 0.0, -0.2, 0.2),
        Free("toe", 0.0, -0.3, 0.3),
        Free("slip", 0.0, 0.0, 0.01),
        Free("pull", 0.0, -30.0, 30.0),
        Free("twist", 0.0, -10.0, 10.0),
        *(Free(f"gain {arm}", 1.0, 0.4, 2.5) for arm in list(log.wrenches)[1:]),
    ]


def missed(found: Fit, places: list[int], absent: float) -> float:
    """The share of what would be left without these parameters that they take away; 0 where none is significant."""
    off = found.values[places] - absent
    if not (abs(off) > found.intervals[places]).any():
        return 0.0
    square = float(off @ np.linalg.pinv(found.covariance[np.ix_(places, places)]) @ off)
    return square / (square + found.count - len(found.values))


def entry(found: Fit, cart: Cart, places: dict[str, int], group: tuple[str, str, tuple[str, ...]]) -> dict[str, Any]:
    name, label, parts = group
    meant = MEANT | {"rolling": ("coefficient", 1 / cart.weight), f"gain {label}": ("gain", 1.0)}
    parameters = {}
    for part in parts:
        if part in meant:
            (key, unit), at = meant[part], places[part]
            std = abs(unit) * deviation(found, at)
            parameters[key] = {"value": float(unit * found.values[at]), "std": std, "unit": ""}
    return {"name": name, "label": label, "parameters": parameters, "confusable_with": []}


def deviation(found: Fit, place: int) -> float:
    return float(np.sqrt(found.covariance[place, place]))
