"""Paths that have a name, at a speed of one's choice."""

from __future__ import annotations

import numpy as np

from planning.references import Stretch, chain, pause, speed_change, straight, turn

from ..constraints import RollingConstraints
from ..errors import UsageError
from .shopping_cart import push_and_pull

PATH_ACCELERATION = 0.4
PATH_NAMES = ("straight", "curves", "push-pull")
PATH_SPEED_RANGE = (0.05, 3.0)


def named_path(name: str, speed: float, constraints: RollingConstraints) -> tuple[Stretch, ...]:
    """From rest to rest; `push-pull` has a speed of its own."""
    if name not in PATH_NAMES:
        raise UsageError(f"path {name}: unknown; known are {', '.join(PATH_NAMES)}")
    low, high = PATH_SPEED_RANGE
    if not low <= speed <= high:
        raise UsageError(f"speed {speed:g}: give {low:g} to {high:g} m/s")
    if constraints.no_rotation and name != "straight":
        raise UsageError(f"path {name}: a cart on a rail can't turn; use straight")
    if name == "straight":
        return chain(
            straight(12 * speed, speed, PATH_ACCELERATION), pause(0.5), straight(-6 * speed, speed, PATH_ACCELERATION)
        )
    if name == "push-pull":
        return push_and_pull()
    rate = min(0.5, 0.8 * speed)
    curves = (turn(np.pi / 2, rate), pause(1.0), turn(-np.pi / 2, rate), pause(1.0), turn(np.pi / 3, rate))
    return chain(
        speed_change(speed, PATH_ACCELERATION), pause(2.0), *curves, speed_change(-speed, PATH_ACCELERATION), pause(0.5)
    )
