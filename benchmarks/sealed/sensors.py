"""From what happened to what is recorded: late, slow, turned, scaled and offset wrenches, late and scaled velocities,
then noise on everything, and steps of encoders."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from .driver import LAG, Drive
from .world import THETA, R, U, W, X

OFF = 0.05, -0.04
"""m: of a pose that is off."""


@dataclass(frozen=True)
class Fault:
    """Of one arm's sensor."""

    angle: float = 0.0  # rad, of its axes about z
    gain: float = 1.0
    offset: tuple[float, ...] = (0.0,) * 6


@dataclass(frozen=True)
class Sensors:
    faults: dict[int, Fault] = field(default_factory=dict)
    beside: dict[int, tuple[float, float, float]] = field(default_factory=dict)  # m, of hands from where logs have them
    tools: dict[int, tuple[float, float, float, float]] = field(default_factory=dict)  # kg, and m from the contact
    tracked: tuple[float, float, float] = (0.0, 0.0, 0.0)  # m and rad, of the frame of which poses are, in {b}
    delay: float = 0.0  # s
    force_noise: float = 3.0
    moment_noise: float = 0.2
    pose_noise: float = 5e-4
    speed_noise: float | None = 5e-3  # none: speeds are not recorded
    colour: float = 0.0  # s, correlation time of force noise
    pose_colour: float = 0.0  # s
    speed_colour: float = 0.0  # s
    lost: float = 0.0  # share of the rows
    off: int = 0  # poses that are far from where the cart is
    lag: float = 0.0  # s, time constant with which force sensors follow
    speed_delay: float = 0.0  # s, against poses
    speed_gain: float = 1.0
    steps: tuple[float, float] = (0.0, 0.0)  # m and rad, of poses; 0: none
    along_x_only: bool = False  # what is not along {s}'s x is taken as known, without noise
    track: np.ndarray | None = field(default=None, compare=False)  # (n, k, 6), in place of noise of wrenches


def wrenches_at(asked: np.ndarray, drive: Drive, present: np.ndarray, told: np.ndarray) -> np.ndarray:
    """True wrenches (n, k, 6) at other instants (n,); before the first they are those of the first."""
    i = np.clip(np.searchsorted(drive.time, asked, side="right") - 1, 0, None)
    if drive.held:
        return told[i]
    since = np.maximum(asked - drive.time[i], 0.0)
    return told[i] + (present[i] - told[i]) * np.exp(-since / LAG)[:, None, None]


def lagged_at(asked: np.ndarray, drive: Drive, present: np.ndarray, told: np.ndarray, lag: float) -> np.ndarray:
    """As `wrenches_at`, through a first-order lag: exact, as wrenches follow by an exponential too."""
    quick = np.zeros_like(told) if drive.held else (present - told) / (1.0 - lag / LAG)
    slow = np.empty_like(told)
    seen = present[0]
    for i, step in enumerate(np.append(np.diff(drive.time), 0.0)):
        slow[i] = seen - told[i] - quick[i]
        seen = told[i] + quick[i] * np.exp(-step / LAG) + slow[i] * np.exp(-step / lag)
    i = np.clip(np.searchsorted(drive.time, asked, side="right") - 1, 0, None)
    since = np.maximum(asked - drive.time[i], 0.0)[:, None, None]
    return told[i] + quick[i] * np.exp(-since / LAG) + slow[i] * np.exp(-since / lag)


def noiseless(sensors: Sensors, drive: Drive, present: np.ndarray, told: np.ndarray) -> np.ndarray:
    """What faulty sensors without noise record, (n, k, 6)."""
    asked = drive.time - sensors.delay
    if sensors.lag:
        recorded = lagged_at(asked, drive, present, told, sensors.lag)
    else:
        recorded = wrenches_at(asked, drive, present, told).copy()
    for arm, fault in sensors.faults.items():
        cosine, sine = np.cos(fault.angle), np.sin(fault.angle)
        for x, y in ((0, 1), (3, 4)):
            fx, fy = recorded[:, arm, x].copy(), recorded[:, arm, y].copy()
            recorded[:, arm, x], recorded[:, arm, y] = cosine * fx + sine * fy, cosine * fy - sine * fx
        recorded[:, arm] = fault.gain * recorded[:, arm] + np.asarray(fault.offset)
    return recorded


def noise(shape: tuple[int, ...], time: np.ndarray, colour: float, random: np.random.Generator) -> np.ndarray:
    """Of unit variance along the first axis: white, or first-order autoregressive."""
    white = random.standard_normal(shape)
    if not colour:
        return white
    keep = np.exp(-np.diff(time) / colour)
    for i, share in enumerate(keep):
        white[i + 1] = share * white[i] + np.sqrt(1 - share**2) * white[i + 1]
    return white


def record(
    sensors: Sensors, drive: Drive, states: np.ndarray, wrenches: np.ndarray, random: np.random.Generator
) -> tuple[list[str], np.ndarray]:
    """Header and table of a run log; `wrenches` are those of `noiseless`."""
    n, k = drive.shares.shape
    measured = np.array([1.0, 0.0, 0.0]) if sensors.along_x_only else np.ones(3)
    error = measured * noise((n, 3), drive.time, sensors.pose_colour, random)
    pose = stepped(states[:, X : THETA + 1] + sensors.pose_noise * error, sensors.steps)
    pose[_some(n, sensors.off, random), :2] += OFF
    header, columns = ["t", "x", "y", "theta"], [drive.time[:, None], pose]
    if sensors.speed_noise is not None:
        error = measured * noise((n, 3), drive.time, sensors.speed_colour, random)
        header += ["vx", "vy", "omega"]
        columns.append(velocities(sensors, drive.time, states) + sensors.speed_noise * error)
    size = np.repeat([sensors.force_noise, sensors.moment_noise], 3)
    if sensors.track is None:
        noisy = wrenches + size * noise(wrenches.shape, drive.time, sensors.colour, random)
    else:
        noisy = wrenches + sensors.track
    for arm in range(k):
        name = ("left", "right")[arm] if k > 1 else "arm"
        header += [f"{name}.{part}" for part in ("px", "py", "pz", "fx", "fy", "fz", "tx", "ty", "tz")]
        columns += [drive.contacts[:, arm] - np.array(sensors.beside.get(arm, (0.0, 0.0, 0.0))), noisy[:, arm]]
    table = np.column_stack(columns)
    return header, np.delete(table, _some(n, round(sensors.lost * n), random), axis=0)


def velocities(sensors: Sensors, time: np.ndarray, states: np.ndarray) -> np.ndarray:
    """(n, 3) in {s}, without noise; before the first instant they are those of the first."""
    cosine, sine = np.cos(states[:, THETA]), np.sin(states[:, THETA])
    u, w, r = states[:, U], states[:, W], states[:, R]
    velocity = np.column_stack([cosine * u - sine * w, sine * u + cosine * w, r])
    if sensors.speed_delay:
        velocity = np.column_stack([np.interp(time - sensors.speed_delay, time, column) for column in velocity.T])
    return sensors.speed_gain * velocity


def stepped(pose: np.ndarray, steps: tuple[float, float]) -> np.ndarray:
    """Rounded to whole steps of length and of angle."""
    sizes = np.array([steps[0], steps[0], steps[1]])
    return np.where(sizes > 0, np.round(pose / np.where(sizes > 0, sizes, 1.0)) * sizes, pose)


def _some(n: int, count: int, random: np.random.Generator) -> np.ndarray:
    """Of n rows; none without a draw, so that what is drawn next is what it would have been."""
    return random.choice(n, count, replace=False) if count else np.zeros(0, dtype=int)


def csv_text(header: list[str], table: np.ndarray) -> str:
    rows = (",".join(format(v, ".7g") for v in row) for row in table.tolist())
    return "\n".join([",".join(header), *rows]) + "\n"
