"""Finds where logs and a cart's model disagree, names the missing effect, adds it, and shows the gap shrink."""

from .diagnosis.diagnosis import Diagnosis, diagnose

__all__ = ["Diagnosis", "diagnose"]
