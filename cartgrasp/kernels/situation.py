"""What the kernel of an effect is given, and where it adds.

An effect's file holds one kernel for each thing that it does; `vocabulary.py` calls them:

    wrench(at, own, out)                   adds the wrench in {b} to `out`, with all partials, in 3 rows; in a fourth
                                           the part (kg) of phi's mass that does not follow the cart's u', with
                                           partials by parameters; in two more what of the force along x and y acts
                                           as high as the CoM, with partials by phi and parameters
    memory_rate(at, own, out)              adds the rate of the memory, with partials; a row for each memory
    stiction(at, own, columns) -> n        writes n wrenches (3,) into the first of columns (m, 3), which are 0
    settled(at, own, memory)               writes where the memory comes to rest
    phi_change(time, own, out)             adds to phi (4,) and to its partials (4, q), the two of `out`
"""

from __future__ import annotations

from typing import NamedTuple

from cartgrasp.frames import Array

Twist = tuple[float, float, float]
SWINGING_ROW = 3
"""The row behind those of the wrench: of the mass that does not follow u'."""
HIGH_ROWS = (4, 5)
"""Rows of what of the wrench's force acts at the height of the CoM, not on the floor: it leans on the wheels."""


class KernelSituation(NamedTuple):
    """Time (s); pose_sb (3,); velocity (u, w, r) in {b}; phi (4,); of each wheel x, y and 1 for a caster, 0 for a
    fixed one (n, 3), load (n,) in N and its partials by phi (n, 4); of each pivot of a caster x, y and trail (k, 3);
    the speed (m/s) below which a Coulomb force fades."""

    time: float
    pose: Array
    velocity: Twist
    phi: Array
    wheels: Array
    loads: Array
    carried: Array
    pivots: Array
    smoothing_speed: float


class EffectValues(NamedTuple):
    """The numbers of one effect: memory (k,), parameters (q,), and those that it calls `constants`."""

    memory: Array
    parameters: Array
    constants: Array


class Parts(NamedTuple):
    """Value (n,) and partials: pose and velocity (n, 3), phi (n, 4), memory (n, k), parameters (n, q)."""

    value: Array
    by_pose: Array
    by_velocity: Array
    by_phi: Array
    by_memory: Array
    by_parameters: Array
