"""Motions that are written down, with the wrenches that they take by hand (physics.md)."""

import numpy as np
from scipy.integrate import cumulative_simpson

from cartgrasp.constraints import RollingConstraints
from cartgrasp.effects import ViscousDrag
from cartgrasp.inertia import Inertia
from cartgrasp.logs import ArmLog, RunLog
from cartgrasp.model import CartModel

STEP = 0.01
CONTACT = np.array([-0.3, 0.1, 1.0])
TRUE = (24.0, 0.28, 0.05, 2.2, 3.0, 1.2)
"""Mass (kg), CoM (m), inertia about it (kg·m²), viscous drags (N·s/m, N·m·s)."""


def cart_of(values):
    mass, x, y, inertia, linear, angular = values
    return CartModel(Inertia(mass, (x, y), inertia), effects=(ViscousDrag(linear=linear, angular=angular),))


def weaving(values, duration=16.0, slope=(0.0, 0.0), wobble=0.3):
    """A log without noise of a cart that never rests; `slope`: rise over run of the floor along x and y. Without a
    `wobble` (rad/s) beside, its yaw acceleration is in proportion to its heading."""
    mass, dx, dy, inertia, linear, angular = values
    time = np.arange(0.0, duration, STEP)
    speed, rate = 0.6 + 0.4 * np.sin(0.9 * time), 0.36 * np.cos(0.9 * time)
    turn, bend = (
        0.5 * np.cos(0.7 * time) + wobble * np.sin(1.9 * time),
        -0.35 * np.sin(0.7 * time) + 1.9 * wobble * np.cos(1.9 * time),
    )
    heading = 0.5 / 0.7 * np.sin(0.7 * time) + wobble / 1.9 * (1 - np.cos(1.9 * time))
    velocity = np.column_stack([speed * np.cos(heading), speed * np.sin(heading), turn])
    way = cumulative_simpson(velocity[:, :2], x=time, axis=0, initial=0.0)
    gravity = (
        -9.81
        * mass
        * np.column_stack(
            [
                slope[0] * np.cos(heading) + slope[1] * np.sin(heading),
                slope[1] * np.cos(heading) - slope[0] * np.sin(heading),
            ]
        )
    )
    about_b = inertia + mass * (dx**2 + dy**2)
    forward = mass * (rate - dy * bend - dx * turn**2) + linear * speed - gravity[:, 0]
    moment = about_b * bend + mass * (dx * speed * turn - dy * rate) + angular * turn
    moment -= dx * gravity[:, 1] - dy * gravity[:, 0]
    wrench = np.zeros((len(time), 6))
    wrench[:, 0], wrench[:, 5] = forward, moment + CONTACT[1] * forward
    arm = ArmLog(np.tile(CONTACT, (len(time), 1)), wrench)
    return RunLog(time, np.column_stack([way, heading]), velocity, {"arm": arm}, name="weaving")


def noisy(log, seed, pose=5e-4, velocity=5e-3, force=0.5):
    """The same with white noise (m and rad, m/s and rad/s, N; moments have a twentieth of it)."""
    random = np.random.default_rng(seed)
    each = np.repeat([force, force / 20], 3)
    arms = {
        name: ArmLog(arm.contact, arm.wrench + each * random.standard_normal(arm.wrench.shape))
        for name, arm in log.arms.items()
    }
    return RunLog(
        log.time,
        log.pose + pose * random.standard_normal(log.pose.shape),
        None if log.velocity is None else log.velocity + velocity * random.standard_normal(log.pose.shape),
        arms,
        name=log.name,
    )


RAIL_MASS, RAIL_DRAG = 20.0, 4.0
RAIL = CartModel(
    Inertia(RAIL_MASS, (0.0, 0.0), 1.0),
    RollingConstraints(0.0, no_rotation=True),
    (ViscousDrag(linear=RAIL_DRAG),),
)


def on_rail(duration=40.0, share=0.0, seed=0, mass=RAIL_MASS):
    """A log with little noise of a cart on a rail. Beside what the wrench makes, its speed goes up and down by `share`
    (m/s) in 1.5 to 4 Hz, which no force made."""
    random = np.random.default_rng(seed)
    time = np.arange(0.0, duration, STEP)
    x, speed, rate = 0.6 * time, np.full_like(time, 0.6), np.zeros_like(time)
    for frequency, size in ((0.11, 0.2), (0.23, 0.12), (0.41, 0.1), (0.9, 0.06), (1.7, 0.04)):
        angle, phase = 2 * np.pi * frequency, random.uniform(0, 2 * np.pi)
        speed = speed + size * np.sin(angle * time + phase)
        rate = rate + size * angle * np.cos(angle * time + phase)
        x = x - size / angle * np.cos(angle * time + phase)
    force = mass * rate + RAIL_DRAG * speed
    for frequency in random.uniform(1.5, 4.0, 12):
        angle, phase = 2 * np.pi * frequency, random.uniform(0, 2 * np.pi)
        speed = speed + share * np.sin(angle * time + phase)
        x = x - share / angle * np.cos(angle * time + phase)
    zero, wrench = np.zeros_like(time), np.zeros((len(time), 6))
    wrench[:, 0] = force
    log = RunLog(
        time,
        np.column_stack([x, zero, zero]),
        np.column_stack([speed, zero, zero]),
        {"arm": ArmLog(np.zeros((len(time), 3)), wrench)},
        name="rail",
    )
    return noisy(log, seed, 1e-4, 1e-3, 0.1)
