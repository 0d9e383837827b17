"""From the error against a reference to the planar wrench that the cart should feel.

A cart with one rolling constraint has two inputs for three coordinates, so the lateral error is steered
(physics.md; correcting (26)-(28)): Kanayama's velocity law at the axle,

    u_c = u_d cos e_h + k_x s_x,    r_c = r_d + u_d k_y s_y sinc(e_h) + k_h s_h,

with e = (e_x, e_y) the position error along and across the wheels and e_h the heading error, then
`nu' = d/dt nu_c + k_v (nu_c - nu)` through reduced inverse dynamics. Far off, an error acts as one of `reach` does:
`s = e / sqrt(1 + |e|²/reach²)`, s_h alike, after the saturated law of Jiang, Lefeber and Nijmeijer (2001). So it is
made good at `k_x reach` and `k_h reach` at most, beside the reference. Lyapunov function
`reach² (sqrt(1 + |e|²/reach²) - 1) + e_h²/(2 k_y)`: its rate is `-k_x s_x² - (k_h/k_y) e_h s_h`.
With no constraint all three coordinates are held, on a rail one: the same second-order error dynamics.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import final

import numpy as np

from cartgrasp.checks import MAX_NUMBER, number, positive
from cartgrasp.constraints import RollingConstraints
from cartgrasp.frames import Array, body_to_world
from cartgrasp.model import CartModel
from cartgrasp.motion import Motion, Reference

from .steering import MIN_REFERENCE_SPEED, GainNumbers, error_b, steered


@dataclass(frozen=True)
class Gains:
    """Rates at which errors decay: along (1/s), across (1/m²), heading (1/s), velocity (1/s); and the `reach` (m and
    rad) that errors saturate at, so that the cart is quicker than its reference by `along * reach` at most, and turns
    quicker by `heading * reach`, beside what takes it back across."""

    along: float = 1.5
    across: float = 6.0
    heading: float = 3.0
    velocity: float = 5.0
    reach: float = 0.5

    def __post_init__(self) -> None:
        for name in ("along", "across", "heading", "velocity"):
            number(f"gains: {name}", getattr(self, name), 0.0, MAX_NUMBER)
        positive("gains: reach", self.reach, MAX_NUMBER, "give m and rad")

    @property
    def numbers(self) -> GainNumbers:
        return self.along, self.across, self.heading, self.velocity, self.reach


@final
@dataclass(frozen=True)
class SteeringTracker:
    """For a cart with one rolling constraint. `as_it_is`: friction is fed forward as `_wrench` says."""

    gains: Gains = Gains()
    as_it_is: bool = False

    def wrench_b(self, reference: Reference, motion: Motion, model: CartModel) -> Array:
        rolling = model.rolling
        error = error_b(reference.pose_sb, motion.pose_sb, rolling.axle_x or 0.0)
        (u, r), (u_d, r_d), (du_d, dr_d) = (
            part.tolist() for part in (motion.velocity, reference.velocity, reference.acceleration)
        )
        acceleration = steered(error, rolling.angle, (u, r), ((u_d, r_d), (du_d, dr_d)), self.gains.numbers)
        return _wrench(model, reference, motion, np.array(acceleration), self.as_it_is)


@final
@dataclass(frozen=True)
class DirectTracker:
    """For a cart whose every coordinate can be pushed: all casters, or a rail. `as_it_is` as above."""

    gains: Gains = Gains()
    as_it_is: bool = False

    def wrench_b(self, reference: Reference, motion: Motion, model: CartModel) -> Array:
        k, to_nu = self.gains, model.rolling.free_velocity
        error = np.array(error_b(reference.pose_sb, motion.pose_sb, 0.0))
        turned = body_to_world(error[2]) @ model.basis_b  # the reference's nu in {b} of the cart
        velocity, wanted = model.basis_b @ motion.velocity, turned @ reference.velocity
        rate, acceleration = wanted - velocity, turned @ reference.acceleration
        acceleration = acceleration + rate[2] * _across(wanted)
        error, error_rate = _saturated(error, rate - velocity[2] * _across(error), k.reach)
        acceleration = acceleration + k.along * error_rate + k.velocity * (rate + k.along * error)
        return _wrench(model, replace(reference, velocity=to_nu(wanted)), motion, to_nu(acceleration), self.as_it_is)


def build_tracker(
    constraints: RollingConstraints, gains: Gains | None = None, as_it_is: bool = False
) -> SteeringTracker | DirectTracker:
    """The tracking law that suits the constraints."""
    gains = gains or Gains()
    return SteeringTracker(gains, as_it_is) if constraints.n_rows == 1 else DirectTracker(gains, as_it_is)


def wrench_as_it_moves(model: CartModel, motion: Motion, acceleration: Array, time: float) -> Array:
    """Planar wrench (3,) in {b} for nu' (k,), with friction and memories those of the motion."""
    state = model.state(motion.pose_sb, motion.velocity)
    if motion.memory is not None:
        state[model.memory_slice] = motion.memory
    return model.planar_wrench(model.required_wrench(state, acceleration, time=time))


def wrench_on_reference(model: CartModel, reference: Reference) -> Array:
    """Planar wrench (3,) in {b} with which a cart that is on its reference stays on it."""
    motion = Motion(reference.pose_sb, reference.velocity)
    return _wrench(model, reference, motion, reference.acceleration, as_it_is=False)


def _across(vector: Array) -> Array:
    """A planar vector (3,) a quarter turn on, without its part about z."""
    return np.array([-vector[1], vector[0], 0.0])


def _saturated(error: Array, rate: Array, reach: float) -> tuple[Array, Array]:
    """An error (3,) of which position and heading saturate, and its rate."""
    sizes = np.array([np.hypot(error[0], error[1])] * 2 + [error[2]])
    growing = np.array([error[:2] @ rate[:2]] * 2 + [error[2] * rate[2]])
    longer = np.sqrt(1.0 + sizes**2 / reach**2)
    return error / longer, rate / longer - error * growing / reach**2 / longer**3


def _wrench(model: CartModel, reference: Reference, motion: Motion, acceleration: Array, as_it_is: bool) -> Array:
    """Planar wrench in {b}. Friction is fed forward for the wanted velocity, so that it also breaks away from rest; and
    what swings, as if it went along. Memories that nobody sees are taken to be as at first. `as_it_is`: friction and
    memories are those of the motion, which is where a disturbance beside them was observed."""
    if as_it_is:
        return wrench_as_it_moves(model, motion, acceleration, reference.time)
    wanted = np.where(np.abs(reference.velocity) > MIN_REFERENCE_SPEED, reference.velocity, motion.velocity)
    state, feedforward = (model.state(motion.pose_sb, velocity) for velocity in (motion.velocity, wanted))
    if motion.memory is not None and len(motion.memory):
        for each in (state, feedforward):
            memory = each[model.memory_slice]
            memory[:] = np.where(model.memory_is_seen, motion.memory, memory)
    reduced = model.required_wrench(state, acceleration, time=reference.time)
    effects, swung = model.effect_values(np.stack([state, feedforward]), time=reference.time)
    drag = effects[0] - effects[1]
    drag[0] += swung[0] * (model.basis_b[0] @ acceleration)
    return model.planar_wrench(reduced + drag @ model.basis_b)
