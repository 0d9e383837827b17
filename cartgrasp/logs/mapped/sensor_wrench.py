"""A force sensor's readings as wrenches that the arm does to the cart, in the contact frame {a}.

The sensor's frame is {f}, fixed in {a}. A tool between sensor and cart is held by the arm: its weight is in the reading
and not on the cart. Wrenches transform with the transposed adjoint, `F_a = Ad(g_fa)ᵀ F_f`.
"""

from __future__ import annotations

import numpy as np

from ...frames import Array, adjoint
from ...spatial_pose import SpatialPose
from ...wheels import GRAVITY
from .run_map import ArmEntry, ToolEntry


def tool_weight(tool: ToolEntry, rotation_af: Array) -> Array:
    """Wrench (6,) of gravity on the tool, about {f}'s origin and in {f}; {a}'s z points up."""
    force = rotation_af.T @ np.array([0.0, 0.0, -tool.mass * GRAVITY])
    return np.concatenate([force, np.cross(tool.com, force)])


def on_cart(readings: Array, arm: ArmEntry) -> Array:
    """Readings (n, 6) in {f} as what the arm does to the cart, in {f}."""
    wrench = -readings if arm.force == "on_sensor" else readings
    if arm.tool is not None:
        wrench = wrench + tool_weight(arm.tool, _pose_af(arm).rotation)
    return wrench


def at_contact(wrench_f: Array, arm: ArmEntry) -> Array:
    """Wrenches (n, 6) in {f}, in {a}."""
    pose_af = _pose_af(arm)
    rotation_fa = pose_af.rotation.T
    return np.asarray(wrench_f @ adjoint(rotation_fa, -rotation_fa @ pose_af.position))


def _pose_af(arm: ArmEntry) -> SpatialPose:
    return SpatialPose.of(arm.sensor.position, *arm.sensor.rpy)
