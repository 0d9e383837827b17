"""Draws what each effect does to a run: `python docs/effect_pictures.py` all, the build of the pages what is missing.

A cart of 24 kg is pushed, turned, and pulled back by one hand with the same wrenches, without the effect and with it.
Its sensors have no noise.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import cartgrasp as cg
from cartgrasp import effects
from cartgrasp.simulation import ModelPlant, SensorNoise, Sensors
from cartgrasp.view.plots import BLUE, VERMILLION, house_style

FOLDER = Path(__file__).parent / "images" / "effects"
PERIOD, DURATION = 0.01, 12.0
HAND = (-0.25, 0.15, 1.0)
WHEELS = (
    cg.Wheel("fixed", 0.0, 0.27),
    cg.Wheel("fixed", 0.0, -0.27),
    cg.Wheel("caster", 0.72, 0.2, trail=0.045),
    cg.Wheel("caster", 0.72, -0.2, trail=0.045),
)
CART = cg.CartModel(cg.Inertia(24.0, (0.3, 0.0), 2.0), effects=(effects.ViscousDrag(3.0, 1.2),), wheels=WHEELS)
BARE = cg.CartModel(CART.inertia, wheels=WHEELS)
EXACT = SensorNoise(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Run:
    """What sensors record: times (n,), poses (n, 3), speeds along and across (n, 2), wrenches (n, 6) in {a}."""

    time: np.ndarray
    pose: np.ndarray
    speed: np.ndarray
    wrench: np.ndarray


def wrench_a(time: float) -> np.ndarray:
    """Push, keep rolling with two turns, pull back until it has rolled backwards, let go."""
    forward = np.select([time < 2.0, time < 5.5, time < 8.5, time < 9.0], [14.0, 3.0, -14.0, 0.0], 4.0)
    turn = np.select([time < 2.5, time < 3.3, time < 4.6, time < 5.4], [0.0, 4.0, 0.0, -4.0], 0.0)
    return np.array([forward, 0.0, 0.0, 0.0, 0.0, turn + HAND[1] * forward])


def run(cart: cg.CartModel) -> Run:
    """Pushed by the wrenches of `wrench_a`."""
    plant, sensors, rows = ModelPlant(cart), Sensors(cart, EXACT), []
    for k in range(round(DURATION / PERIOD)):
        given = cg.ContactWrenches({"hand": wrench_a(k * PERIOD)}, {"hand": np.array(HAND)})
        seen = sensors.motion(plant.time, plant.motion)
        felt = sensors.wrenches(plant.time, given, plant.acceleration(given))
        heading, (vx, vy) = seen.pose[2], seen.velocity[:2]
        along = np.cos(heading) * vx + np.sin(heading) * vy, np.cos(heading) * vy - np.sin(heading) * vx
        rows.append((seen.time, seen.pose, along, felt.wrenches["hand"]))
        plant.step(given, PERIOD)
    return Run(*(np.array(column) for column in zip(*rows, strict=True)))


# --- what is drawn ----------------------------------------------------------------------------------------------


def path(axes: Axes, of: Run, **style: object) -> None:
    axes.plot(of.pose[:, 0], of.pose[:, 1], **style)
    axes.set(xlabel="x (m)", ylabel="y (m)")


def speed(axes: Axes, of: Run, **style: object) -> None:
    axes.plot(of.time, of.speed[:, 0], **style)
    axes.set(xlabel="Time (s)", ylabel="Forward speed (m/s)")


def acceleration(axes: Axes, of: Run, **style: object) -> None:
    axes.plot(of.time, np.gradient(of.speed[:, 0], of.time), **style)
    axes.set(xlabel="Time (s)", ylabel="Acceleration (m/s²)")


def sideways(axes: Axes, of: Run, **style: object) -> None:
    axes.plot(of.time, of.pose[:, 1], **style)
    axes.set(xlabel="Time (s)", ylabel="y (m)")


def across(axes: Axes, of: Run, **style: object) -> None:
    axes.plot(of.time, of.speed[:, 1], **style)
    axes.set(xlabel="Time (s)", ylabel="Speed across (m/s)")


def heading(axes: Axes, of: Run, **style: object) -> None:
    axes.plot(of.time, of.pose[:, 2], **style)
    axes.set(xlabel="Time (s)", ylabel="Heading (rad)")


def force(axes: Axes, of: Run, **style: object) -> None:
    axes.plot(of.time, of.wrench[:, 0], **style)
    axes.set(xlabel="Time (s)", ylabel="Recorded fx (N)")


def side_force(axes: Axes, of: Run, **style: object) -> None:
    axes.plot(of.time, of.wrench[:, 1], **style)
    axes.set(xlabel="Time (s)", ylabel="Recorded fy (N)")


def moment(axes: Axes, of: Run, **style: object) -> None:
    axes.plot(of.time, of.wrench[:, 5], **style)
    axes.set(xlabel="Time (s)", ylabel="Recorded tz (N·m)")


Drawn = tuple[effects.Effect, Callable[..., None], Callable[..., None]]
LAW = effects.LearnedForce("forward_force", "travelled_distance", period=0.525, amplitudes=(5.0, 0.0))
SHOWN: dict[str, Drawn] = {
    "viscous_drag": (effects.ViscousDrag(3.0, 1.2), path, speed),
    "rolling_resistance": (effects.RollingResistance(0.015), path, speed),
    "stribeck_friction": (effects.StribeckFriction(8.0, 0.1), speed, acceleration),
    "quadratic_drag": (effects.QuadraticDrag(6.0), path, speed),
    "directional_drag": (effects.DirectionalDrag(0.0, 6.0), path, speed),
    "floor_slope": (effects.FloorSlope(0.01, 0.01), path, speed),
    "floor_patch": (effects.FloorPatch(x_min=2.0, x_max=3.0, y_min=-1.0, y_max=3.0, coefficient=0.04), path, speed),
    "caster_realignment": (effects.CasterRealignment(0.3), path, speed),
    "wheel_drag_imbalance": (effects.WheelDragImbalance(3.0, 0.6), path, heading),
    "wheel_misalignment": (effects.WheelMisalignment(0.05), path, across),
    "lateral_slip": (effects.LateralSlip(100.0), path, sideways),
    "payload_change": (effects.PayloadChange(time=4.0, mass=15.0, x=0.4, y=0.0), path, speed),
    "load_slosh": (effects.LoadSlosh(mass=10.0, frequency=0.8, damping=0.05), speed, acceleration),
    "force_bias": (effects.ForceBias(3.0, 1.0, 0.8), force, moment),
    "force_scale": (effects.ForceScale(1.2), force, moment),
    "force_misalignment": (effects.ForceMisalignment(0.2), force, side_force),
    "time_delay": (effects.TimeDelay(0.15), force, moment),
    "contact_offset": (effects.ContactOffset(0.0, 0.08), force, moment),
    "tool_inertia": (effects.ToolInertia(4.0, 0.0, 0.1, 0.0), force, moment),
    "pose_offset": (effects.PoseOffset(-0.3, 0.2, 0.1), path, across),
    "external_push": (effects.ExternalPush(start=6.0, duration=0.6, force=40.0, moment=4.0), path, speed),
    "end_stop": (effects.EndStop(position=2.6, restitution=0.5), path, speed),
    "learned_force": (LAW, path, speed),
}


def draw(name: str, file: Path) -> Path:
    """The picture of an effect."""
    effect, *panels = SHOWN[name]
    without = run(BARE if name == "viscous_drag" else CART)
    extended = run((BARE if name == "viscous_drag" else CART).with_effect(effect))
    with house_style():
        figure = Figure(figsize=(6.4, 2.0), layout="constrained")
        for axes, panel in zip(figure.subplots(1, 2), panels, strict=True):
            panel(axes, without, color=BLUE, label="without")
            panel(axes, extended, color=VERMILLION, label=f"with {name}", linestyle="--")
        figure.legend(*axes.get_legend_handles_labels(), loc="outside upper center", ncols=2)
        file.parent.mkdir(parents=True, exist_ok=True)
        figure.savefig(file, dpi=110, metadata={"Software": None})
    return file


def draw_missing() -> None:
    for name in SHOWN:
        if not (file := FOLDER / f"{name}.png").exists():
            draw(name, file)


if __name__ == "__main__":
    for name in sys.argv[1:] or SHOWN:
        print("drawn:", draw(name, FOLDER / f"{name}.png").name)
