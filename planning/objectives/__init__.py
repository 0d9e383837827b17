"""Objectives of an allocation, one small file each."""

from __future__ import annotations

from .load_share import LoadShare
from .objective import Cost, Objective
from .smoothness import Smoothness
from .weighted_wrench import WeightedWrench

__all__ = ["Cost", "LoadShare", "Objective", "Smoothness", "WeightedWrench"]
