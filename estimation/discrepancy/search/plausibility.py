"""What an effect may be to be called by its name: one table of sizes and bounds."""

from __future__ import annotations

import numpy as np

from cartgrasp.effects import ConstraintEffect, Effect
from cartgrasp.effects.time_delay import TimeDelay
from cartgrasp.wheels import WheelSet

from ...standstill import HALF_TRACK
from .candidates import amplitudes_of

PRIOR_LOG_ODDS = {"rolling_resistance": 4.0}
"""Log of how much more usual an effect is than others: every wheel resists (physics.md)."""
UBIQUITOUS_EFFECTS = ("rolling_resistance", "time_delay")
"""What every cart has, or every chain of sensors: however little it is beside another, it is not that one's form."""
MIN_NAMED_SIZE_RATIO = 0.1
"""Least share of an effect's usual size: nobody calls less by its name."""
MIN_SETTINGS = {
    "time_delay.delay": 0.008,  # s: sensors that hold or average samples at 100 Hz are as late
    "load_slosh.damping": 0.003,  # less has no spring or liquid
    "force_scale.gain": 0.5,  # beyond, units are wrong (`check`)
}
MAX_SETTINGS = {
    "time_delay.delay": 0.15,  # s: what is later has another cause
    "load_slosh.damping": 0.3,  # nothing swings beyond
    "load_slosh.frequency": 4.0,  # Hz: what is faster is no load
    "external_push.duration": 6.0,  # s: what lasts longer has another cause
    "stribeck_friction.speed": 0.5,  # m/s: beyond, it is Coulomb's drag at all speeds that a cart has
    "caster_realignment.trail": 0.15,  # m
    "force_scale.gain": 2.0,
    "force_misalignment.angle": 0.5,  # rad: beyond, axes are wrong (`check`)
    "contact_offset.y": 0.1,  # m: beyond, the hand holds elsewhere
}
"""Bounds between which a setting of what bears the name lies."""
MOMENT_BY_FORCE = {"wheel_drag_imbalance": ("moment", "force")}
"""No wheel drives: the moment of wheels that drag unlike is at most the drag times half a track."""
ESSENTIAL_PARAMETERS = {"wheel_drag_imbalance": "moment", "pose_offset": "x"}
"""What makes an effect what its name says: without it, the wheels of an axle drag alike, and a frame that is turned, or
beside {b}, is one whose wheels, or hands, are."""
ESSENTIAL_SIGMAS = 2.0
"""Standard deviations by which what is essential must be beyond nought."""
BOUND_SLACK_RATIO = 1.5
"""Factor beyond what is plausible that is let pass: estimates have errors. What gains most beyond is something else,
and is not followed."""


def is_plausible(effect: Effect, wheels: WheelSet) -> bool:
    """Whether somebody who knows carts would call it so at its values."""
    return not objection(effect, wheels)


def objection(effect: Effect, wheels: WheelSet) -> str:
    """Why nobody would call it so at its values; empty where somebody would."""
    if is_negligible(effect):
        return f"less than {MIN_NAMED_SIZE_RATIO:g} of its usual size has no name"
    if isinstance(effect, ConstraintEffect):
        return ""
    if beyond := out_of_bounds(effect):
        return beyond
    values = dict(zip((f"{effect.name}.{p.name}" for p in effect.parameters), effect.values.tolist(), strict=True))
    if effect.name in MOMENT_BY_FORCE:
        moment, force = (abs(values[f"{effect.name}.{name}"]) for name in MOMENT_BY_FORCE[effect.name])
        tracks = [abs(wheel.y) for wheel in wheels.wheels if wheel.y]
        if moment > BOUND_SLACK_RATIO * max(tracks, default=HALF_TRACK) * force:
            return f"a moment of {moment:.2g} N·m is more than {force:.2g} N at a wheel make"
    return ""


def is_negligible(effect: Effect) -> bool:
    """Whether there is next to nothing of it."""
    if isinstance(effect, ConstraintEffect):
        usual = type(effect).usual("")
        if effect.slip_compliance:
            return effect.slip_compliance <= MIN_NAMED_SIZE_RATIO * usual.slip_compliance
        return bool(abs(effect.values[0]) <= MIN_NAMED_SIZE_RATIO * abs(usual.values[0]))
    if isinstance(effect, TimeDelay):
        return False
    own = amplitudes_of(effect)
    sizes = [abs(effect.values[i] - effect.parameters[i].absent) / effect.parameters[i].typical for i in own]
    return max(sizes, default=0.0) <= MIN_NAMED_SIZE_RATIO


def out_of_bounds(effect: Effect, spare: float = 1.0) -> str:
    """Which of an effect's settings is beyond what it may have by more than a factor `spare`; empty where none is."""
    for p, value in zip(effect.parameters, effect.values.tolist(), strict=True):
        key = f"{effect.name}.{p.name}"
        least, most = MIN_SETTINGS.get(key, -np.inf), MAX_SETTINGS.get(key, np.inf)
        if spare * value < least or abs(value) > spare * most:
            bound = f"{least:g} at least" if spare * value < least else f"{most:g} at most"
            return f"a {p.name} of {value:.3g} {p.unit} is none of this name: {bound}"
    return ""
