"""MuJoCo's `sysid` as a batch estimator: the cart that all begin with, in its planar model, with body, drags and dry
friction free in wide boxes; whole logs, smoothed by a polynomial that slides so that windows begin well."""

from __future__ import annotations

from importlib.util import find_spec

import numpy as np
from scipy.signal import savgol_filter

from cartgrasp.contacts import grasp_map_planar
from cartgrasp.effects import RollingResistance, ViscousDrag
from cartgrasp.inertia import N_PHI, phi_from_physical, physical_jacobian
from cartgrasp.logs import RunLog
from cartgrasp.model import CartModel
from cartgrasp.wheels import GRAVITY
from estimation.gaussian import Gaussian

from .sealed.mujoco_sysid import Course, Free, fit

ROWS, ORDER = 31, 3
"""Of the sliding polynomial."""
WINDOW = 4.0  # s
NEEDED = "absl", "colorama", "imageio", "jinja2", "plotly", "tabulate", "yaml"


def installed() -> bool:
    """MuJoCo brings `sysid`, an extra what it needs."""
    return all(map(find_spec, NEEDED))


def rolled_out(log: RunLog, cart: CartModel) -> Gaussian:
    """phi, from a first guess that has viscous drag and rolling resistance."""
    found = fit(course(log), freed(cart), WINDOW)
    phi = phi_from_physical(*found.values[:N_PHI])
    lift = np.linalg.inv(physical_jacobian(phi))
    return Gaussian(phi, lift @ found.covariance[:N_PHI, :N_PHI] @ lift.T)


def course(log: RunLog) -> Course:
    motion = np.hstack([log.pose, log.velocity])
    motion[:, 2] = np.unwrap(motion[:, 2])
    given = [np.einsum("nij,nj->ni", grasp_map_planar(arm.contact), arm.wrench) for arm in log.arms.values()]
    return Course(log.time, savgol_filter(motion, ROWS, ORDER, axis=0), {"arms": np.sum(given, axis=0)})


def freed(cart: CartModel) -> list[Free]:
    body = cart.inertia
    (drag,) = (effect for effect in cart.effects if isinstance(effect, ViscousDrag))
    (friction,) = (effect for effect in cart.effects if isinstance(effect, RollingResistance))
    level = friction.coefficient * body.mass * GRAVITY
    return [
        Free("mass", body.mass, 0.2 * body.mass, 5 * body.mass),
        Free("com_x", body.com[0], -1.0, 1.0),
        Free("com_y", body.com[1], -1.0, 1.0),
        Free("inertia", body.about_com, 0.1 * body.about_com, 10 * body.about_com),
        Free("linear", drag.linear, 0.0, 10 * drag.linear),
        Free("angular", drag.angular, 0.0, 10 * drag.angular),
        Free("rolling", level, 0.0, 10 * level),
    ]
