"""Whether a hand may let go: whether the others bear the cart's path without it, or the cart coasts near it."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from cartgrasp.frames import Array, wrap_angle
from cartgrasp.simulation.integrate import held

from ..quadratic_program import OPTIMAL
from ..schedule.schedule import wanted_wrench

if TYPE_CHECKING:
    from collections.abc import Mapping

    from cartgrasp.model import CartModel
    from cartgrasp.motion import Estimate, Motion
    from cartgrasp.roles import ReferencePath

    from ..planner import WrenchPlanner
    from ..tick.stopping import Stop

LOOKAHEAD_PLANS = 6
"""Times within a regrasp at which the others' plans are made ahead."""
COAST_STEP = 0.01  # s


class Ahead(NamedTuple):
    """What is known of the time to come: the reference, the cart as it is believed to be and to move at `time` (s), and
    the wrench (3,) in {b} that it is to feel now; `estimate`, and what would `stop` it, are for planners with limits of
    the cart."""

    reference: ReferencePath
    cart: CartModel
    motion: Motion
    time: float
    wrench_b: Array
    estimate: Estimate | None = None
    stop: Stop | None = None


def why_others_cannot(planner: WrenchPlanner, contacts: Mapping[str, Array], ahead: Ahead, lasting: float) -> str:
    """In words, what of the next `lasting` s is too much for the arms of `planner` at `contacts`; empty if nothing."""
    times = ahead.time + np.linspace(0.0, lasting, LOOKAHEAD_PLANS)
    wrenches = [ahead.wrench_b, *(wanted_wrench(ahead.reference, ahead.cart, time) for time in times.tolist())]
    for wrench in wrenches:
        if planner.plan_or_hold(wrench, contacts, ahead.estimate, stop=ahead.stop).status != OPTIMAL:
            force, moment = float(np.hypot(*wrench[:2])), float(wrench[2])
            return f"the others can't bear {force:.0f} N with {moment:.1f} N·m"
    return ""


def why_cart_cannot_coast(ahead: Ahead, lasting: float, drift: float) -> str:
    """In words, by how much a cart that nobody holds for `lasting` s leaves its path beyond `drift` (m; rad as at 1 m);
    empty if it does not."""
    steps = max(1, round(lasting / COAST_STEP))
    state = ahead.cart.state(ahead.motion.pose_sb, ahead.motion.velocity)
    there = held(ahead.cart, state, np.zeros(3), ahead.time, (lasting / steps, steps))[:3]
    wanted = ahead.reference.at(ahead.time + lasting).pose_sb
    off = max(float(np.hypot(*(there - wanted)[:2])), abs(float(wrap_angle(there[2] - wanted[2]))))
    return "" if off <= drift else f"the cart would coast {off:.2f} m off its path in {lasting:.1f} s"
