"""What a tick of `WrenchPlanner.plan_or_hold` costs, by what is new at it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from cartgrasp import Arm, Estimate, Friction, Inertia, Motion, SoftFinger, Wheel
from planning import LeastSideForce, SideForce, Skid, TipOver, WrenchPlanner

from .measuring import Competitor, interleave
from .report import Result, timed_table
from .scene import CART

KINDS = 40
BURST = 10
WRENCH = "the wrench"
FIXED, CASTERS = ((0.0, 0.27), (0.0, -0.27)), ((0.72, 0.2), (0.72, -0.2))
WHEELS = (*(Wheel("fixed", x, y) for x, y in FIXED), *(Wheel("caster", x, y, 0.045) for x, y in CASTERS))
WHEELED = replace(CART, wheels=WHEELS, com_height=0.45)
PINCH = SoftFinger(0.6, 0.0156, 40.0, "z")
LIMITS = (Skid(0.6), TipOver(5.0))
NOTE = """Two arms with boxes and friction pyramids, and the cart's skid and tip-over; after `warm_up`. The wrench is
new at every call, and so is what the row names. An estimate given again is the same object, as of a filter slower
than the loop."""


def run(rounds: int) -> Result:
    contacts = [{"left": (-0.25, y, 1.0), "right": (-0.25, -y, 1.0)} for y in np.linspace(0.16, 0.24, KINDS)]
    arms, estimates = _each(_arms, 50.0, 60.0), _each(_estimate, 23.0, 25.0)
    competitors = {
        WRENCH: _tick({}),
        "contacts": _tick({"contacts": contacts}),
        "an estimate given again": _tick({"estimate": estimates[:1] * KINDS}),
        "an estimate": _tick({"estimate": estimates}),
        "the arms' limits": _tick({"arms": arms}),
        "where the arms may hold": _tick({"arms": [_arms(60.0, y) for y in np.linspace(0.16, 0.24, KINDS).tolist()]}),
        "all of them": _tick({"contacts": contacts, "estimate": estimates, "arms": arms}),
    }
    table = timed_table("New at each tick", interleave(competitors, rounds, BURST), WRENCH, "µs", {})
    stated = {
        "friction pyramids, skid and tip-over": _tick({}),
        "soft fingers of 8 sides instead of friction": _tick({}, _arms(60.0, soft_finger=PINCH)),
        "side force as a limit, too": _tick({}, cart_limits=(*LIMITS, SideForce(30.0))),
        "side force as an objective, too": _tick({}, objective=LeastSideForce()),
    }
    other = timed_table("By what is stated", interleave(stated, rounds, BURST), next(iter(stated)), "µs", {})
    return Result("What a tick costs", NOTE, (table, other))


def _tick(new: dict[str, Sequence[Any]], arms: list[Arm] | None = None, **stated: Any) -> Competitor:
    random = np.random.default_rng(0)
    wrenches = random.uniform((10.0, 0.0, -3.0), (40.0, 0.0, 3.0), (KINDS, 3))
    calls = [{name: values[k] for name, values in new.items()} for k in range(KINDS)]
    planner = WrenchPlanner(WHEELED, arms or _arms(60.0), **({"cart_limits": LIMITS} | stated))
    planner.warm_up()
    return lambda k: planner.plan_or_hold(wrenches[k % KINDS], **calls[k % KINDS])


def _each(make: Any, low: float, high: float) -> list[Any]:
    return [make(value) for value in np.linspace(low, high, KINDS).tolist()]


def _arms(force: float, y: float = 0.2, **hold: Any) -> list[Arm]:
    hold = hold or {"friction": Friction(0.6)}
    limits: dict[str, Any] = {"force_limit": (force, force, 40.0), "moment_limit": (8.0, 8.0, 6.0)}
    places = {"left": (-0.25, y, 1.0), "right": (-0.25, -y, 1.0)}
    return [Arm(name, [place], **hold, **limits) for name, place in places.items()]


def _estimate(mass: float) -> Estimate:
    cart = WHEELED.with_inertia(Inertia(mass, (0.3, 0.0), 2.0))
    return Estimate(0.0, Motion(np.zeros(3), np.array([0.3, 0.1])), {}, "", cart, cart.parameters)
