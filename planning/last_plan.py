"""What `WrenchPlanner` remembers of its last plan."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from cartgrasp.errors import UsageError
from cartgrasp.frames import Array

from .switching_cost import SAME_PLACE


class LastPlan:
    """`wrenches` (6n,), zero at first; `contacts` (n, 3) that are held, NaN where nothing is; and `choice` (n, 3), the
    contacts last chosen among the arms' own."""

    def __init__(self, n_arms: int) -> None:
        self.wrenches = np.zeros(6 * n_arms)
        self.contacts = np.full((n_arms, 3), np.nan)
        self.choice: Array | None = None

    def started(
        self, names: Sequence[str], wrenches: Mapping[str, ArrayLike], contacts: Mapping[str, ArrayLike]
    ) -> Self:
        """With these wrenches (6,), of arms left out zero, and contacts (3,), of arms left out as they are."""
        other = type(self)(len(names))
        other.wrenches = _put(np.zeros((len(names), 6)), names, wrenches, "wrenches").ravel()
        other.contacts = _put(self.contacts.copy(), names, contacts, "contacts")
        other.choice = self.choice
        return other

    def contacts_or(self, first: Array) -> Array:
        """The contacts held, else `first` (n, 3)."""
        return np.where(np.isnan(self.contacts), first, self.contacts)

    def moving_to(self, contacts: Array, names: Sequence[str]) -> tuple[str, ...]:
        """Which of the arms hold elsewhere at the contacts (n, 3); none of those that held nothing."""
        if contacts is self.contacts:
            return ()
        moving = np.flatnonzero((np.abs(contacts - self.contacts) > SAME_PLACE).any(axis=1))
        return tuple(names[i] for i in moving.tolist())


def _put(rows: Array, names: Sequence[str], values: Mapping[str, ArrayLike], what: str) -> Array:
    """Rows by arm with some replaced."""
    for i, name in enumerate(names):
        rows[i] = values.get(name, rows[i])
    if not set(values) <= set(names) or not np.isfinite(rows[[name in values for name in names]]).all():
        raise UsageError(f"start_from: {dict(values)} are not finite {what} of {', '.join(names)}")
    return rows
