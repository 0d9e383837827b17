"""What a study found: tables, claims with our figure beside them, and what JSON says."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

CLAIM_COLUMNS = ("where", "claim", "our figure", "holds")


@dataclass(frozen=True)
class Claim:
    """A claim, our figure beside it, and whether it holds; `promised` says whether a study fails when it does not."""

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


@dataclass(frozen=True)
class Section:
    """A table; its first `left` columns are text."""

    title: str
    columns: Sequence[str]
    rows: Sequence[Sequence[str]]
    left: int = 1

    @classmethod
    def of_claims(cls, title: str, claims: Sequence[Claim]) -> Section:
        return cls(title, CLAIM_COLUMNS, [claim.cells for claim in claims], left=3)

    @property
    def markdown(self) -> str:
        """For docs/results."""
        lines = [self.columns, ["---"] * len(self.columns), *self.rows]
        return f"## {self.title}\n\n" + "".join(f"| {' | '.join(line)} |\n" for line in lines)


@dataclass(frozen=True)
class Findings:
    """`document` is what JSON says beside promises and place, `promised` what the exit status is about."""

    heading: str
    sections: Sequence[Section]
    document: dict[str, Any]
    promised: Sequence[Claim]
