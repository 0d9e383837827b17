"""The scene of the demo: a loaded shopping cart on real casters, two arms on its handle, a path with push and pull."""

from __future__ import annotations

import numpy as np

from planning import Choosing
from planning.contact_sources.strategies import LEAST_EFFORT
from planning.references import Stretch, chain, pause, straight, turn
from planning.tracking import Gains

from ..arms import Arm
from ..constraints import RollingConstraints
from ..effects import CasterRealignment, Effect, RollingResistance, ViscousDrag
from ..inertia import Inertia
from ..model import CartModel
from ..simulation.sensors import SensorNoise
from ..wheels import CASTER, FIXED, Wheel
from .scenario import MUJOCO_PLANT, Scenario, filter_noise


def four_wheels(fixed_y: float, casters_x: float, casters_y: float) -> tuple[Wheel, ...]:
    """Fixed ones on the axle, and casters ahead, each so far (m) to its side."""
    fixed = (Wheel(FIXED, 0.0, y) for y in (fixed_y, -fixed_y))
    return (*fixed, *(Wheel(CASTER, casters_x, y, trail=0.045) for y in (casters_y, -casters_y)))


WHEELS = four_wheels(0.27, 0.72, 0.2)
SENSOR_NOISE = SensorNoise(0.0004, 0.0004, 0.005, 0.005, 1.0, 0.05)
PerAxis = tuple[float, float, float]
FIRM_GAINS = Gains(along=3.0, across=15.0, heading=6.0, velocity=8.0)


def two_hands(y: float, force: PerAxis, moment: PerAxis) -> tuple[Arm, ...]:
    """On a handle 0.25 m behind the axle and 1 m up, each `y` (m) to its side, with the same limits (N, N·m)."""
    places = {"left": (-0.25, y, 1.0), "right": (-0.25, -y, 1.0)}
    return tuple(Arm(name, [place], force_limit=force, moment_limit=moment) for name, place in places.items())


def arms() -> tuple[Arm, ...]:
    """Two arms that hold the handle firmly, so that they can pull too; each may regrasp at three points."""
    force, moment = (80.0, 20.0, 30.0), (10.0, 10.0, 10.0)
    places = {"left": (0.15, 0.22, 0.08), "right": (-0.15, -0.22, -0.08)}
    return tuple(
        Arm(name, [(-0.25, y, 1.0) for y in ys], force_limit=force, moment_limit=moment) for name, ys in places.items()
    )


def loaded_cart() -> CartModel:
    """What is really pushed: 29.7 kg, as in the paper's Fig. 8, with its load off the middle."""
    effects = (
        ViscousDrag(linear=2.0, angular=0.4),
        RollingResistance(coefficient=0.015),
        CasterRealignment(swivel_torque=0.12),
    )
    inertia = Inertia(29.7, (0.36, 0.05), 2.6)
    return CartModel(inertia, RollingConstraints(), effects, WHEELS, com_height=0.45, name="loaded shopping cart")


def first_guess(with_effects: bool = True) -> CartModel:
    """What the controller believes at first: an empty cart, drags from a book, or viscous drag alone."""
    effects: tuple[Effect, ...] = (ViscousDrag(linear=3.0, angular=1.0),)
    if with_effects:
        effects += (RollingResistance(coefficient=0.02), CasterRealignment(swivel_torque=0.06))
    inertia = Inertia(20.0, (0.3, 0.0), 2.0)
    return CartModel(inertia, RollingConstraints(), effects, WHEELS, com_height=0.45, name="first guess")


FILTER_NOISE = filter_noise(SENSOR_NOISE, disturbance=0.1, slip=0.0005)


def push_and_pull(quick: bool = False) -> tuple[Stretch, ...]:
    """Forward, slower through two curves, and a stop; backward out of it (the casters swing round), forward again."""
    faster, slower = Stretch(0.5, 0.4), Stretch(0.5, -0.4)
    forward = chain(
        [Stretch(2.0, 0.4)],
        pause(0.5),
        *([slower], turn(np.pi / 2, 0.5, 0.8), [faster], pause(0.5)),
        *([slower], turn(-np.pi / 2, 0.5, 0.8), [faster], pause(0.5)),
        [Stretch(2.0, -0.4)],
        pause(0.5),
    )
    if quick:
        return forward
    back_off, come_to_rest = Stretch(1.25, -0.4), Stretch(1.25, 0.4)
    backward = chain([back_off], pause(0.5), turn(0.6, 0.4, 0.8), pause(1.0), [come_to_rest], pause(0.5))
    curve = turn(-np.pi / 3, 0.5, 0.8)
    again = chain([Stretch(1.5, 0.4)], pause(0.5), curve, pause(1.0), [Stretch(1.5, -0.4)], pause(0.5))
    return chain(forward, backward, again, straight(-0.8, 0.4, 0.4), pause(0.5))


def scenario(with_effects: bool = True, quick: bool = False, seed: int = 0, plant: str = MUJOCO_PLANT) -> Scenario:
    """The demo's run; `with_effects` False leaves casters and rolling resistance out of the controller's model."""
    return Scenario(
        truth=loaded_cart(),
        guess=first_guess(with_effects),
        arms=arms(),
        stretches=push_and_pull(quick),
        sensors=SENSOR_NOISE,
        noise=FILTER_NOISE,
        contacts=LEAST_EFFORT,
        choosing=Choosing(every=4.0),
        gains=FIRM_GAINS,
        plant=plant,
        seed=seed,
    )
