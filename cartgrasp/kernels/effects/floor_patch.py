"""`effects/floor_patch.py`: parameters x_min, x_max, y_min, y_max, coefficient; the constant is
`SMOOTHING_LENGTH`."""

from __future__ import annotations

import math

from cartgrasp.frames import Array

from ..casters import heading_rates, settled_headings
from ..jit import compiled
from ..rolling import drag, hold
from ..situation import EffectValues, KernelSituation, Parts
from ..smooth import smooth_step

memory_rate, settled = heading_rates, settled_headings


@compiled
def wrench(at: KernelSituation, own: EffectValues, out: Parts) -> None:
    coefficient = own.parameters[4]
    for wheel in range(len(at.wheels)):
        share, by_edge, swing = _inside(at, own, wheel)
        unit = drag(at, own, wheel, coefficient * share, out)
        along = (-(by_edge[0] + by_edge[1]), -(by_edge[2] + by_edge[3]))
        turned = along[1] * swing[0] - along[0] * swing[1]
        for i in range(3):
            pull = -unit[i] * at.loads[wheel]
            by_share = coefficient * pull
            for k in range(4):
                out.by_parameters[i, k] += by_share * by_edge[k]
            out.by_parameters[i, 4] += share * pull
            out.by_pose[i, 0] += by_share * along[0]
            out.by_pose[i, 1] += by_share * along[1]
            out.by_pose[i, 2] += by_share * turned


@compiled
def stiction(at: KernelSituation, own: EffectValues, columns: Array) -> int:
    for wheel in range(len(at.wheels)):
        share, _, _ = _inside(at, own, wheel)
        hold(at, own, wheel, own.parameters[4] * share * at.loads[wheel], columns)
    return 2 * len(at.wheels)


@compiled
def _inside(
    at: KernelSituation, own: EffectValues, wheel: int
) -> tuple[float, tuple[float, float, float, float], tuple[float, float]]:
    """Share of a wheel inside, its partials by the four edges, and where it is from {b}'s origin, in {s}."""
    cosine, sine = math.cos(at.pose[2]), math.sin(at.pose[2])
    x = cosine * at.wheels[wheel, 0] - sine * at.wheels[wheel, 1]
    y = sine * at.wheels[wheel, 0] + cosine * at.wheels[wheel, 1]
    edges, width = own.parameters, own.constants[0]
    left, left_slope = smooth_step(at.pose[0] + x - edges[0], width)
    right, right_slope = smooth_step(edges[1] - at.pose[0] - x, width)
    low, low_slope = smooth_step(at.pose[1] + y - edges[2], width)
    high, high_slope = smooth_step(edges[3] - at.pose[1] - y, width)
    across, along = left * right, low * high
    by_edge = (-left_slope * right * along, left * right_slope * along)
    by_side = (-across * low_slope * high, across * low * high_slope)
    return across * along, (by_edge[0], by_edge[1], by_side[0], by_side[1]), (x, y)
