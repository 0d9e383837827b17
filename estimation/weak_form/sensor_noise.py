"""White noise of a log's sensors, read off third differences and the steps in which values come."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cartgrasp.frames import Array
from cartgrasp.logs import RunLog

from ..log_noise.log_noise import MIN_POSITION_NOISE, MIN_VELOCITY_NOISE, pose_noise, white_noise
from ..noise import FilterNoise

AVERAGING_TIMES = (0.0, 0.02, 0.05)
"""Durations (s) of blocks over which samples are averaged; over longer ones, motion shows."""


@dataclass(frozen=True)
class MotionNoise:
    """Standard deviations of one sample: of poses (3,) in m, m, rad, and of velocities (3,) where there are any, by the
    density of their noise: many are filtered, or made of poses."""

    pose: Array
    velocity: Array | None

    @classmethod
    def of(cls, log: RunLog) -> MotionNoise:
        position, heading = pose_noise(log.pose)
        pose = np.array([position, position, heading])
        if log.velocity is None or len(log) < 2 or not np.isfinite(log.velocity).any():
            return cls(pose, None)
        root_step = float(np.median(np.diff(log.time))) ** 0.5
        forward, left, yaw = (noise_density(log.time, column) / root_step for column in log.velocity.T)
        linear = max(forward, left, MIN_VELOCITY_NOISE)
        return cls(pose, np.array([linear, linear, max(yaw, MIN_VELOCITY_NOISE)]))

    @classmethod
    def told(cls, noise: FilterNoise, log: RunLog) -> MotionNoise:
        """Noise of the log's sensors as somebody knows it."""
        pose = np.maximum([noise.position, noise.position, noise.heading], MIN_POSITION_NOISE)
        if log.velocity is None or not np.isfinite(log.velocity).any():
            return cls(pose, None)
        rate = np.maximum([noise.linear_velocity, noise.linear_velocity, noise.yaw_rate], MIN_VELOCITY_NOISE)
        return cls(pose, rate)


def noise_density(time: Array, channel: Array, averaged: Sequence[float] | None = None) -> float:
    """Root of the density (unit/√Hz) of noise as slow as a test function sees it: of means over longer and longer
    blocks (s), the largest. Noise that is filtered, or held from sample to sample, looks quieter from row to row than
    it is."""
    known = np.isfinite(channel)
    present = channel[known]
    if len(present) < 2:
        return 0.0
    step = float(np.median(np.diff(time[known])))
    densities = []
    for length in AVERAGING_TIMES if averaged is None else averaged:
        size = max(1, round(length / step))
        count = len(present) // size
        means = present[: count * size].reshape(count, size).mean(axis=1)
        densities.append(white_noise(means) * (size * step) ** 0.5)
    return float(max(densities))
