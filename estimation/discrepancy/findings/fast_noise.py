"""Noise of wrenches as slow as a rollout feels it, read off what a model leaves.

A sensor's noise may remember for tens of milliseconds (filters, held samples, a trembling hand): from sample to sample
it looks quieter than it is over a second. Third differences of the finest rows see what is faster than two or three
hertz, where such noise is white and what a model lacks is slow.
"""

from __future__ import annotations

import numpy as np

from cartgrasp.frames import Array
from cartgrasp.model import CartModel

from ...log_noise.log_noise import MAD_TO_STD
from ...weak_form.balances import Balances
from ...weak_form.rows import motion_noise, wrench_noise

ROW_STEP = 0.1
"""Step (s) of the finest rows."""
THIRD = np.array([-1.0, 3.0, -3.0, 1.0])
MOST = 3.0
"""Largest multiple of the sensors' own noise, as differences of samples tell it: of noise that remembers for 50 ms
(exponentially, at 100 Hz). What is louder is none of a sensor's."""
FEWEST = 20
"""Fewest differences that tell their usual size."""


def fast_noise(balances: Balances, cart: CartModel) -> Array:
    """Root of the density (f,; N/√Hz, N·m/√Hz) of the reduced wrench's noise."""
    known, fine = wrench_noise(balances, cart), balances.every(ROW_STEP)
    following = fine.used[3:] - fine.used[:-3] == 3
    if following.sum() < FEWEST:
        return known
    f = len(known)
    differences = np.diff(fine.residual(cart)[0][:, :f], 3, axis=0)[following]
    moved, order = motion_noise(fine, cart)
    variance = (MAD_TO_STD * np.median(np.abs(differences), axis=0)) ** 2 - moved**2 * _passed(fine, order)
    return np.asarray(np.clip(np.sqrt(np.maximum(variance / _passed(fine, 0), 0.0)), known, MOST * known))


def _passed(balances: Balances, order: int) -> float:
    """Variance of a third difference of rows, of white noise through a derivative of the test functions."""
    return float(
        sum(a * b * balances.overlap(order, abs(i - j)) for i, a in enumerate(THIRD) for j, b in enumerate(THIRD))
    )
