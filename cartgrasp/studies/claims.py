"""A claim, our figure beside it, and whether it holds."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any


@dataclass(frozen=True)
class Claim:
    """`promised` says whether a study fails when the claim does not hold."""

    what: str
    claim: str
    figure: str
    holds: bool
    promised: bool = True

    def as_dict(self) -> dict[str, Any]:
        return asdict(self)


def all_kept(claims: Sequence[Claim]) -> bool:
    return all(claim.holds for claim in claims if claim.promised)


def markdown_table(columns: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table for docs/results."""
    lines = [" | ".join(columns), " | ".join(["---"] * len(columns)), *(" | ".join(row) for row in rows)]
    return "\n".join(f"| {line} |" for line in lines) + "\n"
