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

SHARES = (1.0, 0.75, 0.5, 0.25)
AS_BELIEVED, BEYOND = "within its limits as it is believed to be", "beyond its limits"
GENTLY = 0.25
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
        near = self._nearest(found, asked)
        if near.is_usable:
            return near
        stopped = self._stopped()
        return near if stopped is None else Plan.of(vars(near) | stopped)

    def _stopped(self) -> dict[str, Any] | None:
        """What the fields of a plan are where no wrench is within the limits, or may be near what is asked. None where
        none is found."""
        try:
            found = self._kept(None, self.stop(1.0))
            free = self.now.last
            if found.cart_wrench is None:
                return None
            for wanted in (found.cart_wrench, self._gentle):
                share, within = (None, found) if wanted is None else self._largest_share(wanted)
                if share is not None:
                    words = f"within {100 * share:g} % of its margins" if share else AS_BELIEVED
                    return {"held": within.contact_wrenches, "stops": f"stops the cart {words}"}
            self.now.go_back_to(free)
            return {"held": found.contact_wrenches, "stops": f"stops the cart {BEYOND}"}
        finally:
            self.now.keep(1.0)

    def _nearest(self, found: Plan, asked: ArrayLike) -> Plan:
        """The plan that was found where the limits leave a gentle stop; else one that keeps as much of the margins as
        leaves it; one without wrenches where the limits themselves don't."""
        after = self.now.last
        try:
            gentle = self._gentle
            share = self._whole if gentle is None else self._largest_share(gentle)[0]
            if share == self._whole:
                self.now.go_back_to(after)
                return found
            if share is None:
                return _without_wrenches(found)
            near = self._kept(share, asked)
            kept = {"stops": f"keeps {100 * share:g} % of its margins"} if near.is_usable else {}
            return Plan.of(vars(near) | kept)
        finally:
            self.now.keep(1.0)

    @property
    def _whole(self) -> float:
        return SHARES[0] if self.now.terms.has_margins else 0.0

    def _kept(self, share: float | None, wanted: ArrayLike, exact: bool = False) -> Plan:
        self.now.go_back_to(self.before)
        self.now.keep(share)
        return self.plan(wanted, exact)

    def _largest_share(self, wanted: ArrayLike) -> tuple[float | None, Plan]:
        """How much of the margins lets a wrench (3,) be given, with its plan; None where the limits forbid it."""
        shares = (*SHARES, 0.0) if self.now.terms.has_margins else (0.0,)
        first = max(0, shares.index(self.share) - 1) if self.share in shares else 0
        for share in shares[first:]:
            within = self._kept(share, wanted, exact=True)
            if within.status == OPTIMAL:
                self.now.stop_share = share
                return share, within
        return None, within

    @property
    def _gentle(self) -> Array | None:
        """What stops the cart gently, (3,), as far as the arms can give it."""
        return self._kept(None, self.stop(GENTLY)).cart_wrench


def _without_wrenches(found: Plan) -> Plan:
    """Infeasible, for the same reasons."""
    kept = vars(found).keys() & {"certificate", "message", "explain", "solve_time", "solver"}
    blank = {"status": INFEASIBLE, "wrenches": {}, "contacts": {}, "yaws": {}, "tell": Figures}
    return Plan.of(blank | {name: vars(found)[name] for name in kept})
