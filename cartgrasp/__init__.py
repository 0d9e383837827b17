"""Push passive carts with one or several arms: hold, push, and learn the load while pushing."""

from .arms import Arm, Friction
from .cart_file import load_cart
from .constraints import RollingConstraints
from .contacts import ContactSet, ContactWrenches, Segment, grasp_map_planar, grasp_map_spatial
from .effects import KNOWN_EFFECTS
from .errors import CartgraspError, DataError, FileError, LogError, UsageError
from .inertia import Inertia
from .joint_torques import JointTorques
from .logs import RunLog, read_log, write_log
from .model import CartModel
from .motion import Estimate, Measurement, Motion, ParameterEstimate, Reference
from .reach import Reach
from .wheels import Wheel

__version__ = "0.1.0"

__all__ = [
    "KNOWN_EFFECTS",
    "Arm",
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
    "UsageError",
    "Wheel",
    "grasp_map_planar",
    "grasp_map_spatial",
    "load_cart",
    "read_log",
    "write_log",
]
