"""Objectives of an allocation, one small file each."""

from __future__ import annotations

from .least_internal_force import LeastInternalForce
from .least_joint_torque import LeastJointTorque
from .least_side_force import LeastSideForce
from .lexicographic import Lexicographic
from .load_share import LoadShare
from .objective import Cost, Nothing, Objective, WeightedWrench
from .smoothness import Smoothness
from .worst_arm import WorstArm

__all__ = [
    "Cost",
    "LeastInternalForce",
    "LeastJointTorque",
    "LeastSideForce",
    "Lexicographic",
    "LoadShare",
    "Nothing",
    "Objective",
    "Smoothness",
    "WeightedWrench",
    "WorstArm",
]
