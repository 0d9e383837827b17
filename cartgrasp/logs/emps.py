"""The EMPS data set: a linear axis, force and position (Janot, Gautier, Brunot, 2019), as a run log.

The MATLAB file holds t (s), qm (m, measured), qg (m, reference), vir (V, drive signal) and gtau (N/V); the force is
`gtau * vir`. In this project's words it is a cart on a rail that one arm pushes at {b}'s origin.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ..cart_file import cart_from_text
from ..errors import LogError, Place
from ..model import CartModel
from .run_log import ArmLog, RunLog

ARM = "drive"
RAIL_CART = """\
# The EMPS axis before anything is known of it: a cart on a rail.
name: EMPS linear axis
mass: 80.0                # kg, a first guess
com: [0.0, 0.0]           # a rail can't teach it
inertia: 1.0
constraints:
  - no_lateral_slip: {x: 0.0}
  - no_rotation: {}
effects:
  viscous_drag: {linear: 100.0, angular: 0.0}
  rolling_resistance: {coefficient: 0.01}
  force_bias: {fx: 0.0, fy: 0.0, tz: 0.0}
"""


def rail_cart() -> CartModel:
    """The cart that comes with the data set."""
    return cart_from_text(RAIL_CART, "the EMPS axis")


def read_emps(path: str | Path) -> RunLog:
    """The log of DATA_EMPS.mat."""
    from scipy.io import loadmat
    from scipy.io.matlab import MatReadError

    name = str(path)
    try:
        data = loadmat(path)
    except OSError as error:
        raise LogError(Place(name), "", f"can't be read: {error.strerror or error}") from error
    except (MatReadError, ValueError, NotImplementedError, TypeError) as error:
        raise LogError(Place(name), "", f"can't be read as a MATLAB file: {error}") from error
    columns = {}
    for key in ("t", "qm", "vir", "gtau"):
        if key not in data:
            raise LogError(Place(name), key, "this variable is missing; an EMPS file has t, qm, qg, vir and gtau")
        columns[key] = np.asarray(data[key], dtype=float).ravel()
    time, position, force = columns["t"], columns["qm"], columns["gtau"] * columns["vir"]
    if not len(time) == len(position) == len(force):
        raise LogError(Place(name), "t", f"{len(time)} times, {len(position)} positions, {len(force)} drive signals")
    if len(time) < 2 or not np.isfinite(time).all() or (np.diff(time) <= 0).any():
        raise LogError(Place(name), "t", "must be finite and strictly increasing")
    zero = np.zeros_like(time)
    wrench = np.column_stack([force, *[zero] * 5])
    return RunLog(
        time=time,
        pose=np.column_stack([position, zero, zero]),
        velocity=None,
        arms={ARM: ArmLog(np.zeros((len(time), 3)), wrench)},
        name=name,
    )
