"""Fixed-step integration of `CartModel.state_rate` with the wrench held over the steps."""

from __future__ import annotations

from collections.abc import Callable

from ..bounce import bounced, walls_of
from ..frames import Array
from ..model import CartModel


def held(cart: CartModel, state: Array, wrench_b: Array, time: float, steps: tuple[float, int]) -> Array:
    """The state (n,) after steps of a length (s) and number, each a classical fourth-order one; walls throw it back."""
    step, n_steps = steps
    if not walls_of(cart):
        return _free(cart, state, wrench_b, time, steps)
    for i in range(n_steps):
        after = _free(cart, state, wrench_b, time + i * step, (step, 1))
        state = bounced(cart, state, after, time + (i + 1) * step, step)
    return state


def _free(cart: CartModel, state: Array, wrench_b: Array, time: float, steps: tuple[float, int]) -> Array:
    """Where nothing stands in the way."""
    step, n_steps = steps
    if cart.is_compiled and not cart.slip_compliance:
        return cart.dynamics.advanced((state, time, cart.parameters), wrench_b, step, n_steps)
    for i in range(n_steps):
        state = runge_kutta_4(lambda t, y: cart.state_rate(y, wrench_b, time=t), time + i * step, state, step)
    return state


def runge_kutta_4(rate: Callable[[float, Array], Array], time: float, state: Array, step: float) -> Array:
    """One classical fourth-order step."""
    k1 = rate(time, state)
    k2 = rate(time + step / 2, state + step / 2 * k1)
    k3 = rate(time + step / 2, state + step / 2 * k2)
    k4 = rate(time + step, state + step * k3)
    return state + step / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
