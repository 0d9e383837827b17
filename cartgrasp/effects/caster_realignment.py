"""Casters that swing round after a change of direction (physics 17; the paper's experiment E5).

A caster at pivot p trails its wheel by b. Its heading delta in {b} is a memory; the wheel does not slip
sideways at its patch p - b (cos delta, sin delta), so

    delta' = (v_p · n) / b - r,    n = (-sin delta, cos delta),    v_p = (u - y r, w + x r),

which for r = 0 is the trail model psi' = -(v/b) sin psi. Swivel friction T against delta' is balanced by a
side force F_n = -(T/b) sign(delta') n at the patch: the wrench on the cart. Its power is -T |delta'|, so it
never gives energy; along the motion it is the drag (T/b) |sin psi|.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, final

import numpy as np

from ..frames import Array, wrap_angle
from ..wheels import WheelSet
from .effect import Contribution, ForceEffect, Parameter, Situation

SMOOTHING_RATE = 0.2
"""rad/s: below it swivel friction fades to zero."""


@final
@dataclass(frozen=True)
class CasterRealignment(ForceEffect):
    """Swivel friction `swivel_torque` (N·m, each) of casters with `trail` (m; 0: as listed in wheels)."""

    swivel_torque: float = 0.0
    trail: float = 0.0

    name: ClassVar[str] = "caster_realignment"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("swivel_torque", "N·m", typical=0.3, lower=0.0),
        Parameter("trail", "m", typical=0.01, lower=0.0, upper=1.0, estimated=False),
    )
    signature: ClassVar[str] = "drag and yaw moment within some trails of travel after a reversal"

    def memory_names(self, wheels: WheelSet) -> tuple[str, ...]:
        return tuple(f"{self.key}.heading{i + 1}" for i in range(len(_pivots(wheels)[0])))

    def wrench_b(self, situation: Situation, memory: Array, parameters: Array) -> Contribution:
        rate, trail = self._swivel(situation, memory, parameters)
        torque = parameters[..., 0, None]
        pivots = _pivots(situation.wheels)[0]
        side = memory.shape[-1]
        slip, slip_slope = _smooth_sign(rate.value)
        strength = -torque / trail * slip
        arm, arm_by_heading = _side_wrench(pivots, memory, trail)
        value = np.einsum("...k,...ki->...i", strength, arm)
        by_rate = (-torque / trail * slip_slope)[..., None] * arm
        by_memory = np.einsum("...ki,...kj->...ij", by_rate, _need(rate.by_memory))
        by_memory += np.swapaxes(strength[..., None] * arm_by_heading, -1, -2)
        by_parameters = np.zeros((*value.shape, 2))
        by_parameters[..., 0] = np.einsum("...k,...ki->...i", -slip / trail, arm)
        arm_by_trail = np.zeros_like(arm)
        arm_by_trail[..., 2] = -1.0
        own_trail = _is_own_trail(parameters)
        by_trail = strength[..., None] * arm_by_trail - (strength / trail)[..., None] * arm
        by_trail = by_trail + by_rate * _need(rate.by_parameters)[..., 1, None]
        by_parameters[..., 1] = own_trail[..., None] * by_trail.sum(axis=-2)
        by_velocity = np.einsum("...ki,...kj->...ij", by_rate, _need(rate.by_velocity))
        assert by_memory.shape[-1] == side
        return Contribution(value, by_velocity=by_velocity, by_memory=by_memory, by_parameters=by_parameters)

    def stiction(self, situation: Situation, memory: Array, parameters: Array) -> Array:
        rate, trail = self._swivel(situation, memory, parameters)
        slip, _ = _smooth_sign(rate.value)
        arm, _ = _side_wrench(_pivots(situation.wheels)[0], memory, trail)
        level = parameters[..., 0, None] / trail * (1.0 - slip**2)
        return np.swapaxes(level[..., None] * arm, -1, -2)

    def memory_rate(self, situation: Situation, memory: Array, parameters: Array) -> Contribution:
        return self._swivel(situation, memory, parameters)[0]

    def settled_memory(self, situation: Situation, memory: Array) -> Array:
        """Each caster trails its pivot, at the turn nearest to the heading."""
        x, y = _pivots(situation.wheels)[0].T
        u, w, r = (situation.velocity_b[..., i, None] for i in range(3))
        return np.asarray(memory + wrap_angle(np.arctan2(w + x * r, u - y * r) - memory))

    def _swivel(self, situation: Situation, memory: Array, parameters: Array) -> tuple[Contribution, Array]:
        """delta' of each caster, (..., k), and the trails used, (..., k)."""
        pivots, listed = _pivots(situation.wheels)
        own = _is_own_trail(parameters)[..., None]
        trail = np.where(own, parameters[..., 1, None], listed)
        sine, cosine = np.sin(memory), np.cos(memory)
        x, y = pivots.T
        u, w, r = (situation.velocity_b[..., i, None] for i in range(3))
        along_n = -sine * (u - y * r) + cosine * (w + x * r)
        along_t = cosine * (u - y * r) + sine * (w + x * r)
        value = along_n / trail - r
        by_velocity = np.stack([-sine / trail, cosine / trail, (sine * y + cosine * x) / trail - 1.0], axis=-1)
        by_parameters = np.zeros((*value.shape, 2))
        by_parameters[..., 1] = own * -along_n / trail**2
        by_memory = (-along_t / trail)[..., None] * np.eye(len(pivots))
        rate = Contribution(value, by_velocity=by_velocity, by_memory=by_memory, by_parameters=by_parameters)
        return rate, trail


DEFAULT_TRAIL = 0.045


def _pivots(wheels: WheelSet) -> tuple[Array, Array]:
    """Positions (k, 2) and trails (k,) of the casters; one at {b}'s origin where none is listed."""
    casters = [w for w in wheels.wheels if w.kind == "caster"]
    if not casters:
        return np.zeros((1, 2)), np.array([DEFAULT_TRAIL])
    return np.array([[w.x, w.y] for w in casters]), np.array([w.trail or DEFAULT_TRAIL for w in casters])


def _is_own_trail(parameters: Array) -> Array:
    return np.asarray(parameters[..., 1] > 0)


def _smooth_sign(rate: Array) -> tuple[Array, Array]:
    norm = np.sqrt(rate**2 + SMOOTHING_RATE**2)
    return rate / norm, SMOOTHING_RATE**2 / norm**3


def _side_wrench(pivots: Array, heading: Array, trail: Array) -> tuple[Array, Array]:
    """Wrench (..., k, 3) of a unit side force at each patch, and its partial by heading.

    The moment is `x cos + y sin - b` (the force is across the trail, so the trail enters whole).
    """
    x, y = pivots.T
    sine, cosine = np.sin(heading), np.cos(heading)
    arm = np.stack(np.broadcast_arrays(-sine, cosine, x * cosine + y * sine - trail), axis=-1)
    by_heading = np.stack(np.broadcast_arrays(-cosine, -sine, -x * sine + y * cosine), axis=-1)
    return arm, by_heading


def _need(partial: Array | None) -> Array:
    assert partial is not None
    return partial
