"""Learning a cart's load, drag and sensor offsets from how it moves when it is pushed."""

from .cart_filter import CartFilter
from .discrepancy import Diagnosis, diagnose
from .identifiability import Identifiability, identifiability
from .identification import Identification, identify
from .noise import FilterNoise
from .paper_filter import PaperFilter
from .prior import Prior
from .regressor_estimator import RegressorEstimator

__all__ = [
    "CartFilter",
    "Diagnosis",
    "FilterNoise",
    "Identifiability",
    "Identification",
    "PaperFilter",
    "Prior",
    "RegressorEstimator",
    "diagnose",
    "identifiability",
    "identify",
]
