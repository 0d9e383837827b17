"""`motion` and `confidence` of `PROBLEM.yaml`, as the estimate that a filter would give."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from cartgrasp.first_guess import PHYSICAL_NAMES
from cartgrasp.frames import Array
from cartgrasp.inertia import physical_jacobian
from cartgrasp.motion import Estimate, Motion

from .problem_objective import Refuse
from .problem_schema import ConfidenceEntry, ProblemEntry

if TYPE_CHECKING:
    from cartgrasp.model import CartModel


def estimate_of(entry: ProblemEntry, cart: CartModel, refuse: Refuse) -> Estimate | None:
    """The estimate that the file states; None where it states neither motion nor confidence."""
    if entry.motion is None and entry.confidence is None:
        return None
    names = cart.constraints.velocity_names
    pose, velocity = np.zeros(3), np.zeros(len(names))
    if entry.motion is not None:
        if len(entry.motion.velocity) != len(names):
            stated = len(entry.motion.velocity)
            raise refuse(["motion", "velocity"], f"{stated} numbers, but this cart moves freely in {', '.join(names)}")
        pose, velocity = np.array(entry.motion.pose), np.array(entry.motion.velocity)
    covariance = None if entry.confidence is None else _covariance(entry.confidence, cart, refuse)
    return Estimate(0.0, Motion(pose, velocity), {}, "", cart, cart.parameters, covariance)


def _covariance(entry: ConfidenceEntry, cart: CartModel, refuse: Refuse) -> Array:
    """Covariance (p, p) of the model's parameters, from independent standard deviations of mass, CoM, inertia and the
    effects' values."""
    names = (*PHYSICAL_NAMES, *cart.parameter_names[len(PHYSICAL_NAMES) :])
    for name in entry.std:
        if name not in names:
            raise refuse(["confidence", "std", name], f"this cart has no parameter {name}; it has {', '.join(names)}")
    to_phi = np.eye(len(names))
    to_phi[:4, :4] = np.linalg.inv(physical_jacobian(cart.inertia.phi))
    root = to_phi * [entry.std.get(name, 0.0) for name in names]
    return np.asarray(root @ root.T)
