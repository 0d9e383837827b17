"""Contacts that teach what is asked for while it is not known, and cost least after that.

At each choice every combination of the arms' points is judged by the time ahead: which standard deviations of the
parameters asked for it leaves, by the Fisher information with the sensors' noise at the lever arms, and what it costs.
Of those within the effort allowed, the one is taken that lowers the product of the deviations most; once all are as
small as asked, the one of least effort. A regrasp has to be worth its own cost in both.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import final

import numpy as np

from cartgrasp.arms import Arm
from cartgrasp.first_guess import PHYSICAL_NAMES
from cartgrasp.frames import Array
from cartgrasp.inertia import N_PHI, physical_jacobian
from cartgrasp.information import covariance_after
from cartgrasp.model import CartModel
from cartgrasp.motion import Estimate
from cartgrasp.roles import ContactChoice, ContactQuery, ReferencePath

from ..control.hand import RegraspTimes
from .choosing import Choosing
from .lookahead import ContactFamily, Lookahead

MIN_INFORMATION_GAIN = 0.1
"""The least decrease of the log of the product of standard deviations that is worth a regrasp."""
FREE_EFFORT = 1.0
"""N² that may be spent wherever nothing is needed."""
MIN_LOOKAHEAD = 0.2  # s of the reference that are worth a choice
FOR_LEAST_EFFORT, NO_CONTACTS = "least effort", "no contacts can drive the time ahead"


@final
class TeachingContacts:
    """Chooses among the arms' points; segments are refused. `choosing` says what is asked for, and at which cost."""

    def __init__(
        self, cart: CartModel, arms: Sequence[Arm], reference: ReferencePath, choosing: Choosing, regrasp: RegraspTimes
    ) -> None:
        self._family = ContactFamily.of(cart, arms, choosing.noise, choosing.min_hand_distance)
        self._reference, self._choosing, self._cart, self._times = reference, choosing, cart, regrasp
        self._chosen, self._due = ContactChoice(self._family.contacts(0), FOR_LEAST_EFFORT), -np.inf

    def warm_up(self) -> None:
        self._family.planner.warm_up()

    def contacts(self, query: ContactQuery) -> ContactChoice:
        stop = min(query.time + self._choosing.ahead, self._reference.duration)
        is_over = stop - query.time < MIN_LOOKAHEAD
        if is_over and self._due == -np.inf and query.held:
            return self._chosen._replace(contacts=query.held)
        if is_over or query.time < self._due - 1e-9:
            return self._chosen
        held = self._family.index_of(query.held)
        if held is None and query.held:
            return self._chosen  # a hand is on its way
        self._due = query.time + self._choosing.every
        cart = self._cart if query.estimate is None else query.estimate.cart()
        lookahead = self._family.ahead(cart, self._reference, (query.time, stop))
        left = self._reference.duration - query.time  # for which the time ahead stands
        charges = lookahead.regrasps(held, self._times, self._choosing.regrasp_effort) / left
        self._chosen = self._choose(lookahead, query.estimate, charges, held)
        return self._chosen

    def _choose(
        self, lookahead: Lookahead, estimate: Estimate | None, charges: Array, held: int | None
    ) -> ContactChoice:
        cheapest = lookahead.cheapest(charges)
        if cheapest is None:
            return ContactChoice(self._chosen.contacts if held is None else self._family.contacts(held), NO_CONTACTS)
        wanted = {} if estimate is None else self._not_known(estimate)
        if estimate is None or estimate.covariance is None or not wanted:
            return ContactChoice(self._family.contacts(cheapest), FOR_LEAST_EFFORT)
        asked = np.array([PHYSICAL_NAMES.index(name) for name in wanted])
        after = self._deviations(estimate, covariance_after(estimate.covariance, lookahead.taught))[:, asked]
        merits = np.log(after).sum(axis=1)
        budget = (1 + self._choosing.extra_effort) * (lookahead.effort(cheapest) + charges[cheapest]) + FREE_EFFORT
        best = self._most_taught(lookahead, merits, charges, budget)
        if held is not None and merits[held] - merits[best] < MIN_INFORMATION_GAIN and lookahead.effort(held) <= budget:
            best = held
        falls = self._deviations(estimate, estimate.covariance)[asked] / after[best]
        return ContactChoice(self._family.contacts(best), f"teaches {list(wanted)[int(falls.argmax())]}")

    def _most_taught(self, lookahead: Lookahead, merits: Array, charges: Array, budget: float) -> int:
        """The choice that teaches most within a budget (N²), which at least one is."""
        lowest = lookahead.lowest + charges
        order = np.lexsort((lowest, np.round(merits, 3)))
        within = (c for c in order.tolist() if lowest[c] <= budget and lookahead.effort(c) + charges[c] <= budget)
        return int(next(within))

    def _not_known(self, estimate: Estimate) -> dict[str, float]:
        """The parameters whose deviation is above what was asked for, with that."""
        told = estimate.parameters
        return {name: std for name, std in self._choosing.asked.items() if name in told and told[name].std > std}

    def _deviations(self, estimate: Estimate, covariance: Array) -> Array:
        """Standard deviations of mass, CoM and inertia (..., 4), from the parameters' covariance (..., p, p)."""
        partials = physical_jacobian(estimate.model_parameters[:N_PHI])
        variances = np.einsum("ij,...jk,ik->...i", partials, covariance[..., :N_PHI, :N_PHI], partials)
        return np.asarray(np.sqrt(np.maximum(variances, np.finfo(float).tiny)))
