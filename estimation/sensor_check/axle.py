"""Whether the axle of a cart's fixed wheels is where its file says, by the point that is seen never to go sideways."""

from __future__ import annotations

from .evidence import gross_error_probability
from .suspicion import Suspicion

MAX_SIDESLIP_RATIO = 0.05
"""Largest share of its way by which a cart on fixed wheels seems to go sideways, by slip and noise."""
SOUND_AXLE_STD, WRONG_AXLE_STD, WRONG_AXLE_ODDS = 0.02, 0.3, 0.05
"""Standard deviations (m) of how far a sound file's axle is from where it is, and a wrong one's; one file in twenty."""


def axle_suspicion(axle_x: float, told_x: float, std: float, least: float) -> Suspicion | None:
    """`offset` of an axle that is seen at `axle_x` to a standard deviation, and told at another x in {b} (m); None
    where it is less probable than `least`."""
    off = axle_x - told_x
    probability = gross_error_probability(off, std, SOUND_AXLE_STD, WRONG_AXLE_STD, WRONG_AXLE_ODDS)
    if probability < least:
        return None
    words = (
        f"what never goes sideways is at x = {round(axle_x, 3) + 0.0:g} m, and the file has the axle at {told_x:g} m: "
        f"mend no_lateral_slip, or where {{b}} is in the frame that is tracked ({off:+.3f} m)"
    )
    return Suspicion("offset", "pose", probability, off, words)
