"""Contacts that stay."""

from __future__ import annotations

from collections.abc import Sequence
from typing import final

from cartgrasp.arms import Arm
from cartgrasp.roles import ContactChoice, ContactQuery


@final
class FixedContacts:
    """Every arm keeps its first candidate."""

    def __init__(self, arms: Sequence[Arm]) -> None:
        self._choice = ContactChoice({arm.name: arm.contacts.first for arm in arms}, "fixed")

    def contacts(self, query: ContactQuery) -> ContactChoice:
        return self._choice
