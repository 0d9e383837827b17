"""Poses that jump: a tracker that lost the cart and found it elsewhere.

A cart that is hit changes its speed; one that was moved in a row goes on as before, so that row alone is unlike those
around it, by more than any acceleration there and back.
"""

from __future__ import annotations

import numpy as np

from cartgrasp.frames import Array
from cartgrasp.logs import RunLog

from .suspicion import Suspicion

HARDEST = {"pose": 100.0, "heading": 200.0}
"""m/s² and rad/s²: no cart is accelerated so hard, not by an impact, for a row there and a row back."""
UNLIKE, USUAL = 10.0, 0.9
"""Times what a tenth of the rows exceed of what noise, coarse steps and rows that repeat do."""
FEWEST = 20
"""Rows."""


def jumps(log: RunLog) -> tuple[Suspicion, ...]:
    """`jumps` of places and headings."""
    told = []
    there = np.isfinite(log.pose).all(axis=1)
    time, pose = log.time[there], log.pose[there]
    if len(time) < FEWEST:
        return ()
    steps = {"pose": np.diff(pose[:, :2], axis=0), "heading": np.diff(np.unwrap(pose[:, 2]))[:, None]}
    for where, step in steps.items():
        size = _beside(step, np.diff(time))
        usual = float(np.quantile(size, USUAL))
        at = np.flatnonzero(size > np.maximum(UNLIKE * usual, HARDEST[where] * np.diff(time) ** 2))
        if len(at):
            most, unit = at[int(np.argmax(size[at]))], {"pose": "m", "heading": "rad"}[where]
            times = "once" if len(at) == 1 else f"{len(at)} times"
            words = (
                f"{where}: jumps {times}, the farthest by {size[most]:.3g} {unit} at t = {time[most + 1]:g} s, and "
                "goes on as before: a tracker that lost the cart; cut the log there"
            )
            told.append(Suspicion("jumps", where, 0.99, float(size[most]), words))
    return tuple(told)


def _beside(step: Array, span: Array) -> Array:
    """How far (n,) steps (n, k) over spans (n,) are from what the two before and the two after would make of them."""
    rate = np.pad(step / span[:, None], ((2, 2), (0, 0)), mode="edge")
    around = np.array([rate[k : k + len(step)] for k in (0, 1, 3, 4)])
    return np.asarray(np.linalg.norm(step - np.median(around, axis=0) * span[:, None], axis=1))
