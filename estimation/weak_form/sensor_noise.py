"""White noise of a log's sensors, read off third differences and the steps in which values come."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cartgrasp.frames import Array
from cartgrasp.logs import RunLog

from ..log_noise.log_noise import MIN_POSITION_NOISE, MIN_VELOCITY_NOISE, pose_noise, white_noise
from ..log_noise.sample_step import usual_step
from ..noise import FilterNoise

AVERAGING_TIMES = (0.0, 0.02, 0.05)
"""Durations (s) of blocks over which samples are averaged; over longer ones, motion shows."""


@dataclass(frozen=True)
class MotionNoise:
    """Standard deviations of one sample: of poses (3,) in m, m, rad, and of velocities (3,) where there are any, by the
    density of their noise: many are filtered, or made of poses. Samples of each have a step (s) of their own."""

    pose: Array
    velocity: Array | None
    pose_step: float
    velocity_step: float

    @classmethod
    def of(cls, log: RunLog) -> MotionNoise:
        position, heading = pose_noise(log.pose)
        pose, (pose_step, step) = np.array([position, position, heading]), _steps(log)
        if log.velocity is None or len(log) < 2 or not np.isfinite(log.velocity).any():
            return cls(pose, None, pose_step, step)
        forward, left, yaw = (noise_density(log.time, column) / max(step, 1e-12) ** 0.5 for column in log.velocity.T)
        linear = max(forward, left, MIN_VELOCITY_NOISE)
        return cls(pose, np.array([linear, linear, max(yaw, MIN_VELOCITY_NOISE)]), pose_step, step)

    @classmethod
    def told(cls, noise: FilterNoise, log: RunLog) -> MotionNoise:
        """Noise of the log's sensors as somebody knows it."""
        pose = np.maximum([noise.position, noise.position, noise.heading], MIN_POSITION_NOISE)
        if log.velocity is None or not np.isfinite(log.velocity).any():
            return cls(pose, None, *_steps(log))
        rate = np.maximum([noise.linear_velocity, noise.linear_velocity, noise.yaw_rate], MIN_VELOCITY_NOISE)
        return cls(pose, rate, *_steps(log))

    @property
    def pose_density(self) -> Array:
        """Roots of the densities (3,) of the poses' noise (m/√Hz, rad/√Hz)."""
        return np.asarray(self.pose * self.pose_step**0.5)

    @property
    def density(self) -> tuple[Array, int]:
        """Roots of the densities (3,) of the noise of velocities (m/s/√Hz, rad/s/√Hz), or of poses where there are
        none; and of which derivative of a place it is."""
        return (self.pose_density, 0) if self.velocity is None else (self.velocity * self.velocity_step**0.5, 1)


def _steps(log: RunLog) -> tuple[float, float]:
    """Usual steps (s) of the samples of poses and of velocities; 0 where there are none."""
    known = (np.zeros(0) if of is None else log.time[np.isfinite(of).all(axis=1)] for of in (log.pose, log.velocity))
    pose, velocity = (usual_step(time) for time in known)
    return pose, velocity


def noise_density(time: Array, channel: Array, averaged: Sequence[float] | None = None) -> float:
    """Root of the density (unit/√Hz) of noise as slow as a test function sees it: of means over longer and longer
    blocks (s), the largest. Noise that is filtered, or held from sample to sample, looks quieter from row to row than
    it is."""
    known = np.isfinite(channel)
    present = channel[known]
    if len(present) < 2:
        return 0.0
    step = usual_step(time[known])
    densities = []
    for length in AVERAGING_TIMES if averaged is None else averaged:
        size = max(1, round(length / step))
        count = len(present) // size
        means = present[: count * size].reshape(count, size).mean(axis=1)
        densities.append(white_noise(means) * (size * step) ** 0.5)
    return float(max(densities))
