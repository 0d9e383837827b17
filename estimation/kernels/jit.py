"""How the estimators' kernels are compiled."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from cartgrasp.compiling import F, cached_as, digest_of

Indices = NDArray[np.int64]
WITH_ARRAYS: dict[str, Any] = {"error_model": "numpy"}
OWN = digest_of(Path(__file__).parent)
entry = cached_as(OWN, WITH_ARRAYS)


def entry_with(others: str) -> Callable[[F], F]:
    """For entries that hold code of kernels elsewhere, of which a digest is given, too."""
    return cached_as(f"{OWN}_{others}", WITH_ARRAYS)


def compiled(function: F) -> F:
    """For kernels that kernels call."""
    return njit(function, **WITH_ARRAYS)  # type: ignore[no-any-return]
