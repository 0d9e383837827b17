"""The motion of a log, as a smoother leaves it: the most likely states, and what is known of their errors."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from cartgrasp.frames import Array

from .block_tridiagonal import BlockTridiagonal
from .pose_colour import SlowNoise


@dataclass(frozen=True)
class SmoothMotion:
    """At the rows of a log: pose (n, 3), nu (n, f), nu' (n, f), and the information about `(pose, nu, nu')` that the
    measurements hold (at every row, where these are `paired`), with what of it they tell row by row, `measured`
    (n, d, d). `linked` (n - 1,) says which neighbours belong together. Where the pose's noise is `slow` in part, that
    part (n, 3) is behind each state in the information.
    """

    time: Array
    pose: Array
    velocity: Array
    acceleration: Array
    information: BlockTridiagonal
    measured: Array
    linked: np.ndarray
    jerk: Array
    slow: SlowNoise | None = None

    @cached_property
    def velocity_std(self) -> Array:
        """Of nu (f,), in the middle of the log."""
        n, d, _ = self.information.diagonal.shape
        f = self.velocity.shape[1]
        one = np.zeros((n, d, f))
        one[n // 2, 3 : 3 + f] = np.eye(f)
        return np.sqrt(np.diagonal(self.information.factor().solve(one)[n // 2, 3 : 3 + f]))

    def drawn(self, generator: np.random.Generator) -> Array:
        """Errors of `(pose, nu, nu')` (n, d) at every row that the sensors' noise makes."""
        white = generator.standard_normal(self.measured.shape[:2])
        pull = (np.linalg.cholesky(self.measured) @ white[..., None])[..., 0]
        if self.slow is None:
            return self.information.factor().solve(pull)
        slow = self.slow.drawn(generator)[..., None]
        pull[:, :3] += (self.measured[:, :3, :3] @ slow)[..., 0]
        whole = self.information.factor().solve(np.concatenate([pull, pull[:, :3]], axis=1))
        return np.asarray(whole[:, : pull.shape[1]])

    def drawn_rows(self, generator: np.random.Generator) -> Array:
        """The same at these rows."""
        n = len(self.time)
        size = len(self.measured) // n
        return np.asarray(self.drawn(generator)[: size * n].reshape(n, size, -1).mean(axis=1))

    @cached_property
    def noisier(self) -> SmoothMotion:
        """With as much noise of the sensors again."""
        parts = np.split(self.drawn_rows(np.random.default_rng(0)), [3, 3 + self.velocity.shape[1]], axis=1)
        pose, velocity, acceleration = (a + b for a, b in zip(self._parts, parts, strict=True))
        return replace(self, pose=pose, velocity=velocity, acceleration=acceleration)

    @property
    def _parts(self) -> tuple[Array, Array, Array]:
        return self.pose, self.velocity, self.acceleration

    @property
    def speed(self) -> Array:
        """Of {b}'s origin (n,), whatever way it goes."""
        return np.abs(self.velocity[:, 0]) if self.velocity.shape[1] < 3 else np.hypot(*self.velocity[:, :2].T)

    def paired(self) -> SmoothMotion:
        """Means of two rows each."""
        n = len(self.time) // 2
        columns = (self.time, self.pose, self.velocity, self.acceleration)
        time, pose, velocity, acceleration = ((c[: 2 * n : 2] + c[1 : 2 * n : 2]) / 2 for c in columns)
        whole, between = self.linked[: 2 * n - 1 : 2], self.linked[1 : 2 * n - 2 : 2]
        linked = whole[:-1] & between & whole[1:]
        rest = linked, self.jerk[: 2 * n - 2 : 2], self.slow
        return SmoothMotion(time, pose, velocity, acceleration, self.information, self.measured, *rest)

    @property
    def state(self) -> Array:
        return np.hstack(self._parts)
