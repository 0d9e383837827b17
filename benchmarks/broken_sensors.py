"""What sensors do to a log that breaks for a while, or drifts: the same to each log of so many rows."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from cartgrasp.frames import Array, wrap_angle
from cartgrasp.logs import ArmLog, RunLog

Change = Callable[[RunLog], RunLog]


def with_wrenches(log: RunLog, change: Callable[[Array], Array]) -> RunLog:
    """The log with all arms' wrenches (n, 6) changed."""
    return replace(log, arms={name: ArmLog(arm.contact, change(arm.wrench)) for name, arm in log.arms.items()})


def frozen(seconds: float, times: int) -> Change:
    """All force sensors repeat what they told last, to the last bit, a few times."""

    def change(log: RunLog) -> RunLog:
        row = np.arange(len(log))
        for begin in log.time[0] + log.duration * (np.arange(times) + 0.4) / times:
            first = int(np.searchsorted(log.time, begin))
            row[(log.time > begin) & (log.time < begin + seconds)] = first
        return with_wrenches(log, lambda wrench: wrench[row])

    return change


def clipped(share: float) -> Change:
    """Force sensors that go no farther ahead than what they would tell in a share of the rows."""

    def change(log: RunLog) -> RunLog:
        def clip(wrench: Array) -> Array:
            most = float(np.nanquantile(np.abs(wrench[:, 0]), 1.0 - share))
            return np.column_stack([np.clip(wrench[:, 0], -most, most), wrench[:, 1:]])

        return with_wrenches(log, clip)

    return change


def found_elsewhere(size: float, times: int) -> Change:
    """A tracker that loses the cart and finds it so far (m) away, a few times; its velocities go on."""

    def change(log: RunLog) -> RunLog:
        random, pose = np.random.default_rng(len(log)), log.pose.copy()
        for begin in log.time[0] + log.duration * (np.arange(times) + 0.6) / times:
            angle = random.uniform(-np.pi, np.pi)
            pose[log.time > begin, :2] += size * np.array([np.cos(angle), np.sin(angle)])
        return replace(log, pose=pose)

    return change


def drifting(rate: float) -> Change:
    """A heading that leaves the true one at a rate (rad/s)."""

    def change(log: RunLog) -> RunLog:
        heading = wrap_angle(log.pose[:, 2] + rate * (log.time - log.time[0]))
        return replace(log, pose=np.column_stack([log.pose[:, :2], heading]))

    return change


def late(lag: float) -> Change:
    """Wrenches that come late (s)."""

    def change(log: RunLog) -> RunLog:
        def moved(wrench: Array) -> Array:
            return np.column_stack([np.interp(log.time - lag, log.time, column) for column in wrench.T])

        return with_wrenches(log, moved)

    return change


def smoothed(seconds: float) -> Change:
    """Wrenches through a low-pass filter of the first order."""

    def change(log: RunLog) -> RunLog:
        def passed(wrench: Array) -> Array:
            found = wrench.copy()
            for k, gain in enumerate(-np.expm1(-np.diff(log.time) / seconds)):
                found[k + 1] = found[k] + gain * (wrench[k + 1] - found[k])
            return found

        return with_wrenches(log, passed)

    return change


def helped(force: float, seconds: float) -> Change:
    """Somebody else gives a part of what the first arm gave, for a while: no fault of a sensor."""

    def change(log: RunLog) -> RunLog:
        first, begin = next(iter(log.arms), ""), log.time[0] + 0.4 * log.duration
        less = np.outer((log.time > begin) & (log.time < begin + seconds), [force, 0.0, 0.0, 0.0, 0.0, 0.0])
        arms = {k: ArmLog(a.contact, a.wrench - less if k == first else a.wrench) for k, a in log.arms.items()}
        return replace(log, arms=arms)

    return change


def in_millimetres(log: RunLog) -> RunLog:
    return replace(log, pose=log.pose * [1000.0, 1000.0, 1.0])


def standing(log: RunLog) -> RunLog:
    """White noise of 2 mm and 2 mrad, which nobody pushes: no fault either."""
    noise = 0.002 * np.random.default_rng(len(log)).standard_normal((len(log), 3))
    return replace(log, pose=noise, velocity=None, arms={})
