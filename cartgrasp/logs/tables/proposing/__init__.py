"""A map proposed for a table, from its names, its units and what physics says of its numbers."""

from .proposal import Proposal, propose

__all__ = ["Proposal", "propose"]
