"""The roles of the closed loop. Each asks one to three questions; nobody in the loop knows who answers."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple, Protocol

from .contacts import ContactWrenches
from .frames import Array
from .model import CartModel
from .motion import Estimate, Measurement, Motion, Reference


class ReferencePath(Protocol):
    """Where the cart should be at a time."""

    @property
    def duration(self) -> float: ...

    def at(self, time: float) -> Reference: ...


class Tracker(Protocol):
    """Turns the error against a reference into the planar wrench (3,) that the cart should feel, in {b}."""

    def wrench_b(self, reference: Reference, motion: Motion, model: CartModel) -> Array: ...


class Plan(Protocol):
    """What a planner returns: a status, and contact wrenches (held or decayed ones when it is not `optimal`)."""

    @property
    def status(self) -> str: ...

    @property
    def contact_wrenches(self) -> ContactWrenches: ...


class Planner(Protocol):
    """Spreads a planar wrench over the arms; never raises for data and never returns an unsafe wrench."""

    def plan_or_hold(
        self, wrench: Array, contacts: Mapping[str, Array] | None = None, estimate: Estimate | None = None
    ) -> Plan: ...


class ContactQuery(NamedTuple):
    """What a source of contacts is told: the time (s), the wrench (3,) in {b} that the cart is to feel, what is known
    of it, and where the arms hold now, (3,) in {b} by name; nothing before the first tick."""

    time: float
    wrench_b: Array
    estimate: Estimate | None = None
    held: Mapping[str, Array] = {}


class ContactChoice(NamedTuple):
    """Where the arms are to hold, (3,) in {b} by name, and why, in a few words."""

    contacts: Mapping[str, Array]
    why: str = ""


class ContactSource(Protocol):
    """Says where the arms are to hold."""

    def contacts(self, query: ContactQuery) -> ContactChoice: ...


class Estimator(Protocol):
    """Learns from measurements."""

    def update(self, measurement: Measurement) -> Estimate: ...


class ControlStep(Protocol):
    """What a controller gives in a tick, and by what."""

    @property
    def given(self) -> ContactWrenches: ...

    @property
    def plan(self) -> Plan: ...

    @property
    def reference(self) -> Reference: ...

    @property
    def estimate(self) -> Estimate: ...

    @property
    def words(self) -> str:
        """What it does and why."""
        ...


class Controller(Protocol):
    """Goes from what is sensed to what the arms do, once a `period` (s). `cart` is its first guess, and all that it
    believes where it does not learn."""

    @property
    def cart(self) -> CartModel: ...

    @property
    def period(self) -> float: ...

    @property
    def learns(self) -> bool: ...

    @property
    def reference(self) -> ReferencePath: ...

    def step(self, measurement: Measurement) -> ControlStep: ...

    def observe(self, measurement: Measurement) -> Estimate:
        """Takes in what is sensed between two ticks."""
        ...


class Plant(Protocol):
    """What is pushed: physics, or a simulation of it."""

    @property
    def time(self) -> float: ...

    @property
    def motion(self) -> Motion: ...

    def acceleration(self, wrenches: ContactWrenches) -> Array:
        """The acceleration nu' (n_free,) at this instant, under such wrenches; asked for where a sensor feels it."""
        ...

    def step(self, wrenches: ContactWrenches, duration: float) -> None: ...
