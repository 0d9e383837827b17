"""What robots do to a log: a hand beside where it believes, a tool that hangs on its sensor, a tracker that follows
another point of the cart. Points of the floor are complex numbers here, turns are factors."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from .driver import Drive
from .scenes import Scene, Truth
from .sensors import Sensors
from .sizes import EFFECTS
from .world import GRAVITY, THETA, R, U, W, X, Y

Draw = np.random.Generator


def _signed(effect: str, name: str, random: Draw) -> float:
    return float(random.choice([-1.0, 1.0]) * random.uniform(*EFFECTS[effect][name]))


def contact_offset(scene: Scene, random: Draw) -> Scene:
    values = {name: _signed("contact_offset", name, random) for name in "xy"}
    arm = int(random.integers(len(scene.arms)))
    sensors = replace(scene.sensors, beside={arm: (values["x"], values["y"], 0.0)})
    truth = Truth("contact_offset", values, form="the hand is where it is, the log is wrong", arm=scene.arms[arm])
    return replace(scene, sensors=sensors, truths=(*scene.truths, truth))


def tool_inertia(scene: Scene, random: Draw) -> Scene:
    mass, height = (float(random.uniform(*EFFECTS["tool_inertia"][name])) for name in ("mass", "z"))
    values = {"mass": mass} | {name: _signed("tool_inertia", name, random) for name in "xy"} | {"z": height}
    arm = int(random.integers(len(scene.arms)))
    sensors = replace(scene.sensors, tools={arm: (mass, values["x"], values["y"], height)})
    told = {name: values[name] for name in ("mass", "x", "y")}
    truth = Truth("tool_inertia", told, form="untared, on a hand that holds fast", arm=scene.arms[arm])
    return replace(scene, sensors=sensors, truths=(*scene.truths, truth))


def pose_offset(scene: Scene, random: Draw) -> Scene:
    ahead, left = (_signed("pose_offset", name, random) for name in "xy")
    turn = _signed("pose_offset", "yaw", random)
    body = -complex(ahead, left) * np.exp(-1j * turn)  # in the tracked frame
    values = {"x": float(body.real), "y": float(body.imag), "yaw": -turn}
    truth = Truth("pose_offset", values, form="markers on the cart")
    sensors = replace(scene.sensors, tracked=(ahead, left, turn))
    return replace(scene, sensors=sensors, truths=(*scene.truths, truth))


ROBOTS: dict[str, Callable[[Scene, Draw], Scene]] = {f.__name__: f for f in (contact_offset, tool_inertia, pose_offset)}


def hanging(sensors: Sensors, drive: Drive, states: np.ndarray, rates: np.ndarray) -> np.ndarray:
    """What tools add to the wrenches that sensors record, (n, k, 6), from velocities and their rates in {b}. Delays and
    other faults are not theirs."""
    found = np.zeros((*drive.shares.shape, 6))
    speed, change = states[:, U] + 1j * states[:, W], rates[:, U] + 1j * rates[:, W]
    turn, turning = states[:, R], rates[:, R]
    for arm, (mass, x, y, z) in sensors.tools.items():
        place = drive.contacts[:, arm, 0] + x + 1j * (drive.contacts[:, arm, 1] + y)
        pull = mass * (change + 1j * turn * speed + (1j * turning - turn**2) * place)
        weight = mass * GRAVITY
        found[:, arm, 0], found[:, arm, 1], found[:, arm, 2] = pull.real, pull.imag, weight
        found[:, arm, 3], found[:, arm, 4] = y * weight - z * pull.imag, z * pull.real - x * weight
        found[:, arm, 5] = (np.conj(complex(x, y)) * pull).imag
    return found


def followed(sensors: Sensors, states: np.ndarray) -> np.ndarray:
    """States (n, SIZE) of the tracked frame: its pose, and its velocity in its own axes."""
    ahead, left, turn = sensors.tracked
    if not (ahead or left or turn):
        return states
    point, found = complex(ahead, left), states.copy()
    place = states[:, X] + 1j * states[:, Y] + point * np.exp(1j * states[:, THETA])
    speed = (states[:, U] + 1j * states[:, W] + 1j * states[:, R] * point) * np.exp(-1j * turn)
    found[:, X], found[:, Y], found[:, THETA] = place.real, place.imag, states[:, THETA] + turn
    found[:, U], found[:, W] = speed.real, speed.imag
    return found
