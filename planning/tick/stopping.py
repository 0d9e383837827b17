"""What is given where limits on the floor leave a cart no way to come to rest.

A cart without hands rolls on, and limits that its free motion breaks would have it pushed without end. So limits, with
the margins of a `confidence`, are kept as far as they leave what stops the cart: of the margins the largest of these
shares. What is asked and can't be given is brought as near as that leaves: the nearest wrench within a convex set that
holds a gentle stop is never on the other side of it. Where nothing near may be given, the cart is stopped: gently where
the limits leave no other stop, and beyond them where they leave none. From tick to tick the share grows by one step at
most, so that few programs are solved.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from numpy.typing import ArrayLike

from cartgrasp.frames import Array

from ..plan import Figures, Plan
from ..quadratic_program import INFEASIBLE, OPTIMAL
from .last_plan import LastPlan
from .tick_state import TickState

MARGIN_FRACTIONS = (1.0, 0.75, 0.5, 0.25)
WITHIN_BELIEVED_LIMITS, BEYOND_LIMITS = "within its limits as it is believed to be", "beyond its limits"
GENTLE_RATE_RATIO = 0.25
"""A share of the usual rate at which velocities fade: what limits have to leave."""
Stop = Callable[[float], ArrayLike]
"""The wrench (3,) under which the cart's velocities fade at a share of the usual rate; at rest that is none."""


class Stopping(NamedTuple):
    """What is done for the cart of `now`, from what was given last, `before` this tick, within a `share` of its
    margins; `plan` plans a wrench (3,) for what `now` keeps, and with `exact` does not look for the nearest."""

    now: TickState
    before: LastPlan
    share: float
    stop: Stop
    plan: Callable[[ArrayLike, bool], Plan]

    def of(self, found: Plan, asked: ArrayLike) -> Plan:
        """In the place of a plan that does not give what was asked, (3,)."""
        after = self.now.last
        try:
            gentle = self._kept(None, self.stop(GENTLE_RATE_RATIO)).cart_wrench
            share = self._whole if gentle is None else self._largest_share(gentle)[0]
            if share == self._whole:
                self.now.go_back_to(after)
                near = found
            else:
                near = _without_wrenches(found) if share is None else self._near(share, asked)
            return near if near.is_usable else Plan.of(vars(near) | self._stopped(gentle, share))
        finally:
            self.now.terms.keep(1.0)

    def _near(self, share: float, asked: ArrayLike) -> Plan:
        near = self._kept(share, asked)
        kept = {"stops": f"keeps {100 * share:g} % of its margins"} if near.is_usable else {}
        return Plan.of(vars(near) | kept)

    def _stopped(self, gentle: Array | None, share_of_gentle: float | None) -> dict[str, Any]:
        """What the fields of a plan are where no wrench is within the limits, or may be near what is asked; nothing
        where no stop is found. `gentle` is the gentle stop (3,), which a share of the margins leaves."""
        found = self._kept(None, self.stop(1.0))
        free = self.now.last
        if found.cart_wrench is None:
            return {}
        share, within = self._largest_share(found.cart_wrench)
        if share is None and gentle is not None and share_of_gentle is not None:
            share, within = share_of_gentle, self._kept(share_of_gentle, gentle, exact=True)
        if share is None:
            self.now.go_back_to(free)
            return {"held": found.contact_wrenches, "stops": f"stops the cart {BEYOND_LIMITS}"}
        words = f"within {100 * share:g} % of its margins" if share else WITHIN_BELIEVED_LIMITS
        return {"held": within.contact_wrenches, "stops": f"stops the cart {words}"}

    @property
    def _whole(self) -> float:
        return MARGIN_FRACTIONS[0] if self.now.terms.has_margins else 0.0

    def _kept(self, share: float | None, wanted: ArrayLike, exact: bool = False) -> Plan:
        self.now.go_back_to(self.before)
        self.now.terms.keep(share)
        return self.plan(wanted, exact)

    def _largest_share(self, wanted: ArrayLike) -> tuple[float | None, Plan]:
        """How much of the margins lets a wrench (3,) be given, with its plan, which was planned last; None where the
        limits forbid it."""
        shares = (*MARGIN_FRACTIONS, 0.0) if self.now.terms.has_margins else (0.0,)
        first = max(0, shares.index(self.share) - 1) if self.share in shares else 0
        share, within = self._first_of(shares[first : first + 2], wanted)
        others = shares[first + 2 :]
        if share is None and others and self._first_of(others[-1:], wanted)[0] is not None:  # else none of them does
            share, within = self._first_of(others, wanted)
        self.now.stop_share = 0.0 if share is None else share
        return share, within

    def _first_of(self, shares: tuple[float, ...], wanted: ArrayLike) -> tuple[float | None, Plan]:
        for share in shares:
            within = self._kept(share, wanted, exact=True)
            if within.status == OPTIMAL:
                return share, within
        return None, within


def _without_wrenches(found: Plan) -> Plan:
    """Infeasible, for the same reasons."""
    kept = vars(found).keys() & {"certificate", "message", "found_why", "solve_time", "solver"}
    blank = {"status": INFEASIBLE, "wrenches": {}, "contacts": {}, "yaws": {}, "tell": Figures}
    return Plan.of(blank | {name: vars(found)[name] for name in kept})
