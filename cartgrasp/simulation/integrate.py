"""Fixed-step integration of `CartModel.rate` with the wrench held over the step."""

from __future__ import annotations

from collections.abc import Callable

from ..frames import Array


def runge_kutta_4(rate: Callable[[float, Array], Array], time: float, state: Array, step: float) -> Array:
    """One classical fourth-order step."""
    k1 = rate(time, state)
    k2 = rate(time + step / 2, state + step / 2 * k1)
    k3 = rate(time + step / 2, state + step / 2 * k2)
    k4 = rate(time + step, state + step * k3)
    return state + step / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
