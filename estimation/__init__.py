"""Learning a cart's load, drag and sensor offsets from how it moves when it is pushed."""

from __future__ import annotations

from typing import TYPE_CHECKING

from cartgrasp.lazy_names import lazy_names

if TYPE_CHECKING:
    from .discrepancy import Diagnosis, diagnose
    from .experiments.manoeuvres import Limits
    from .identifiable import Identifiability, identifiability
    from .noise import FilterNoise
    from .online.cart_filter import CartFilter
    from .online.disturbance.disturbed_filter import DisturbedFilter
    from .online.paper_filter import PaperFilter
    from .online.regressor_estimator import RegressorEstimator
    from .prior import Prior
    from .sensor_check import Suspicion, check_sensors
    from .whole_log.identification import Identification, identify

__all__ = [
    "CartFilter",
    "Diagnosis",
    "DisturbedFilter",
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
    "online.cart_filter": "CartFilter",
    "online.disturbance.disturbed_filter": "DisturbedFilter",
    "discrepancy": "Diagnosis diagnose",
    "experiments.manoeuvres": "Limits",
    "identifiable": "Identifiability identifiability",
    "whole_log.identification": "Identification identify",
    "noise": "FilterNoise",
    "online.paper_filter": "PaperFilter",
    "prior": "Prior",
    "online.regressor_estimator": "RegressorEstimator",
    "sensor_check": "Suspicion check_sensors",
}

__getattr__, __dir__ = lazy_names(globals(), _HOMES)
