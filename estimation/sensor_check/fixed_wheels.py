"""Whether a cart rolls on fixed wheels as its file says: on none, or about an axle elsewhere.

A cart on casters alone takes a sideways force of its mass times its sideways acceleration, in every turn. Fixed wheels
give that force themselves, whatever hands do, and the middle of their axle never goes sideways.
"""

from __future__ import annotations

import math

from cartgrasp.model import CartModel

from ..weak_form.balances import Balances
from .axle import MAX_SIDESLIP_RATIO, axle_suspicion
from .evidence import independent_rows
from .heading import Displacements, displacements
from .suspicion import REPORT_PROBABILITY, Suspicion
from .windows import Track
from .wrenches import WRENCH_CHECK_ROW_STEPS, balances_of

FIXED_WHEELS_ODDS = 0.2
"""That a cart which goes like that, by a file without constraints, has fixed wheels."""
FREE_CART_LOG_RATIO, FIXED_WHEELS_LOG_RATIO = (0.0, 1.0), (3.0, 2.5)
"""Mean and standard deviation of the log of what sideways forces leave over what forward ones do, as squares: of
a cart that goes any way, by as good sensors, and of one that its wheels hold."""


def wheel_suspicions(balances: Balances, cart: CartModel) -> tuple[Suspicion, ...]:
    """`frame` of a cart whose file lacks the constraint of its wheels, `offset` of one whose axle is elsewhere; none of
    carts that can't turn, and where too little is seen."""
    seen = displacements(Track.of(balances.log))
    if (
        seen is None
        or cart.constraints.no_rotation
        or float(seen.across @ seen.across) > MAX_SIDESLIP_RATIO**2 * seen.size
    ):
        return ()
    told_x = cart.constraints.axle_x
    if told_x is not None:
        found = axle_suspicion(seen.axle, float(told_x), seen.axle_std, REPORT_PROBABILITY)
        return () if found is None else (found,)
    return _lacking(seen, balances, cart) if math.isfinite(seen.axle_std) else ()


def _lacking(seen: Displacements, balances: Balances, cart: CartModel) -> tuple[Suspicion, ...]:
    known = next((found for step in WRENCH_CHECK_ROW_STEPS if (found := balances_of(balances.every(step), cart))), None)
    if known is None or known[1] is None:
        return ()
    forward, sideways = known[0], known[1]
    push, way = forward.as_recorded(), forward.motion
    mass = float(push @ way) / float(way @ way)
    ahead, aside = push - mass * way, sideways.as_recorded() - mass * sideways.motion
    ratio = float(aside @ aside) / float(ahead @ ahead) if ahead.any() else math.inf
    spread = math.sqrt(sum(2 / max(independent_rows(one), 1.0) for one in (ahead, aside)))
    log_odds = (
        math.log(FIXED_WHEELS_ODDS)
        + _log_normal(ratio, FIXED_WHEELS_LOG_RATIO, spread)
        - _log_normal(ratio, FREE_CART_LOG_RATIO, spread)
    )
    probability = 1 / (1 + math.exp(-min(max(log_odds, -700.0), 700.0)))
    if probability < REPORT_PROBABILITY:
        return ()
    at = f"{round(seen.axle, 2) + 0.0:g}"
    words = (
        f"the cart rolls as on fixed wheels, the middle of whose axle is at x = {at} m, and its file lets it go "
        f"any way: add constraints: [{{no_lateral_slip: {{x: {at}}}}}]"
    )
    return (Suspicion("frame", "pose", probability, None, words),)


def _log_normal(ratio: float, of: tuple[float, float], spread: float) -> float:
    """Log density, but for a constant, of the log of a ratio that is known to a spread."""
    mean, std = of[0], math.hypot(of[1], spread)
    return -0.5 * ((math.log(max(ratio, 1e-9)) - mean) / std) ** 2 - math.log(std)
