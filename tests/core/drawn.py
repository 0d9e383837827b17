"""What hypothesis draws for the tests of the core: numbers, motions, inertias, wheels, carts."""

from __future__ import annotations

import numpy as np
from hypothesis import strategies as st

from cartgrasp.constraints import RollingConstraints
from cartgrasp.inertia import Inertia
from cartgrasp.wheels import Wheel, WheelSet

SHOPPING_CART = (
    Wheel("fixed", 0.0, 0.27),
    Wheel("fixed", 0.0, -0.27),
    Wheel("caster", 0.72, 0.20, 0.045),
    Wheel("caster", 0.72, -0.20, 0.045),
)
HOSPITAL_BED = tuple(Wheel("caster", x, y, 0.06) for x in (-0.8, 0.9) for y in (-0.4, 0.45))
TRICYCLE = (Wheel("caster", -0.5, 0.05), Wheel("fixed", 0.3, 0.3), Wheel("fixed", 0.3, -0.3))
WHEELS = ((), SHOPPING_CART, HOSPITAL_BED, TRICYCLE)

CONSTRAINTS = {
    "casters only": RollingConstraints(None),
    "axle at the origin": RollingConstraints(0.0),
    "axle ahead": RollingConstraints(0.35),
    "axle behind": RollingConstraints(-0.6),
    "rail": RollingConstraints(0.2, no_rotation=True),
}


def numbers(low: float, high: float) -> st.SearchStrategy[float]:
    return st.floats(low, high, allow_nan=False, allow_infinity=False)


def vectors(n: int, low: float, high: float) -> st.SearchStrategy[np.ndarray]:
    return st.lists(numbers(low, high), min_size=n, max_size=n).map(np.array)


def speeds() -> st.SearchStrategy[float]:
    """Everyday speeds, and those near standstill, where Coulomb forces change sign."""
    return st.one_of(numbers(-2.0, 2.0), numbers(-0.005, 0.005))


def velocities(n: int = 3) -> st.SearchStrategy[np.ndarray]:
    return st.lists(speeds(), min_size=n, max_size=n).map(np.array)


def poses() -> st.SearchStrategy[np.ndarray]:
    return st.tuples(numbers(-3, 3), numbers(-3, 3), numbers(-4, 4)).map(np.array)


def wrenches() -> st.SearchStrategy[np.ndarray]:
    """Planar, in {b}."""
    return vectors(3, -80.0, 80.0)


def inertias() -> st.SearchStrategy[Inertia]:
    return st.builds(Inertia, numbers(5, 60), st.tuples(numbers(-0.3, 0.5), numbers(-0.3, 0.3)), numbers(0.2, 10))


def phis() -> st.SearchStrategy[np.ndarray]:
    return inertias().map(lambda inertia: inertia.phi)


def no_wheel_just_lifts(phi: np.ndarray, wheels: WheelSet) -> bool:
    """The loads bend where a wheel leaves the floor; differences across the bend say nothing."""
    around = phi + 1e-3 * np.concatenate([np.zeros((1, 4)), np.eye(4), -np.eye(4)])
    standing = wheels.loads(around) > 0
    return bool((standing == standing[0]).all())
