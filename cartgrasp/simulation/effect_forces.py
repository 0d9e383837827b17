"""Forces that act on a cart from outside, in a plant that has its own mechanics: what effects say at its motion."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..constraints import RollingConstraints
from ..effects import ForceEffect
from ..frames import Array
from ..model import CartModel
from ..motion import Motion


class EffectForces:
    """The wrench of some effects on a cart, whose memory goes along. A motion is given with the full velocity (u, w, r)
    in {b}."""

    def __init__(self, cart: CartModel, effects: tuple[ForceEffect, ...], motion: Motion, time: float) -> None:
        self._cart = replace(cart, constraints=RollingConstraints(None), effects=effects)
        first = self._cart.state(motion.pose_sb, motion.velocity)
        self._time, self._motion, self._memory = time, motion, first[self._cart.memory_slice]

    def wrench_b(self, motion: Motion, time: float) -> Array:
        """The wrench (3,) now."""
        pose, velocity = (np.array([getattr(m, of) for m in (self._motion, motion)]) for of in ("pose_sb", "velocity"))
        times = np.array([self._time, time])
        self._memory = self._cart.memory_along(pose, velocity, times, first=self._memory)[-1]
        self._time, self._motion = time, motion
        state = np.concatenate([motion.pose_sb, motion.velocity, self._memory])
        return self._cart.effect_wrench(state, time=time)
