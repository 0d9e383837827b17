"""How the cart's kernels are compiled."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from cartgrasp.compiling import OPTIONS, F, cached_as, digest_of

Ints = NDArray[np.int64]

INNER: dict[str, Any] = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}
DIGEST = digest_of(Path(__file__).parent)
entry = cached_as(DIGEST, OPTIONS)


def compiled(function: F) -> F:
    """For kernels that kernels call. What they are given is a hundred numbers of views: to hand it over costs more than
    the arithmetic, so they are put where they are called."""
    return njit(function, forceinline=True, **OPTIONS, **INNER)  # type: ignore[no-any-return]


def inlined(function: F) -> F:
    """For kernels that a kernel calls at one place: they are compiled once, with it."""
    return njit(function, inline="always", **OPTIONS)  # type: ignore[no-any-return]
