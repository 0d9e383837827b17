"""What stops a cart whose limits on the floor no wrench keeps, as far within these as that leaves.

A cart without hands rolls on, and may be beyond its limits for longer. So the cart is brought to rest, by what the arms
can give. Of the margins of a `confidence` the largest of these shares is kept that leaves this; where it is beyond the
limits for the cart as believed, the nearest within these is given, and where nothing is within, the wrench itself. From
tick to tick the share grows by one step at most, so that few programs are solved.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from numpy.typing import ArrayLike

from cartgrasp.shallow_copy import shallow_copy

from ..plan import Plan
from ..quadratic_program import OPTIMAL
from .tick_state import TickState

SHARES = (1.0, 0.75, 0.5, 0.25)
AS_BELIEVED, BEYOND = "within its limits as it is believed to be", "beyond its limits"


def stopping_plan(now: TickState, wrench: ArrayLike, plan: Callable[[ArrayLike, bool], Plan]) -> dict[str, Any] | None:
    """What the fields of a plan are then; `plan` plans a wrench (3,) for what `now` keeps, and looks for the nearest if
    it need not be exact. None where none is found."""
    before, shares = shallow_copy(now.last), (*SHARES, 0.0) if now.terms.has_margins else (0.0,)
    first = max(0, shares.index(now.stop_share) - 1) if now.stop_share in shares else 0

    def kept(share: float | None, wanted: ArrayLike) -> Plan:
        now.go_back_to(before)
        now.keep(share)
        return plan(wanted, bool(share))

    try:
        found, words = kept(None, wrench), BEYOND
        free, wanted = shallow_copy(now.last), found.cart_wrench
        if wanted is None:
            return None
        for share in shares[first:]:
            within = kept(share, wanted)
            if within.status == OPTIMAL or (share == 0.0 and within.is_usable):
                found, now.stop_share = within, share
                words = f"within {100 * share:g} % of its margins" if share else AS_BELIEVED
                break
        else:
            now.go_back_to(free)
    finally:
        now.keep(1.0)
    return {"held": found.contact_wrenches, "stops": f"stops the cart {words}"}
