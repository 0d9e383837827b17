"""Finds where logs and a cart's model disagree by a regression in weak form and one score: built beside `discrepancy`,
which it replaces once it passes every exam that `discrepancy` passes."""

from .diagnosis import Diagnosis, diagnose

__all__ = ["Diagnosis", "diagnose"]
