"""Contacts that a call fixes: the candidates that are left, and what is out of reach."""

from __future__ import annotations

from collections.abc import Mapping

from numpy.typing import ArrayLike

from cartgrasp.contacts import ContactSet

from ..contacts.contact_bounds import Candidates
from .plan_inputs import read_contacts
from .terms import Terms

REACH_TOLERANCE = 1e-9  # m


class GivenContacts:
    """Remembers what was last given, since a controller gives the same again."""

    def __init__(self, terms: Terms) -> None:
        self._terms, self._own = terms, terms.candidates
        self._given: dict[str, tuple[float, float, float]] = {}
        self._candidates = terms.candidates
        self.beyond: dict[str, float] = {}
        """By how much (m) contacts last given are out of their arms' reach."""

    @property
    def fits(self) -> bool:
        """Whether it still is for the terms, whose arms may be new."""
        return self._own is self._terms.candidates

    def candidates(self, contacts: Mapping[str, ArrayLike]) -> Candidates:
        """The candidates with some arms' contacts fixed; those of the last call where these are the same."""
        given = read_contacts(contacts, self._terms.base.names)
        if given != self._given:
            excess = {name: float(reach.excess(given[name])) for name, reach in self._terms.reaching(given)}
            self.beyond = {name: value for name, value in excess.items() if value > REACH_TOLERANCE}
            self._candidates, self._given = self._fixed_at(given), given
        return self._candidates

    def _fixed_at(self, given: dict[str, tuple[float, float, float]]) -> Candidates:
        own, sets = self._terms.candidates, self._terms.sets
        if not given:
            return own
        if len(given) == len(sets):
            return Candidates.at([given[name] for name in sets], own.distance)
        return Candidates.of(
            [ContactSet((given[name],)) if name in given else left for name, left in sets.items()], own.distance
        )
