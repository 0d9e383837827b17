"""Noise that no formula made: what a real force/torque sensor said while nobody pushed.

The track is no part of the repository: it lies in the shared folder beside it, and without it these logs are left out.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from .scenes import Roughness, Scene
from .sizes import ROUGH

TRACK = Path(__file__).parents[3] / "shared" / "data" / "real" / "sensor_track" / "turning_wheel.csv"
"""Columns t (s), angle (deg), fx, fy, fz (N), mx, my, mz (N·m); 13 turns of a wheel."""


def sensor_track(scene: Scene, random: np.random.Generator) -> Scene:
    """In place of noise; each arm begins elsewhere in the track."""
    scale = float(random.uniform(*ROUGH["sensor_track"]["scale"]))
    track = scale * track_noise(scene.drive.time, scene.drive.shares.shape[1], random)
    force, moment = track[..., :3].std(), track[..., 3:].std()
    sensors = replace(scene.sensors, track=track, force_noise=float(force), moment_noise=float(moment), colour=0.0)
    return replace(scene, sensors=sensors, roughness=(*scene.roughness, Roughness("sensor_track", {"scale": scale})))


def track_noise(time: np.ndarray, k: int, random: np.random.Generator) -> np.ndarray:
    """(n, k, 6), forth and back through the track. Its offset is taken off: it would be a `force_bias`."""
    table = np.loadtxt(TRACK, delimiter=",", skiprows=1)
    at, values = table[:, 0] - table[0, 0], table[:, 2:] - table[:, 2:].mean(axis=0)
    noise, length = np.empty((len(time), k, 6)), at[-1]
    for arm in range(k):
        since = (time - time[0] + random.uniform(0.0, 2.0 * length)) % (2.0 * length)
        place = np.where(since < length, since, 2.0 * length - since)
        noise[:, arm] = np.column_stack([np.interp(place, at, column) for column in values.T])
    return noise
