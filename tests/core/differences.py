"""Derivatives without algebra: fourth-order central differences.

With step h the error is h⁴ f⁽⁵⁾/30 from truncation and some 2e-16 |f| / h from rounding. The sharpest bend of
the library is the sign of a Coulomb force, smoothed over s = 2 mm/s: f⁽⁵⁾ is at most 45 F/s⁵, so h = 1e-6
leaves 1e-9 F, and rounding as much. What is only once differentiable (`u |u|`) is off by its curvature times
h at the bend. `TOLERANCE` allows for a curvature of 40; a wrong term of a partial is larger by orders.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

STEP = 1e-6
TOLERANCE = 4e-5
RELATIVE = 1e-6


def partials(function: Callable[[np.ndarray], np.ndarray], at: np.ndarray) -> np.ndarray:
    """Partials (k, n) of a function that broadcasts, from (n,) to (k,)."""
    steps = STEP * np.maximum(1.0, np.abs(at))
    moves = np.array([1.0, -1.0, 2.0, -2.0])[:, None, None] * np.diag(steps)
    values = function(at + moves)
    near, near_back, far, far_back = np.broadcast_to(values, (4, at.size, values.shape[-1]))
    return np.asarray((8 * (near - near_back) - (far - far_back)).T / (12 * steps))


def assert_partials(analytic: np.ndarray, function: Callable[[np.ndarray], np.ndarray], at: np.ndarray) -> None:
    expected = partials(function, at)
    tolerance = TOLERANCE + RELATIVE * np.abs(expected).max(initial=0.0)
    np.testing.assert_allclose(np.broadcast_to(analytic, expected.shape), expected, rtol=0, atol=tolerance)
