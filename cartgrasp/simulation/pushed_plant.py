"""Pushes from outside, on any plant: each is a force at a point, held over a control step like those of the arms."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from ..contacts import ContactWrenches
from ..frames import Array
from ..motion import Motion
from ..roles import Plant


class Push(NamedTuple):
    """A force (3,) at a point (3,), both in {b}; N, m."""

    force_b: Array
    point_b: Array


PushSource = Callable[[float, Motion], Sequence[Push]]
"""What pushes at a time, s, on a cart with such a motion."""


def no_pushes(time: float, motion: Motion) -> Sequence[Push]:
    """No pushes."""
    return ()


class PushedPlant:
    """A plant on which something pushes beside the arms, which they don't feel."""

    def __init__(self, plant: Plant, outside: PushSource) -> None:
        self.plant, self._outside = plant, outside

    @property
    def time(self) -> float:
        return self.plant.time

    @property
    def motion(self) -> Motion:
        return self.plant.motion

    def acceleration(self, wrenches: ContactWrenches) -> Array:
        return self.plant.acceleration(self._with_pushes(wrenches))

    def step(self, wrenches: ContactWrenches, duration: float) -> None:
        self.plant.step(self._with_pushes(wrenches), duration)

    def _with_pushes(self, arms: ContactWrenches) -> ContactWrenches:
        pushes = {f"outside {i}": push for i, push in enumerate(self._outside(self.time, self.motion))}
        wrenches = {name: np.append(push.force_b, np.zeros(3)) for name, push in pushes.items()}
        points = {name: push.point_b for name, push in pushes.items()}
        return ContactWrenches({**arms.wrenches, **wrenches}, {**arms.contacts, **points}, arms.yaws, arms.away)
