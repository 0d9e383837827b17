"""How the planner's kernels are compiled."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from cartgrasp.compiling import JIT_OPTIONS, F, cached_as, digest, digest_of, inner
from cartgrasp.contacts import MAX_POSITION

# Sums may be reordered, which lets loops be vectorised; infinite limits and NaN keep their meaning.
QUICK: dict[str, Any] = {**JIT_OPTIONS, "fastmath": {"reassoc", "contract", "nsz"}}
DIGEST = f"{digest_of(Path(__file__).parent)}_{digest([repr(MAX_POSITION).encode()])}"
"""The digest of the kernels' sources, and of a constant that they import."""
entry = cached_as(DIGEST, QUICK)


def compiled(function: F) -> F:
    """Compiles a kernel that only kernels call."""
    return inner(function, QUICK)
