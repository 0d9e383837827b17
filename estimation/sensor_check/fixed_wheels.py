"""Whether a cart that may go any way, by its file, rolls on fixed wheels all the same.

A cart on casters alone takes a sideways force of its mass times its sideways acceleration, in every turn. Fixed wheels
give that force themselves, whatever hands do, and the middle of their axle never goes sideways.
"""

from __future__ import annotations

import math

import numpy as np

from cartgrasp.model import CartModel

from ..weak_form.balances import Balances
from .evidence import independent_rows
from .heading import displacements
from .suspicion import TOLD, Suspicion
from .windows import Track
from .wrenches import ROW_STEPS, balances_of

ASIDE = 0.05
"""Largest share of its way by which a cart on fixed wheels seems to go sideways, by slip and noise."""
WRONG_ODDS = 0.2
"""That a cart which goes like that, by a file without constraints, has fixed wheels."""
ALIKE, UNLIKE = (0.0, 1.0), (3.0, 2.5)
"""Mean and standard deviation of the log of what sideways forces leave over what forward ones do, as squares: of
a cart that goes any way, by as good sensors, and of one that its wheels hold."""


def of_wheels(balances: Balances, cart: CartModel) -> tuple[Suspicion, ...]:
    """`frame` of a cart whose file lacks a constraint; none of carts that have one, and where too little is seen."""
    rolls = None if cart.constraints.n_rows else _axle(balances)
    if rolls is None:
        return ()
    known = next((found for step in ROW_STEPS if (found := balances_of(balances.every(step), cart))), None)
    if known is None:
        return ()
    forward, sideways, _ = known
    if sideways is None:
        return ()
    push, way = forward.as_recorded(), forward.motion
    mass = float(push @ way) / float(way @ way)
    ahead, aside = push - mass * way, sideways.as_recorded() - mass * sideways.motion
    ratio = float(aside @ aside) / float(ahead @ ahead) if ahead.any() else math.inf
    spread = math.sqrt(sum(2 / max(independent_rows(one), 1.0) for one in (ahead, aside)))
    log_odds = math.log(WRONG_ODDS) + _log_normal(ratio, UNLIKE, spread) - _log_normal(ratio, ALIKE, spread)
    probability = 1 / (1 + math.exp(-min(max(log_odds, -700.0), 700.0)))
    if probability < TOLD:
        return ()
    at = f"{round(rolls, 2) + 0.0:g}"
    words = (
        f"the cart rolls as on fixed wheels, the middle of whose axle is at x = {at} m, and its file lets it go "
        f"any way: add constraints: [{{no_lateral_slip: {{x: {at}}}}}]"
    )
    return (Suspicion("frame", "pose", probability, None, words),)


def _log_normal(ratio: float, of: tuple[float, float], spread: float) -> float:
    """Log density, but for a constant, of the log of a ratio that is known to a spread."""
    mean, std = of[0], math.hypot(of[1], spread)
    return -0.5 * ((math.log(max(ratio, 1e-9)) - mean) / std) ** 2 - math.log(std)


def _axle(balances: Balances) -> float | None:
    """Where on {b}'s x (m) a point hardly goes sideways; None where there is none, or nothing turns."""
    track = Track.of(balances.log)
    seen = displacements(track)
    if seen is None:
        return None
    _, across, size = seen
    if float(across @ across) > ASIDE**2 * size:
        return None
    c, s = np.cos(track.heading), np.sin(track.heading)
    sideways = c[:-1] * np.diff(track.y) - s[:-1] * np.diff(track.x)
    turned = np.diff(track.heading)
    if not turned @ turned > 0.0:
        return None
    return -float(turned @ sideways) / float(turned @ turned)
