"""`effects/wheel_drag_imbalance.py`: parameters force, moment."""

from __future__ import annotations

from cartgrasp.frames import Array

from ..jit import compiled
from ..situation import EffectValues, KernelSituation, Parts
from ..smooth import smooth_sign

MIN_TRACK_WIDTH = 1e-6
"""m: wheels that are no farther apart stand in one place."""

Share = tuple[float, float, float, float]
"""The share of a wheel: its drag, then its moment, each for 1 N of `force` and for 1 N·m of `moment`."""


@compiled
def wrench(at: KernelSituation, own: EffectValues, out: Parts) -> None:
    right, left, of_right, of_left = _track(at)
    _drag(at, right, of_right, own, out)
    if left - right > MIN_TRACK_WIDTH:
        _drag(at, left, of_left, own, out)


@compiled
def stiction(at: KernelSituation, own: EffectValues, columns: Array) -> int:
    right, left, of_right, of_left = _track(at)
    _hold(at, right, of_right, own, columns[0])
    if left - right > MIN_TRACK_WIDTH:
        _hold(at, left, of_left, own, columns[1])
        return 2
    return 1


@compiled
def _track(at: KernelSituation) -> tuple[float, float, Share, Share]:
    """Where along {b}'s y the outermost fixed wheels stand, the right one first, and their shares. Where the track is
    not known, one at the origin has all."""
    right, left = 0.0, 0.0
    found = False
    for k in range(len(at.wheels)):
        if at.wheels[k, 2] == 0.0:
            y = at.wheels[k, 1]
            right, left = (min(right, y), max(left, y)) if found else (y, y)
            found = True
    span = left - right
    if span <= MIN_TRACK_WIDTH:
        return 0.0, 0.0, (1.0, 0.0, 0.0, 1.0), (0.0, 0.0, 0.0, 0.0)
    of_right = (left / span, -1.0 / span, left * right / span, -right / span)
    of_left = (-right / span, 1.0 / span, -left * right / span, left / span)
    return right, left, of_right, of_left


@compiled
def _drag(at: KernelSituation, y: float, share: Share, own: EffectValues, out: Parts) -> None:
    """Adds the drag of a wheel at y, against its own rolling."""
    sign, slope = smooth_sign(at.velocity[0] - y * at.velocity[2], at.smoothing_speed)
    force, moment = _strength(share, own)
    out.value[0] -= force * sign
    out.value[2] += moment * sign
    out.by_velocity[0, 0] -= force * slope
    out.by_velocity[0, 2] += force * slope * y
    out.by_velocity[2, 0] += moment * slope
    out.by_velocity[2, 2] -= moment * slope * y
    for q in range(2):
        out.by_parameters[0, q] -= share[q] * sign
        out.by_parameters[2, q] += share[2 + q] * sign


@compiled
def _hold(at: KernelSituation, y: float, share: Share, own: EffectValues, column: Array) -> None:
    sign, _ = smooth_sign(at.velocity[0] - y * at.velocity[2], at.smoothing_speed)
    force, moment = _strength(share, own)
    column[0], column[2] = -(1.0 - sign * sign) * force, (1.0 - sign * sign) * moment


@compiled
def _strength(share: Share, own: EffectValues) -> tuple[float, float]:
    """The drag (N) and the moment (N·m) of a wheel that rolls."""
    force, moment = own.parameters[0], own.parameters[1]
    return share[0] * force + share[1] * moment, share[2] * force + share[3] * moment
