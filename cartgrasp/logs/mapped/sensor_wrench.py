"""A force sensor's readings as wrenches that the arm does to the cart, in the contact frame {a}.

The sensor's frame is {f}, fixed in {a}. A tool between sensor and cart is held by the arm: its weight is in the reading
and not on the cart. Wrenches transform with the transposed adjoint, `F_a = Ad(g_fa)ᵀ F_f`.
"""

from __future__ import annotations

import numpy as np

from ...frames import Array, adjoint
from ...wheels import GRAVITY
from .run_map import ArmEntry, ToolEntry


def rotation_of(rpy: list[float]) -> Array:
    """R = Rz(yaw) Ry(pitch) Rx(roll), as URDF has it."""
    (cr, cp, cy), (sr, sp, sy) = np.cos(rpy), np.sin(rpy)
    return np.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    )


def tool_weight(tool: ToolEntry, rotation_af: Array) -> Array:
    """Wrench (6,) of gravity on the tool, about {f}'s origin and in {f}; {a}'s z points up."""
    force = rotation_af.T @ np.array([0.0, 0.0, -tool.mass * GRAVITY])
    return np.concatenate([force, np.cross(tool.com, force)])


def on_cart(readings: Array, arm: ArmEntry) -> Array:
    """Readings (n, 6) in {f} as what the arm does to the cart, in {f}."""
    wrench = -readings if arm.force == "on_sensor" else readings
    if arm.tool is not None:
        wrench = wrench + tool_weight(arm.tool, rotation_of(arm.sensor.rpy))
    return wrench


def at_contact(wrench_f: Array, arm: ArmEntry) -> Array:
    """Wrenches (n, 6) in {f}, in {a}."""
    rotation_fa = rotation_of(arm.sensor.rpy).T
    position_fa = -rotation_fa @ np.array(arm.sensor.position)
    return np.asarray(wrench_f @ adjoint(rotation_fa, position_fa))
