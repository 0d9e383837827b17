"""What is taken for likely before a log is seen: the one table of odds and sizes.

Odds are how many of a hundred first recordings of a robot have the fault, as far as reports on public forums let one
guess. A factor of two here moves a probability from 0.90 to 0.82 or 0.95: what is told hardly hangs on them, as
evidence is in exponents of the number of rows.
"""

from __future__ import annotations

from typing import NamedTuple


class Units(NamedTuple):
    """Of two quantities that come from one device: their names, what recorded numbers are multiplied by to be SI, and
    the probability that they are these."""

    names: tuple[str, str]
    factors: tuple[float, float]
    prior: float


ODDS = {"lag": 0.2, "scale": 0.1, "repeated": 0.05, "offset": 0.01}
"""Against a sound sensor."""

LEAST_LAG = 0.002
"""s: what clocks of one machine differ by; beside it, half a row, as nobody says which instant a row is of."""
LAG_WRONG = 0.05
"""s: of lags that there are, by filters, buses and buffers."""
SOUND_GAIN = 0.005
"""Of log gain: velocities and poses that come from one calibrated device."""
GAIN_WRONG = 0.1
"""Of log gain: wheels that are worn, loaded or mistaken for others."""

FAULTS = {
    "pose": {"degrees": 0.01, "reversed": 0.01, "swapped": 0.01, "quarter turn": 0.01, "turned": 0.005},
    "velocity": {"in the cart's frame": 0.02, "swapped": 0.005, "reversed": 0.005, "y reversed": 0.005},
    "yaw_rate": {"reversed": 0.01},
}
"""Probability of each way in which a sensor is read wrongly."""
MISALIGNED = 0.06
"""rad: of a tracked frame that somebody aligned with the cart, and of wheels that are not square to it."""
ANY_GAIN = 3.0
"""Of log gain, where nothing is said of units yet."""
TRUEST = 0.01
"""Share of a motion that no sensor tells better: wheels that slip, frames that bend, clocks that jitter."""

MOUNTINGS = {
    "reaction": 0.01,
    "z down": 0.005,
    "half turn about z": 0.005,
    "half turn about y": 0.002,
    "quarter turn about z": 0.008,
    "swapped, z down": 0.004,
    "swapped": 0.003,
    "fx reversed": 0.003,
    "fy reversed": 0.003,
    "tz reversed": 0.004,
    "other turns": 0.01,
    "other turns, reaction": 0.005,
    "world": 0.01,
}
"""Probability of each way in which a force sensor's axes are mistaken; several ways of one name share it."""
UNITS = (
    Units(("N", "N·m"), (1.0, 1.0), 0.926),
    Units(("N", "N·cm"), (1.0, 0.01), 0.01),
    Units(("N", "N·mm"), (1.0, 0.001), 0.01),
    Units(("lbf", "lbf·ft"), (4.4482216, 1.3558179), 0.01),
    Units(("lbf", "lbf·in"), (4.4482216, 0.1129848), 0.005),
    Units(("lbf", "N·m"), (4.4482216, 1.0), 0.005),
    Units(("kgf", "kgf·m"), (9.80665, 9.80665), 0.01),
    Units(("kgf", "kgf·cm"), (9.80665, 0.0980665), 0.004),
    Units(("kgf", "N·m"), (9.80665, 1.0), 0.006),
    Units(("kN", "kN·m"), (1000.0, 1000.0), 0.004),
    Units(("kN", "N·m"), (1000.0, 1.0), 0.002),
    Units(("mN", "mN·m"), (0.001, 0.001), 0.004),
    Units(("gf", "gf·cm"), (0.00980665, 9.80665e-05), 0.004),
)
"""Of forces and moments: what each recorded number times is N and N·m, and the probability."""
EVERY_ARM = 0.7
"""Share of the faults that all arms have, as one hand set them all up; the rest is of one arm."""
MASS_SPREAD = 0.5
"""Of the log of a file's mass about the true one: two in three guesses are within a factor of 1.65, 19 in 20 of 2.7."""
INERTIA_SPREAD = 0.7
"""Of the log of a file's yaw inertia, beside what the mass is off by."""
MODEL = 0.1
"""Share of the accelerations' size that no cart model explains."""

SPEED, SPEED_SPREAD = 0.5, 1.6
"""m/s at which pushed carts roll, and the spread of its log: one in twenty is under 2 cm/s or over 12 m/s."""
ROW, ROW_SPREAD = 0.02, 2.0
"""s between rows, and the spread of its log: one in twenty is under 0.4 ms or over 1 s."""
SAME_GAIN = 0.1
"""Of log gain: of sensors of one unit."""
TIMES = (
    Units(("s", ""), (1.0, 1.0), 0.975),
    Units(("ms", ""), (1e-3, 1.0), 0.015),
    Units(("µs", ""), (1e-6, 1.0), 0.005),
    Units(("ns", ""), (1e-9, 1.0), 0.005),
)
"""Of times (alone)."""
LENGTHS = (
    Units(("m", "m/s"), (1.0, 1.0), 0.93),
    Units(("mm", "m/s"), (0.001, 1.0), 0.01),
    Units(("mm", "mm/s"), (0.001, 0.001), 0.02),
    Units(("cm", "m/s"), (0.01, 1.0), 0.005),
    Units(("cm", "cm/s"), (0.01, 0.01), 0.005),
    Units(("ft", "ft/s"), (0.3048, 0.3048), 0.005),
    Units(("m", "mm/s"), (1.0, 0.001), 0.01),
    Units(("m", "cm/s"), (1.0, 0.01), 0.005),
    Units(("m", "km/h"), (1.0, 0.2777777777777778), 0.01),
)
"""Of places and velocities: what each recorded number times is m and m/s, and the probability."""
ANGLES = (
    Units(("rad", "rad/s"), (1.0, 1.0), 0.965),
    Units(("deg", "rad/s"), (0.017453293, 1.0), 0.01),
    Units(("rad", "deg/s"), (1.0, 0.017453293), 0.015),
    Units(("deg", "deg/s"), (0.017453293, 0.017453293), 0.01),
)
"""Of headings and yaw rates."""

SHORTEST_WAVE, LONGEST_WAVE = 0.1, 4.0
"""m rolled: once round wheels of 16 mm to 64 cm."""
CONTACT_UNITS = (("m", 1.0, 0.98), ("cm", 0.01, 0.01), ("mm", 0.001, 0.01))
"""Of contact points: what recorded numbers are multiplied by, and the probability."""
REACH, REACH_SPREAD = 1.0, 0.8
"""m from {b}'s origin, on the floor, at which carts are held, and the spread of its log: from 20 cm to 5 m."""
