"""How far apart a log's samples usually are.

Clocks jitter, and a table of several sensors has rows in pairs and triples, each a fraction of a millisecond apart.
Then a usual step between two rows says nothing of how many there are in a second.
"""

from __future__ import annotations

import numpy as np

from cartgrasp.frames import Array

STEPS_TOGETHER = 12
"""Steps whose mean is taken: a whole number of periods of one to four sensors, or six, whose rows stand in groups."""


def usual_step(time: Array) -> float:
    """The usual mean of a few steps (s) between samples at times (n,), whatever gaps are among them; 0 of one alone."""
    together = min(STEPS_TOGETHER, len(time) - 1)
    return float(np.median(time[together:] - time[:-together])) / together if together > 0 else 0.0
