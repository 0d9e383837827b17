"""A cart on one axle, simulated by hand: it shares no code with the library.

With the CoM at d = (dx, dy) of {b} and the axle through {b}'s origin, Newton and Euler about that origin give

    fx  = m (u' - r' dy - r² dx) + linear u
    tau = (I + m |d|²) r' + m dx u r - m dy u' + angular r.
"""

from __future__ import annotations

from functools import cache

import numpy as np

MASS, DX, DY, INERTIA, LINEAR, ANGULAR = 24.0, 0.30, 0.05, 2.0, 3.0, 1.2
STEP, DURATION, FORCE_NOISE = 0.01, 20.0, 0.3
HANDS = {"left": 0.2, "right": -0.2}
PARTS = ("px", "py", "pz", "fx", "fy", "fz", "tx", "ty", "tz")
HEADER = ("t", "x", "y", "theta", "vx", "vy", "omega", *(f"{hand}.{part}" for hand in HANDS for part in PARTS))


def speeds(t, curves):
    """Forward speed and yaw rate: accelerate, cruise, brake; then weave, or the same straight on."""
    u = np.interp(t, [0, 0.5, 2.1, 5, 6.5, 8], [0, 0, 0.8, 0.8, 0.2, 0.5])
    late = np.maximum(t - 8, 0)
    u = np.where(t > 8, 0.5 + 0.3 * np.sin(2 * np.pi * late / 3), u)
    r = np.where(t > 8, 0.6 * np.sin(2 * np.pi * late / 4), 0.0)
    return u, r * curves


@cache
def pushed_cart(curves=True, seed=0):
    """Table (n, columns) of HEADER, with noise."""
    rng = np.random.default_rng(seed)
    fine = STEP / 20
    t = np.arange(0, DURATION, fine)
    u, r = speeds(t, curves)
    du, dr = np.gradient(u, fine), np.gradient(r, fine)
    theta = np.concatenate([[0], np.cumsum((r[1:] + r[:-1]) / 2) * fine])
    vx, vy = u * np.cos(theta), u * np.sin(theta)
    x, y = (np.concatenate([[0], np.cumsum((v[1:] + v[:-1]) / 2) * fine]) for v in (vx, vy))
    fx = MASS * (du - dr * DY - r**2 * DX) + LINEAR * u
    tau = (INERTIA + MASS * (DX**2 + DY**2)) * dr + MASS * DX * u * r - MASS * DY * du + ANGULAR * r
    keep = slice(0, None, 20)
    table = np.column_stack([t, x, y, theta, vx, vy, r])[keep]
    n = len(table)
    table[:, 1:4] += rng.normal(0, 0.0003, (n, 3))
    table[:, 4:7] += rng.normal(0, 0.003, (n, 3))
    for side in HANDS.values():
        force = (fx / 2 - tau / (2 * side))[keep]  # tau = -sum(py fx)
        hand = np.zeros((n, 9))
        hand[:, :3] = (-0.25, side, 1.0)
        hand[:, 3] = force
        hand[:, 3:6] += rng.normal(0, FORCE_NOISE, (n, 3))
        hand[:, 6:] += rng.normal(0, FORCE_NOISE / 20, (n, 3))
        table = np.column_stack([table, hand])
    table.flags.writeable = False  # the next one who asks gets the same
    return table


def as_csv(table, header=HEADER):
    cells = (",".join("" if np.isnan(v) else repr(v) for v in row) for row in table.tolist())
    return "\n".join([",".join(header), *cells]) + "\n"
