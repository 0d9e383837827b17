"""How the planner's kernels are compiled."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from cartgrasp.compiling import OPTIONS, F, cached_as, digest_of, inner

# Sums may be reordered, which lets loops be vectorised; infinite limits and NaN keep their meaning.
QUICK: dict[str, Any] = {**OPTIONS, "fastmath": {"reassoc", "contract", "nsz"}}
DIGEST = digest_of(Path(__file__).parent)
entry = cached_as(DIGEST, QUICK)


def compiled(function: F) -> F:
    """For kernels that kernels call."""
    return inner(function, QUICK)
