"""Our own plant: the model, integrated."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ..checks import MAX_NUMBER, brief, check_kind, digits, number, pose, positive, rows
from ..compiled_dynamics import MAX_STEP_STIFFNESS
from ..contacts import ContactWrenches
from ..errors import PlantError
from ..frames import Array
from ..model import CartModel
from ..motion import Motion
from ..roles import Plant
from .integrate import held

MAX_STEP = 0.005
MAX_STEP_QUICKNESS = 0.2
"""Largest product of a step and the quickness (1/s) of a force that sets in: it keeps the energy of a touch to a
thousandth."""


def brief_plant(plant: Plant, cart: CartModel) -> str:
    """A `repr`."""
    pose_sb, velocity = (digits(part.tolist()) for part in plant.motion[:2])
    return brief(type(plant).__name__, cart.name, f"t = {digits(plant.time)} s", f"pose {pose_sb}", f"nu {velocity}")


def headings_of(what: str, given: ArrayLike, n: int) -> Array:
    """Those of n casters, of as many or of one for all."""
    if np.ndim(given) == 0:
        return np.full(n, number(what, given, -MAX_NUMBER, MAX_NUMBER, "give rad"))
    found = rows(what, given, ("heading",), n)
    return np.array([number(what, one, -MAX_NUMBER, MAX_NUMBER, "give rad") for one in found.tolist()])


class ModelPlant:
    """A cart that moves as its `CartModel` says, and bounces off its walls; wrenches are held over a control step, in
    {b}.

    Args:
        cart: The truth.
        pose_sb: (x, y, theta) of {b} in {s} where it begins, m and rad.
        velocity: Free velocities at first, m/s and rad/s; at rest unless given.
        timestep: s, of the integration at most.
        caster_headings: rad in {b}, of casters that the effects remember; trailing unless given.

    Raises:
        UsageError: An argument is of the wrong kind or shape.

    Example:
        >>> import cartgrasp as cg
        >>> from cartgrasp.simulation import ModelPlant
        >>> plant = ModelPlant(cg.CartModel(cg.Inertia(24.0, (0.3, 0.0), 2.0)))
        >>> push = cg.ContactWrenches({"hand": [24.0, 0, 0, 0, 0, 0]}, {"hand": [-0.25, 0, 1]})
        >>> plant.step(push, duration=1.0)
        >>> plant.motion.velocity.round(3).tolist()
        [1.0, 0.0]
    """

    def __init__(
        self,
        cart: CartModel,
        pose_sb: ArrayLike = (0.0, 0.0, 0.0),
        velocity: ArrayLike | None = None,
        timestep: float = MAX_STEP,
        caster_headings: ArrayLike | None = None,
    ) -> None:
        check_kind("plant: cart", cart, CartModel, 'load it first: load_cart("cart.yaml")')
        self.cart, self.timestep = cart, positive("plant: timestep", timestep, MAX_NUMBER, "give s")
        self._state = cart.state(pose("plant: pose_sb", pose_sb), velocity)
        self._time = 0.0
        mass = float(cart.inertia.mass)
        self._quickness = max((effect.quickness(mass) for effect, _, _ in cart.force_effects), default=0.0)
        self._headings = [i for i, name in enumerate(cart.state_names) if name.rpartition(".")[2].startswith("heading")]
        if caster_headings is not None and self._headings:
            self._state[self._headings] = headings_of("plant: caster_headings", caster_headings, len(self._headings))

    def __repr__(self) -> str:
        return brief_plant(self, self.cart)

    @property
    def time(self) -> float:
        return self._time

    @property
    def state(self) -> Array:
        return self._state.copy()

    @property
    def motion(self) -> Motion:
        return Motion(self._state[:3].copy(), self._state[self.cart.velocity_slice].copy())

    @property
    def caster_headings(self) -> Array | None:
        return self._state[self._headings].copy() if self._headings else None

    def acceleration(self, wrenches: ContactWrenches) -> Array:
        """Rate of the free velocities (n_free,) under wrenches."""
        rate = self.cart.state_rate(self._state, wrenches.wrench_b, time=self._time)
        return np.asarray(rate[self.cart.velocity_slice])

    def step(self, wrenches: ContactWrenches, duration: float) -> None:
        check_kind("plant: step", wrenches, ContactWrenches, "give plan.contact_wrenches")
        number("plant: step: duration", duration, 0.0, cure="give s")
        number("plant: step: duration", duration, high=MAX_NUMBER, cure="give s")
        wrench_b, begin = wrenches.wrench_b, self._time
        n = max(1, int(np.ceil(duration / self.timestep - 1e-9)), self._stable_steps(wrench_b, duration))
        state, end = held(self.cart, self._state, wrench_b, begin, (duration / n, n)), begin + duration
        if not np.isfinite(state).all():
            raise PlantError(f"the simulated cart's state is not finite at t = {end:.3f} s")
        self._state, self._time = state, end

    def _stable_steps(self, wrench_b: Array, duration: float) -> int:
        """The number of steps that keep smoothed Coulomb friction, which is stiff near standstill, in the integrator's
        stable region. They also resolve forces that may set in within a step."""
        if not self.cart.effects:
            return 1
        stiffness = self.cart.stiffness(self._state, wrench_b, self._time) / MAX_STEP_STIFFNESS
        return int(np.ceil(duration * max(stiffness, self._quickness / MAX_STEP_QUICKNESS)))
