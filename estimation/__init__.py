"""Learning a cart's load, drag and sensor offsets from how it moves when it is pushed."""

from __future__ import annotations

from typing import TYPE_CHECKING

from cartgrasp.lazy_names import lazy_names

if TYPE_CHECKING:
    from .cart_filter import CartFilter
    from .discrepancy import Diagnosis, diagnose
    from .experiments.manoeuvres import Limits
    from .identifiable import Identifiability, identifiability
    from .identification import Identification, identify
    from .noise import FilterNoise
    from .paper_filter import PaperFilter
    from .prior import Prior
    from .regressor_estimator import RegressorEstimator
    from .sensor_check import Suspicion, check_sensors

__all__ = [
    "CartFilter",
    "Diagnosis",
    "FilterNoise",
    "Identifiability",
    "Identification",
    "Limits",
    "PaperFilter",
    "Prior",
    "RegressorEstimator",
    "Suspicion",
    "check_sensors",
    "diagnose",
    "identifiability",
    "identify",
]

_HOMES = {
    "cart_filter": "CartFilter",
    "discrepancy": "Diagnosis diagnose",
    "experiments.manoeuvres": "Limits",
    "identifiable": "Identifiability identifiability",
    "identification": "Identification identify",
    "noise": "FilterNoise",
    "paper_filter": "PaperFilter",
    "prior": "Prior",
    "regressor_estimator": "RegressorEstimator",
    "sensor_check": "Suspicion check_sensors",
}

__getattr__, __dir__ = lazy_names(globals(), _HOMES)
