"""Carts: the true one, the believed one, a worse guess of it, and the file."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from .sizes import CART, GUESS, NOMINAL
from .world import World

CART_FILE = """\
name: cart
mass: {mass:.3f}
com: [{com_x:.4f}, {com_y:.4f}]
inertia: {inertia:.4f}
com_height: {com_height:.3f}
constraints:
  - no_lateral_slip: {{x: 0.0}}
wheels:
  - {{kind: fixed, x: 0.0, y: {half_track:.4f}}}
  - {{kind: fixed, x: 0.0, y: -{half_track:.4f}}}
  - {{kind: caster, x: {caster_x:.4f}, y: {caster_y:.4f}, trail: {trail:.4f}}}
  - {{kind: caster, x: {caster_x:.4f}, y: -{caster_y:.4f}, trail: {trail:.4f}}}
effects:
"""
ON_A_RAIL = """\
name: cart
mass: {mass:.3f}
com: [{com_x:.4f}, {com_y:.4f}]
inertia: {inertia:.4f}
com_height: {com_height:.3f}
constraints:
  - no_lateral_slip: {{x: 0.0}}
  - no_rotation: {{}}
effects:
"""
VISCOUS = "  viscous_drag: {{linear: {linear:.3f}, angular: {angular:.3f}}}\n"


@dataclass(frozen=True)
class Believed:
    """What `cart.yaml` says of the mass and its drag."""

    mass: float
    com_x: float
    com_y: float
    inertia: float
    linear: float
    angular: float


def draw_cart(random: np.random.Generator) -> World:
    drawn = {name: random.uniform(*limits) for name, limits in CART.items()}
    mass = drawn["mass"]
    drawn["inertia"] = mass * drawn.pop("gyration") ** 2
    drawn["linear"], drawn["angular"] = mass * drawn["linear"], mass * drawn["angular"]
    return World(**drawn)


def believe(world: World, random: np.random.Generator) -> Believed:
    def wrong(value: float, share: float) -> float:
        return value * (1 + random.uniform(-share, share))

    return Believed(
        mass=wrong(world.mass, NOMINAL["mass"]),
        com_x=world.com_x + random.uniform(-1, 1) * NOMINAL["com"],
        com_y=world.com_y + random.uniform(-1, 1) * NOMINAL["com"],
        inertia=wrong(world.inertia, NOMINAL["inertia"]),
        linear=wrong(world.linear, NOMINAL["drag"]),
        angular=wrong(world.angular, NOMINAL["drag"]),
    )


def guessed(world: World, believed: Believed, limits: tuple[float, float], random: np.random.Generator) -> Believed:
    """For the cart file alone: mass and inertia are one factor off, between `limits`, and the CoM is anywhere near."""
    factor = float(np.exp(random.uniform(*np.log(limits))))
    x, y = random.uniform(-1, 1, 2) * GUESS["com"]
    return replace(
        believed,
        mass=factor * world.mass,
        inertia=factor * world.inertia,
        com_x=world.com_x + float(x),
        com_y=world.com_y + float(y),
    )


def cart_file(world: World, believed: Believed, viscous: bool) -> str:
    """The text of `cart.yaml`; without `viscous` it knows of no drag at all."""
    values = {**world._asdict(), **vars(believed)}
    text = (ON_A_RAIL if world.rail else CART_FILE).format(**values)
    return text + VISCOUS.format(**values) if viscous else text.replace("effects:\n", "")
