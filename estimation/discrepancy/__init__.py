"""Where simulation and measurement disagree, which effect is missing, and the model with it."""

from .diagnosis import Diagnosis, diagnose

__all__ = ["Diagnosis", "diagnose"]
