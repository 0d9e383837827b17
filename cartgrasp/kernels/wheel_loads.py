"""Static loads of wheels: the least-norm solution of weight and moments (`wheels.py`).

About the wheels' centre, along their principal axes, the equilibrium's rows are orthogonal: a wheel at (a, b) there
carries `g (m / n + a M_a / sum a² + b M_b / sum b²)` of the first moments M. An axis along which the wheels don't
spread carries nothing.
"""

from __future__ import annotations

import math

from cartgrasp.frames import Array

from .jit import compiled, entry

COLLINEARITY_TOLERANCE = 1e-9  # of the largest spread


@compiled
def fill_map(wheels: Array, standing: Array, gravity: float, carried: Array) -> None:
    """`loads = carried @ phi` (n, 4) when only wheels whose `standing` (n,) isn't 0 are on the floor."""
    carried[:] = 0.0
    n, centre_x, centre_y = 0, 0.0, 0.0
    for k in range(len(wheels)):
        if standing[k] != 0.0:
            n += 1
            centre_x += wheels[k, 0]
            centre_y += wheels[k, 1]
    if n == 0:
        return
    centre_x, centre_y = centre_x / n, centre_y / n
    xx = xy = yy = 0.0
    for k in range(len(wheels)):
        if standing[k] != 0.0:
            x, y = wheels[k, 0] - centre_x, wheels[k, 1] - centre_y
            xx, xy, yy = xx + x * x, xy + x * y, yy + y * y
            carried[k, 0] = gravity / n
    angle = 0.5 * math.atan2(2.0 * xy, xx - yy)
    cosine, sine = math.cos(angle), math.sin(angle)
    for axis_x, axis_y in ((cosine, sine), (-sine, cosine)):
        spread = 0.0
        for k in range(len(wheels)):
            if standing[k] != 0.0:
                spread += (axis_x * (wheels[k, 0] - centre_x) + axis_y * (wheels[k, 1] - centre_y)) ** 2
        if spread <= COLLINEARITY_TOLERANCE**2 * max(float(n), xx + yy):
            continue
        for k in range(len(wheels)):
            if standing[k] != 0.0:
                place = axis_x * (wheels[k, 0] - centre_x) + axis_y * (wheels[k, 1] - centre_y)
                share = gravity * place / spread
                carried[k, 0] -= share * (axis_x * centre_x + axis_y * centre_y)
                carried[k, 1] += share * axis_x
                carried[k, 2] += share * axis_y


@compiled
def carry(wheels: Array, phi: Array, gravity: float, found: tuple[Array, Array, Array]) -> None:
    """Into `found`, which is 0 or of the same wheels before: loads (n,) at phi, their map (n, 4), and which wheels
    stand (n,). A wheel can't pull on the floor: one that would stands off it, and the others carry all."""
    loads, carried, standing = found
    is_filled = True  # as long as all stand, the map is the last one
    for k in range(len(wheels)):
        is_filled &= standing[k] == 1.0
    standing[:] = 1.0
    lifts = True
    while lifts:
        if not is_filled:
            fill_map(wheels, standing, gravity, carried)
        lifts = is_filled = False
        for k in range(len(wheels)):
            loads[k] = carried[k, 0] * phi[0] + carried[k, 1] * phi[1] + carried[k, 2] * phi[2]
            if standing[k] != 0.0 and loads[k] < 0.0:
                standing[k], lifts = 0.0, True


@entry
def stacked_loads(wheels: Array, gravity: float, phis: Array, found: tuple[Array, Array, Array]) -> None:
    """Writes the loads for each of `phis` (b, 4) into `found`: loads (b, n), their map (b, n, 4), and which wheels
    stand (b, n)."""
    for i in range(len(phis)):
        carry(wheels, phis[i], gravity, (found[0][i], found[1][i], found[2][i]))
