"""The EMPS data set: a linear axis, force and position (Janot, Gautier, Brunot, 2019), as a run log.

The MATLAB file holds t (s), qm (m, measured), qg (m, reference), vir (V, drive signal) and gtau (N/V); the force is
`gtau * vir`. In this project's words it is a cart on a rail that one arm pushes at {b}'s origin.
"""

from __future__ import annotations

import struct
import warnings
import zlib
from pathlib import Path
from typing import Any

import numpy as np

from ..cart_file import cart_from_text
from ..errors import LogError, Place
from ..frames import Array
from ..model import CartModel
from .run_log import ArmLog, RunLog

EMPS_ARM = "drive"
EMPS_VARIABLES = ("t", "qm", "vir", "gtau")
MATLAB_ERRORS = (
    ValueError,
    TypeError,
    LookupError,
    ArithmeticError,
    MemoryError,
    Warning,
    NotImplementedError,
    AttributeError,
    zlib.error,
    struct.error,
)
"""Beside its own errors, what scipy stumbles over where bytes are not what they should be."""
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
    name = str(path)
    time, position, voltage, gain = _variables(name)
    if len(gain) != 1:
        raise LogError(Place(name), "gtau", f"{len(gain)} numbers; one is needed, in N/V")
    if not len(time) == len(position) == len(voltage):
        lengths = f"{len(time)} times, {len(position)} positions (qm), {len(voltage)} drive signals (vir)"
        raise LogError(Place(name), "t", f"{lengths}; as many of each are needed")
    if len(time) < 2 or not np.isfinite(time).all() or (time[1:] <= time[:-1]).any():
        raise LogError(Place(name), "t", "must be finite and strictly increasing, with two rows or more")
    force = gain * voltage
    zero = np.zeros_like(time)
    wrench = np.column_stack([force, *[zero] * 5])
    return RunLog(
        time=time,
        pose=np.column_stack([position, zero, zero]),
        velocity=None,
        arms={EMPS_ARM: ArmLog(np.zeros((len(time), 3)), wrench)},
        name=name,
    )


def _variables(name: str) -> list[Array]:
    """t, qm, vir and gtau, flat."""
    data = _matlab_file(name)
    for key in EMPS_VARIABLES:
        if key not in data:
            raise LogError(Place(name), key, "this variable is missing; an EMPS file has t, qm, qg, vir and gtau")
    found = []
    for key in EMPS_VARIABLES:
        value = data[key]
        if not isinstance(value, np.ndarray) or value.dtype.kind not in "fiu":
            raise LogError(Place(name), key, "does not hold real numbers")
        column = value.astype(float).ravel()
        if np.isinf(column).any():
            raise LogError(Place(name), key, "holds a number that is not finite")
        found.append(column)
    return found


def _matlab_file(name: str) -> dict[str, Any]:
    from scipy.io import loadmat
    from scipy.io.matlab import MatReadError

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")  # what may be corrupt is refused
            return dict(loadmat(name, variable_names=EMPS_VARIABLES))
    except OSError as error:
        raise LogError(Place(name), "", f"can't be read: {error.strerror or error}") from error
    except (MatReadError, *MATLAB_ERRORS) as error:
        why = f"can't be read as a MATLAB file of version 4 to 7.2: {error or type(error).__name__}"
        raise LogError(Place(name), "", why) from error
