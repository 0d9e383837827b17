"""Each effect of the vocabulary put into a scene, in the form that this benchmark gives it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from .scenes import Scene, Truth, rests
from .sensors import Fault
from .sizes import BRISTLE, EFFECTS, TANH_WIDTH
from .world import GRAVITY, THETA, X

Draw = np.random.Generator
LUGRE, TANH = "LuGre bristles at each wheel", "tanh at each wheel"


def sign(random: Draw) -> float:
    return float(random.choice([-1.0, 1.0]))


def size(effect: str, name: str, random: Draw) -> float:
    return float(random.uniform(*EFFECTS[effect][name]))


def with_effect(scene: Scene, truth: Truth, **changes: float) -> Scene:
    return replace(scene, world=scene.world._replace(**changes), truths=(*scene.truths, truth))


def with_friction(scene: Scene, truth: Truth, random: Draw, **changes: float) -> Scene:
    """Dry friction: of bristles in half of the seeds, else a tanh with a width of its own."""
    if random.random() < 0.5:
        kind = {"bristle": float(random.uniform(*BRISTLE))}
        return with_effect(scene, replace(truth, form=LUGRE), **kind, **changes)
    return with_effect(scene, replace(truth, form=TANH), width=float(random.uniform(*TANH_WIDTH)), **changes)


def viscous_drag(scene: Scene, random: Draw) -> Scene:
    mass = scene.world.mass
    values = {name: mass * size("viscous_drag", name, random) for name in ("linear", "angular")}
    return with_effect(scene, Truth("viscous_drag", values, form="not in cart.yaml"), **values)


def rolling_resistance(scene: Scene, random: Draw) -> Scene:
    c = size("rolling_resistance", "coefficient", random)
    return with_friction(scene, Truth("rolling_resistance", {"coefficient": c}), random, rolling=c)


def stribeck_friction(scene: Scene, random: Draw) -> Scene:
    peak = scene.world.mass * size("stribeck_friction", "breakaway", random)
    speed = size("stribeck_friction", "speed", random)
    truth = Truth("stribeck_friction", {}, {"breakaway": peak, "speed": speed})
    return with_friction(scene, truth, random, stiction=peak, stiction_speed=speed)


def quadratic_drag(scene: Scene, random: Draw) -> Scene:
    c = scene.world.mass * size("quadratic_drag", "coefficient", random)
    return with_effect(
        scene, Truth("quadratic_drag", {}, {"coefficient": c}, form="at the CoM, so it brakes turns too"), quadratic=c
    )


def directional_drag(scene: Scene, random: Draw) -> Scene:
    values = {name: scene.world.mass * size("directional_drag", name, random) for name in ("forward", "backward")}
    if random.random() < 0.5:
        values = {"forward": values["backward"], "backward": values["forward"]}
    return with_effect(scene, Truth("directional_drag", {}, values, form="blended over 6 cm/s"), **values)


def floor_slope(scene: Scene, random: Draw) -> Scene:
    grade, heading = size("floor_slope", "grade", random), random.uniform(-np.pi, np.pi)
    values = {"grade_x": float(grade * np.cos(heading)), "grade_y": float(grade * np.sin(heading))}
    truth = Truth("floor_slope", values, form="a floor that waves by some % of its grade")
    return with_effect(scene, truth, bow=size("floor_slope", "bow", random), **values)


def floor_patch(scene: Scene, random: Draw) -> Scene:
    """A carpet that the cart rolls on for 15 to 45 % of the time."""
    c, ramp = size("floor_patch", "coefficient", random), size("floor_patch", "ramp", random)
    centres = scene.path[:, X:THETA] + 0.5 * scene.world.caster_x * np.column_stack(
        [np.cos(scene.path[:, THETA]), np.sin(scene.path[:, THETA])]
    )
    best, found = 1.0, None
    for _ in range(200):
        middle = centres[random.integers(len(centres))]
        half = 0.5 * np.array([size("floor_patch", "size", random) for _ in "xy"])
        share = float((np.abs(centres - middle) < half).all(axis=1).mean())
        if abs(share - 0.3) < best:
            best, found = abs(share - 0.3), (middle - half, middle + half)
    low, high = np.asarray(found)
    edges = {"x_min": low[0], "x_max": high[0], "y_min": low[1], "y_max": high[1]}
    truth = Truth("floor_patch", {"coefficient": c, **{k: float(v) for k, v in edges.items()}})
    return with_friction(
        scene, truth, random, patch_rolling=c, patch_ramp=ramp, **{f"patch_{k}": float(v) for k, v in edges.items()}
    )


def caster_realignment(scene: Scene, random: Draw) -> Scene:
    world = scene.world
    swivel = world.mass * size("caster_realignment", "swivel", random)
    scrub = swivel * size("caster_realignment", "scrub", random)
    torque = swivel * 2 * world.com_x / world.caster_x
    truth = Truth("caster_realignment", {}, {"swivel_torque": torque}, form="by load, and tyres scrub")
    return with_effect(scene, truth, swivel=swivel, scrub=scrub)


def wheel_drag_imbalance(scene: Scene, random: Draw) -> Scene:
    brake, left = scene.world.mass * size("wheel_drag_imbalance", "brake", random), random.random() < 0.5
    values = {"force": brake, "moment": brake * scene.world.half_track * (1 if left else -1)}
    side = "brake_left" if left else "brake_right"
    return with_friction(scene, Truth("wheel_drag_imbalance", values), random, **{side: brake})


def wheel_misalignment(scene: Scene, random: Draw) -> Scene:
    angle = sign(random) * size("wheel_misalignment", "angle", random)
    return with_effect(scene, Truth("wheel_misalignment", {"angle": angle}, form="the whole axle is turned"), toe=angle)


def lateral_slip(scene: Scene, random: Draw) -> Scene:
    c = scene.world.mass * size("lateral_slip", "cornering", random)
    truth = Truth("lateral_slip", {}, {"cornering_stiffness": c}, form="tyres with a relaxation length")
    return with_effect(scene, truth, cornering=c, relaxation=size("lateral_slip", "relaxation", random))


def payload_change(scene: Scene, random: Draw) -> Scene:
    """At a rest or while it moves; put on, or in a third of the seeds taken off."""
    time, mass = scene.drive.time, scene.world.mass * size("payload_change", "mass", random)
    at = float(time[-1] * random.uniform(0.35, 0.65))
    still = rests(time, scene.drive.speeds)
    if random.random() < 0.5 and len(still):
        at = float(time[still[np.argmin(np.abs(time[still] - at))]])
    values = {"time": at, "mass": -mass if random.random() < 1 / 3 else mass}
    values |= {name: size("payload_change", name, random) for name in "xy"}
    world = scene.world
    if values["mass"] < 0:
        values |= {"x": world.com_x, "y": world.com_y}
    truth = Truth("payload_change", values, form="put on over a while")
    changes = {f"load_{k}": v for k, v in values.items()}
    return with_effect(scene, truth, load_ramp=size("payload_change", "ramp", random), **changes)


def load_slosh(scene: Scene, random: Draw) -> Scene:
    mass = scene.world.mass * size("load_slosh", "mass", random)
    frequency, damping = (size("load_slosh", name, random) for name in ("frequency", "damping"))
    truth = Truth("load_slosh", {"mass": mass, "frequency": frequency, "damping": damping}, form="a pendulum")
    length = GRAVITY / (2 * np.pi * frequency) ** 2
    return with_effect(scene, truth, bob_mass=mass, bob_length=length, bob_damping=damping)


def external_push(scene: Scene, random: Draw) -> Scene:
    """A half-sine in half of the seeds, else a rectangle; while the cart moves or rests."""
    force = sign(random) * scene.world.mass * size("external_push", "force", random)
    duration = size("external_push", "duration", random)
    values = {"start": float(scene.drive.time[-1] * random.uniform(0.15, 0.8)), "duration": duration}
    strength = {"force": force, "moment": -force * size("external_push", "lever", random)}
    changes = {f"push_{k}": v for k, v in (values | strength).items()}
    if random.random() < 0.5:
        truth = Truth("external_push", {}, values | {k: 2 / np.pi * v for k, v in strength.items()}, form="half-sine")
        return with_effect(scene, truth, push_half_sine=1.0, **changes)
    return with_effect(scene, Truth("external_push", values | strength, form="rectangle"), **changes)


def with_fault(scene: Scene, random: Draw, name: str, values: dict[str, float], fault: Fault) -> Scene:
    arm = int(random.integers(len(scene.arms)))
    truth = Truth(name, values, arm=scene.arms[arm])
    sensors = replace(scene.sensors, faults={**scene.sensors.faults, arm: fault})
    return replace(scene, sensors=sensors, truths=(*scene.truths, truth))


def force_bias(scene: Scene, random: Draw) -> Scene:
    values = {name: sign(random) * size("force_bias", name, random) for name in ("fx", "fy", "tz")}
    return with_fault(
        scene, random, "force_bias", values, Fault(offset=(values["fx"], values["fy"], 0.0, 0.0, 0.0, values["tz"]))
    )


def force_scale(scene: Scene, random: Draw) -> Scene:
    """Of one arm of two, whose shares wander: else nothing could tell it from other masses and drags."""
    gain = 1 + sign(random) * size("force_scale", "gain", random)
    return with_fault(scene, random, "force_scale", {"gain": gain}, Fault(gain=gain))


def force_misalignment(scene: Scene, random: Draw) -> Scene:
    angle = sign(random) * size("force_misalignment", "angle", random)
    return with_fault(scene, random, "force_misalignment", {"angle": angle}, Fault(angle=angle))


def time_delay(scene: Scene, random: Draw) -> Scene:
    delay = size("time_delay", "delay", random)
    truth = Truth("time_delay", {"delay": delay}, form="a fractional number of samples")
    if scene.drive.held:
        truth = Truth("time_delay", {}, {"delay": delay}, form="of held samples: uncertain by one")
    return replace(scene, sensors=replace(scene.sensors, delay=delay), truths=(*scene.truths, truth))


VOCABULARY: dict[str, Callable[[Scene, Draw], Scene]] = {
    f.__name__: f
    for f in (
        *(viscous_drag, rolling_resistance, stribeck_friction, quadratic_drag, directional_drag, floor_slope),
        *(floor_patch, caster_realignment, wheel_drag_imbalance, wheel_misalignment, lateral_slip, payload_change),
        *(load_slosh, force_bias, force_scale, force_misalignment, time_delay, external_push),
    )
}
