"""The vocabulary of effects, one file each. The physics of force and inertia effects is in `cartgrasp/kernels/`, that
of constraint and sensor effects in their own files. `docs/extending.md` lists what a new one takes."""

from .caster_realignment import CasterRealignment
from .contact_offset import ContactOffset
from .directional_drag import DirectionalDrag
from .effect import (
    ConstraintEffect,
    Contribution,
    Effect,
    ForceEffect,
    InertiaEffect,
    Parameter,
    SensorEffect,
    Situation,
)
from .end_stop import EndStop
from .external_push import ExternalPush
from .floor_patch import FloorPatch
from .floor_slope import FloorSlope
from .force_bias import ForceBias
from .force_misalignment import ForceMisalignment
from .force_scale import ForceScale
from .lateral_slip import LateralSlip
from .learned_force import LearnedForce
from .load_slosh import LoadSlosh
from .payload_change import PayloadChange
from .pose_offset import PoseOffset
from .quadratic_drag import QuadraticDrag
from .rolling_resistance import RollingResistance
from .stribeck_friction import StribeckFriction
from .time_delay import TimeDelay
from .tool_inertia import ToolInertia
from .unknown_slope import UnknownSlope
from .viscous_drag import ViscousDrag
from .wheel_drag_imbalance import WheelDragImbalance
from .wheel_misalignment import WheelMisalignment

KNOWN_EFFECTS: dict[str, type[Effect]] = {
    effect.name: effect
    for effect in (
        ViscousDrag,
        RollingResistance,
        StribeckFriction,
        QuadraticDrag,
        DirectionalDrag,
        FloorSlope,
        FloorPatch,
        CasterRealignment,
        WheelDragImbalance,
        WheelMisalignment,
        LateralSlip,
        PayloadChange,
        LoadSlosh,
        ForceBias,
        ForceScale,
        ForceMisalignment,
        TimeDelay,
        ContactOffset,
        ToolInertia,
        PoseOffset,
        ExternalPush,
        EndStop,
        LearnedForce,
    )
}

__all__ = [
    "KNOWN_EFFECTS",
    "CasterRealignment",
    "ConstraintEffect",
    "ContactOffset",
    "Contribution",
    "DirectionalDrag",
    "Effect",
    "EndStop",
    "ExternalPush",
    "FloorPatch",
    "FloorSlope",
    "ForceBias",
    "ForceEffect",
    "ForceMisalignment",
    "ForceScale",
    "InertiaEffect",
    "LateralSlip",
    "LearnedForce",
    "LoadSlosh",
    "Parameter",
    "PayloadChange",
    "PoseOffset",
    "QuadraticDrag",
    "RollingResistance",
    "SensorEffect",
    "Situation",
    "StribeckFriction",
    "TimeDelay",
    "ToolInertia",
    "UnknownSlope",
    "ViscousDrag",
    "WheelDragImbalance",
    "WheelMisalignment",
]
