"""Noise of wrenches as slow as a rollout feels it, read off what a model leaves.

A sensor's noise may remember for tens of milliseconds (filters, held samples, a trembling hand): from sample to sample
it looks quieter than it is over a second. And a force that changes fast is no noise of the sensor that tells it. Third
differences of rows see what is faster than a hertz or so, where such noise is nearly white and what a model lacks is
slow.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import product

import numpy as np

from cartgrasp.frames import Array
from cartgrasp.model import CartModel

from ...log_noise.log_noise import MAD_TO_STD
from ...weak_form.balances import Balances, wrench_densities
from ...weak_form.rows import motion_noise, wrench_noise

FAST_NOISE_ROW_STEP = 0.2
"""Step (s) of the rows: their third differences pass 1.2 to 2.3 Hz."""
THIRD_DIFFERENCE = np.array([-1.0, 3.0, -3.0, 1.0])
MAX_FAST_NOISE_RATIO = 3.0
"""Largest multiple of the sensors' own noise, as differences of samples tell it: of autocorrelated noise for 50 ms
(exponentially, at 100 Hz). What is louder is none of a sensor's."""
MIN_FAST_NOISE_DIFFERENCES = 20
"""Fewest differences that tell their usual size."""


def fast_noise(balances: Balances, cart: CartModel) -> Array:
    """Root of the density (f,; N/√Hz, N·m/√Hz) of the reduced wrench's noise: at least what differences of samples
    tell."""
    known, rows = wrench_noise(balances, cart), balances.every(FAST_NOISE_ROW_STEP)
    following = rows.used[3:] - rows.used[:-3] == 3
    if following.sum() < MIN_FAST_NOISE_DIFFERENCES:
        return known
    f = len(known)
    differences = np.diff(rows.residual(cart)[0][:, :f], 3, axis=0)[following]
    moved, order = motion_noise(rows, cart)
    variance = (MAD_TO_STD * np.median(np.abs(differences), axis=0)) ** 2 - moved**2 * _passed(rows, order)
    samples = replace(balances, wrench_densities=wrench_densities(balances.log, balances.told, averaged=(0.0,)))
    least = wrench_noise(samples, cart)
    return np.asarray(
        np.clip(np.sqrt(np.maximum(variance / _passed(rows, 0), 0.0)), least, MAX_FAST_NOISE_RATIO * known)
    )


def _passed(balances: Balances, order: int) -> float:
    """Variance of a third difference of rows, of white noise through a derivative of the test functions."""
    pairs = product(enumerate(THIRD_DIFFERENCE), repeat=2)
    return float(sum(a * b * balances.overlap(order, abs(i - j)) for (i, a), (j, b) in pairs))
