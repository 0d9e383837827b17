"""How the estimators' kernels are compiled."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numba import njit
from numpy.typing import NDArray

from cartgrasp.compiling import OPTIONS, F, cached_as, digest_of
from cartgrasp.kernels.jit import DIGEST

Indices = NDArray[np.int64]
entry = cached_as(f"{digest_of(Path(__file__).parent)}_{DIGEST}", OPTIONS)
"""Entries hold code of the cart's kernels, too."""


def compiled(function: F) -> F:
    """For kernels that kernels call."""
    return njit(function, **OPTIONS)  # type: ignore[no-any-return]
