"""A claim, our figure beside it, and whether it holds."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

CLAIM_COLUMNS = ("where", "claim", "our figure", "holds")


@dataclass(frozen=True)
class Claim:
    """`promised` says whether a study fails when the claim does not hold."""

    what: str
    claim: str
    figure: str
    holds: bool
    promised: bool = True

    @property
    def cells(self) -> tuple[str, str, str, str]:
        """By CLAIM_COLUMNS."""
        return self.what, self.claim, self.figure, "yes" if self.holds else "no"

    def as_dict(self) -> dict[str, Any]:
        return asdict(self)


def all_kept(claims: Sequence[Claim]) -> bool:
    return all(claim.holds for claim in claims if claim.promised)


def markdown_table(columns: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table for docs/results."""
    lines = [" | ".join(columns), " | ".join(["---"] * len(columns)), *(" | ".join(row) for row in rows)]
    return "\n".join(f"| {line} |" for line in lines) + "\n"
