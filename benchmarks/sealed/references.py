"""Speeds that are asked of the cart: `rich` has starts, stops, reversals and curves both ways, `straight` has none
of the last two."""

from __future__ import annotations

import numpy as np

SPEEDS = (0.1, 0.8)  # m/s
YAW_RATES = (0.2, 0.6)  # rad/s
HOLDS = (1.5, 4.5)  # s
RESTS = (0.8, 1.6)  # s
ACCELERATIONS = (0.35, 0.9)  # m/s²
YAW_ACCELERATION = 1.2  # rad/s²
DURATIONS = {"rich": 60.0, "straight": 30.0}
BENDS = (0, 1, -1, 0, -1, 1)


def speeds(motion: str, time: np.ndarray, jumps: bool, random: np.random.Generator) -> np.ndarray:
    """(n, 4): u, r and their rates. With `jumps` they change in steps, and rates are 0."""
    goal = np.zeros((len(time), 2))
    at, i, sign = 1.0, 0, 1
    while at < time[-1] - 1.0:
        u, r = rich_leg(i, sign, random) if motion == "rich" else (random.uniform(0.2, SPEEDS[1]), 0.0)
        hold = random.uniform(*HOLDS)
        goal[(time >= at) & (time < min(at + hold, time[-1] - 1.0))] = u, r
        at += hold
        if i % 2:
            at += random.uniform(*RESTS)
        if i % 3 == 2:
            sign = -sign
        i += 1
    if jumps:
        return np.column_stack([goal, np.zeros_like(goal)])
    limit = np.array([random.uniform(*ACCELERATIONS), YAW_ACCELERATION])
    path = smoothed(limited(time, goal, limit))
    return np.column_stack([path, np.gradient(path, time, axis=0)])


def rich_leg(i: int, sign: int, random: np.random.Generator) -> tuple[float, float]:
    """Slow and fast in turn, straight and bent in turn; now and then a turn nearly on the spot."""
    low, high = SPEEDS
    u = random.uniform(low, 0.35) if i % 4 == 3 else random.uniform(0.35, high)
    return sign * u, BENDS[i % len(BENDS)] * random.uniform(*YAW_RATES)


def limited(time: np.ndarray, goal: np.ndarray, limit: np.ndarray) -> np.ndarray:
    path, now = np.empty_like(goal), np.zeros(goal.shape[1])
    for i, step in enumerate(np.diff(time, prepend=time[0])):
        now = now + np.clip(goal[i] - now, -limit * step, limit * step)
        path[i] = now
    return path


def smoothed(path: np.ndarray, width: int = 15) -> np.ndarray:
    padded = np.concatenate([np.repeat(path[:1], width, axis=0), path, np.repeat(path[-1:], width, axis=0)])
    kernel = np.ones(width) / width
    return np.column_stack([np.convolve(column, kernel, "same")[width:-width] for column in padded.T])
