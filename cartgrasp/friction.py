"""Friction between a hand and what it holds: Coulomb's, and that of soft pads, which bears a moment about their normal,
too, at its cost."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .checks import MAX_NUMBER, number
from .errors import UsageError

EXACT = "exact"
MAX_FRICTION = 100.0
NORMALS = ("x", "y", "z")
MIN_CONE_SIDES, MAX_CONE_SIDES = 3, 32  # sides


@dataclass(frozen=True)
class Friction:
    """Coulomb friction at a contact whose normal is {a}'s x; the arm only pushes (fx >= 0).

    `sides` is the number of sides of the pyramid inscribed in the cone, with edges at 2 pi k / sides from y,
    or "exact" for the cone itself.
    """

    mu: float
    sides: int | str = 4

    def __post_init__(self) -> None:
        object.__setattr__(self, "mu", number("friction: mu", self.mu, 0.0, MAX_FRICTION))
        if self.sides != EXACT and not (isinstance(self.sides, int | np.integer) and 3 <= self.sides <= 256):
            raise UsageError(f'friction: sides: {self.sides!r} is neither a whole number of 3 to 256 nor "exact"')
        object.__setattr__(self, "sides", self.sides if self.sides == EXACT else int(self.sides))


@dataclass(frozen=True)
class SoftFinger:
    """A pad that presses with N bears forces f along it and a moment m about its normal with

        ‖(f, m / twist_radius)‖ <= mu N,

    the ellipsoid of Howe and Cutkosky (1996). By Coulomb's law a pad slips within it already: under even pressure up
    to 7 % nearer to zero, where four corners press up to 10 %.

    Args:
        mu: Friction of the pads.
        twist_radius: m; pads that are only turned slip at the moment mu N twist_radius. Of a disc under even pressure
            2/3 of its radius, of one under a ball's pressure (Hertz) 3π/16, of points their distance from the middle.
        grip: N with which each of two parallel fingers presses, whatever they give: N is twice that. Without it the
            hand is open: N is its own push along the normal, and it only pushes.
        normal: "x", "y" or "z" of {a}.
        sides: Of the polytope inscribed in the ellipsoid, about as many on each of its great circles, 3 to 32, or
            "exact" for the ellipsoid itself.

    Raises:
        UsageError: A value is of the wrong kind or out of bounds.

    Example:
        >>> import cartgrasp as cg
        >>> pinch = cg.SoftFinger(mu=0.6, twist_radius=0.0156, grip=100.0, normal="z")
        >>> left = cg.Arm("left", [(-0.25, 0.2, 1.0)], soft_finger=pinch)
    """

    mu: float
    twist_radius: float
    grip: float = 0.0
    normal: str = "x"
    sides: int | str = 8

    def __post_init__(self) -> None:
        number("soft finger: mu", self.mu, 0.0, MAX_FRICTION)
        number("soft finger: twist_radius", self.twist_radius, 1e-4, 10.0, "give m")
        number("soft finger: grip", self.grip, 0.0, MAX_NUMBER, "give N")
        if self.normal not in NORMALS:
            raise UsageError(f'soft finger: normal: {self.normal!r} is neither "x", "y" nor "z"')
        whole = isinstance(self.sides, int | np.integer) and not isinstance(self.sides, bool)
        if self.sides != EXACT and not (whole and MIN_CONE_SIDES <= int(self.sides) <= MAX_CONE_SIDES):
            why = f'is neither a whole number of {MIN_CONE_SIDES} to {MAX_CONE_SIDES} nor "{EXACT}"'
            raise UsageError(f"soft finger: sides: {self.sides!r} {why}")
