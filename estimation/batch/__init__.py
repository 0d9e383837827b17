"""Whole logs at once: the parameters of a cart by generalised least squares, physically consistent."""

from .identification import Identification, LogFit, identify

__all__ = ["Identification", "LogFit", "identify"]
