"""Push passive carts with one or several arms: hold, push, and learn the load while pushing."""

from __future__ import annotations

from typing import TYPE_CHECKING

from .lazy_names import lazy_names

if TYPE_CHECKING:
    from .arms import Arm
    from .cart_file import load_cart
    from .constraints import RollingConstraints
    from .contacts import ContactSet, ContactWrenches, Segment, grasp_map_planar, grasp_map_spatial
    from .effects import KNOWN_EFFECTS
    from .errors import CartgraspError, DataError, FileError, LogError, UsageError
    from .friction import Friction, SoftFinger
    from .inertia import Inertia
    from .information import WrenchNoise
    from .joint_torques import JointTorques
    from .logs import ArmLog, RunLog, read_log, write_log
    from .model import CartModel
    from .motion import Estimate, Measurement, Motion, ParameterEstimate, Reference
    from .reach import Reach
    from .wheels import Wheel

__version__ = "0.1.0"

__all__ = [
    "KNOWN_EFFECTS",
    "Arm",
    "ArmLog",
    "CartModel",
    "CartgraspError",
    "ContactSet",
    "ContactWrenches",
    "DataError",
    "Estimate",
    "FileError",
    "Friction",
    "Inertia",
    "JointTorques",
    "LogError",
    "Measurement",
    "Motion",
    "ParameterEstimate",
    "Reach",
    "Reference",
    "RollingConstraints",
    "RunLog",
    "Segment",
    "SoftFinger",
    "UsageError",
    "Wheel",
    "WrenchNoise",
    "grasp_map_planar",
    "grasp_map_spatial",
    "load_cart",
    "read_log",
    "write_log",
]

_HOMES = {
    "arms": "Arm",
    "cart_file": "load_cart",
    "constraints": "RollingConstraints",
    "contacts": "ContactSet ContactWrenches Segment grasp_map_planar grasp_map_spatial",
    "effects": "KNOWN_EFFECTS",
    "errors": "CartgraspError DataError FileError LogError UsageError",
    "friction": "Friction SoftFinger",
    "inertia": "Inertia",
    "information": "WrenchNoise",
    "joint_torques": "JointTorques",
    "logs": "ArmLog RunLog read_log write_log",
    "model": "CartModel",
    "motion": "Estimate Measurement Motion ParameterEstimate Reference",
    "reach": "Reach",
    "wheels": "Wheel",
}

__getattr__, __dir__ = lazy_names(globals(), _HOMES)  # `cartgrasp --help` needs no numpy
