"""What a log holds: rates, gaps, noise, how far and how hard the cart went, and the largest forces."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cartgrasp.frames import Array, unwrapped
from cartgrasp.logs import RunLog

from ..log_noise.log_noise import noise_floor
from ..weak_form.motion import Motion


@dataclass(frozen=True)
class SensorRows:
    """Statistics of one sensor: how often whole rows of it come (Hz), the share of the log's rows without, its longest
    gap (s). Its noise and its largest size are of places (m), velocities (m/s) or forces (N), and of what turns (rad,
    rad/s, N·m). They are None where too few rows tell, and so is the size of poses."""

    where: str
    rate: float | None
    missing: float
    gap: float | None
    noise: tuple[float | None, float | None]
    largest: tuple[float | None, float | None] = (None, None)

    @classmethod
    def of(cls, where: str, time: Array, rows: Array, linear: int, has_size: bool = True) -> SensorRows:
        """Statistics of rows (n, k), of which the first `linear` columns are linear and the others turn."""
        whole = np.isfinite(rows).all(axis=1)
        steps, seen = np.diff(time[whole]), rows[whole]
        parts = seen[:, :linear], seen[:, linear:]
        return cls(
            where,
            float(1 / np.median(steps)) if len(steps) else None,
            float(1 - whole.mean()),
            float(steps.max()) if len(steps) else None,
            (_noise(parts[0]), _noise(parts[1])),
            (_size(parts[0]), _size(parts[1])) if has_size else (None, None),
        )


@dataclass(frozen=True)
class Overview:
    """Rows, span (s) and rate (Hz); arms; how far {b}'s origin went (m) and turned (rad, to and fro), how fast (m/s)
    and how hard it was accelerated at most (m/s²); each sensor's rows."""

    rows: int
    span: float
    rate: float | None
    arms: tuple[str, ...]
    travelled: float
    turned: float
    fastest: float
    hardest: float
    sensors: tuple[SensorRows, ...]

    @classmethod
    def of(cls, log: RunLog, motions: Sequence[Motion]) -> Overview:
        """The overview of a log, with the motions of its parts."""
        pose = np.column_stack([log.pose[:, :2], unwrapped(log.pose[:, 2])])
        sensors = {"pose": (pose, 2)} | ({} if log.velocity is None else {"velocity": (log.velocity, 2)})
        sensors |= {name: (arm.wrench, 3) for name, arm in log.arms.items()}
        return cls(
            rows=len(log),
            span=log.duration,
            rate=float(1 / np.median(np.diff(log.time))) if len(log) > 1 else None,
            arms=tuple(log.arms),
            travelled=sum(float(motion.way[-1]) for motion in motions),
            turned=sum(float(np.abs(np.diff(motion.pose[:, 2])).sum()) for motion in motions),
            fastest=_largest([motion.speed[motion.seen] for motion in motions]),
            hardest=_largest([np.hypot(*one.twists.smooth_acceleration[one.seen, :2].T) for one in motions]),
            sensors=tuple(SensorRows.of(k, log.time, *rows, has_size=k != "pose") for k, rows in sensors.items()),
        )


def _noise(columns: Array) -> float | None:
    """Noise of the loudest column (n, k); None where none varies, as where no sensor measured."""
    live = [column for column in columns.T if len(column) and np.ptp(column) > 0.0]
    return max(map(noise_floor, live), default=None)


def _size(columns: Array) -> float | None:
    return float(np.linalg.norm(columns, axis=1).max()) if len(columns) else None


def _largest(parts: Sequence[Array]) -> float:
    return max((float(part.max()) for part in parts if len(part)), default=0.0)
