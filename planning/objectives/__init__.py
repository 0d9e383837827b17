"""Objectives of an allocation."""

from __future__ import annotations

from .additions import LeastInternalForce, LeastJointTorque, LeastSideForce, LoadShare, Smoothness
from .lexicographic import Lexicographic
from .objective import Cost, Nothing, Objective, WeightedWrench
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
