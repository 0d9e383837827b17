"""Logs of motions that are written down, for the tests of what explains a discrepancy."""

import numpy as np

from cartgrasp.logs import ArmLog, RunLog


def straight(acceleration=0.5, duration=4.0, mass=20.0, step=0.01, speed=0.0):
    """A log without noise of a cart that a constant force pushes along x, at a speed first; no drag."""
    time = np.arange(0, duration, step)
    zero = np.zeros_like(time)
    wrench = np.column_stack([np.full_like(time, mass * acceleration), zero, zero, zero, zero, zero])
    pose = np.column_stack([speed * time + acceleration * time**2 / 2, zero, zero])
    velocity = np.column_stack([speed + acceleration * time, zero, zero])
    return RunLog(time, pose, velocity, {"arm": ArmLog(np.tile([-0.3, 0.0, 1.0], (len(time), 1)), wrench)})


def circles(angle=0.0, compliance=0.0, seed=0, mass=24.0, com_x=0.28):
    """A log of a cart that goes round in wide circles, forward and back, on wheels at an angle that creep by
    `compliance` (rad/N) under the force that keeps them on the circle; hands give what the rigid body needs, along
    {b}'s x."""
    random, fine = np.random.default_rng(seed), 0.0005
    time = np.arange(0, 20, fine)
    speed, turn = 0.6 * np.sin(0.5 * time), 0.5 * np.cos(0.3 * time)
    heading = np.sin(0.3 * time) * 0.5 / 0.3
    forward = mass * (np.gradient(speed, time) - com_x * turn**2) / np.cos(angle)  # along {b}'s x
    side = -mass * (speed * turn + com_x * np.gradient(turn, time)) - forward * np.sin(angle)
    creep = compliance * np.abs(speed) * side
    towards = heading + angle
    velocity = np.column_stack(
        [speed * np.cos(towards) - creep * np.sin(towards), speed * np.sin(towards) + creep * np.cos(towards), turn]
    )
    pose = np.cumsum(velocity, axis=0) * fine
    pose[:, 2] = heading
    moment = (2.2 + mass * com_x**2) * np.gradient(turn, time) + mass * com_x * speed * turn
    rows = slice(None, None, 20)
    wrench = np.zeros((len(time[rows]), 6))
    wrench[:, 0], wrench[:, 5] = forward[rows], moment[rows]
    noisy = pose[rows] + 0.0005 * random.standard_normal(pose[rows].shape)
    measured = velocity[rows] + 0.005 * random.standard_normal(pose[rows].shape)
    contact = np.tile([0.0, 0.0, 1.0], (len(wrench), 1))
    return RunLog(time[rows], noisy, measured, {"arm": ArmLog(contact, wrench)})
