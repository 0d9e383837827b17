"""What `WrenchPlanner` remembers of its last plan."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple, Self

import numpy as np
from numpy.typing import ArrayLike

from cartgrasp.errors import UsageError
from cartgrasp.frames import Array

from ..contacts.switching_cost import SAME_CONTACT_DISTANCE
from .plan_inputs import RefusedError, read_contacts, read_start


class LastPlan(NamedTuple):
    """`wrenches` (6n,), zero at first; `contacts` (n, 3) that are held, NaN where nothing is; and `choice` (n, 3), the
    contacts last chosen among the arms' own."""

    wrenches: Array
    contacts: Array
    choice: Array | None = None

    @classmethod
    def none(cls, n_arms: int) -> Self:
        """Before the first plan."""
        return cls(np.zeros(6 * n_arms), np.full((n_arms, 3), np.nan))

    def among(self, before: Sequence[str], names: Sequence[str]) -> Self:
        """The last plan for the arms `names`: those that are among `before` keep their wrenches and contacts."""
        other = self.none(len(names))
        for i, name in enumerate(names):
            if name in before:
                k = before.index(name)
                other.wrenches[6 * i : 6 * i + 6] = self.wrenches[6 * k : 6 * k + 6]
                other.contacts[i] = self.contacts[k]
        return other

    def started(
        self, names: Sequence[str], wrenches: Mapping[str, ArrayLike], contacts: Mapping[str, ArrayLike]
    ) -> Self:
        """A last plan with these wrenches (6,) and contacts (3,) by arm. An arm that is left out has a zero wrench, or
        keeps its contact."""
        begun = read_start(wrenches, names)
        try:
            held = read_contacts(contacts, names)
        except RefusedError as error:
            raise UsageError(f"start_from: {error}") from error
        points = np.array([held.get(name, now) for name, now in zip(names, self.contacts, strict=True)])
        return type(self)(begun, points, self.choice)

    def contacts_or(self, first: Array) -> Array:
        """The contacts held, else `first` (n, 3)."""
        return np.where(np.isnan(self.contacts), first, self.contacts)

    def moving_to(self, contacts: Array, names: Sequence[str]) -> tuple[str, ...]:
        """Which of the arms hold elsewhere at the contacts (n, 3); none of those that held nothing."""
        if contacts is self.contacts:
            return ()
        moving = np.flatnonzero((np.abs(contacts - self.contacts) > SAME_CONTACT_DISTANCE).any(axis=1))
        return tuple(names[i] for i in moving.tolist())
