"""The roles of the closed loop. Each asks one to three questions; nobody in the loop knows who answers."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol

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

    def plan_or_hold(self, wrench: Array, contacts: Mapping[str, Array] | None = None) -> Plan: ...


class ContactSource(Protocol):
    """Says where the arms hold, (3,) in {b} by name, when the cart is to feel a wrench (3,)."""

    def contacts(self, time: float, wrench_b: Array) -> Mapping[str, Array]: ...


class Estimator(Protocol):
    """Learns from measurements."""

    def update(self, measurement: Measurement) -> Estimate: ...


class Plant(Protocol):
    """What is pushed: physics, or a simulation of it."""

    @property
    def time(self) -> float: ...

    @property
    def motion(self) -> Motion: ...

    def acceleration(self, wrenches: ContactWrenches) -> Array:
        """Of the free velocities (n_free,), at once, under such wrenches; asked where a sensor feels it."""
        ...

    def step(self, wrenches: ContactWrenches, duration: float) -> None: ...
