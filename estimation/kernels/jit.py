"""How the estimators' kernels are compiled."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from cartgrasp.compiling import F, cached_as, digest_of

Indices = NDArray[np.int64]
WITH_ARRAYS: dict[str, Any] = {"error_model": "numpy"}
entry = cached_as(digest_of(Path(__file__).parent), WITH_ARRAYS)


def compiled(function: F) -> F:
    """For kernels that kernels call."""
    return njit(function, **WITH_ARRAYS)  # type: ignore[no-any-return]
