"""How the estimators' kernels are compiled."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from cartgrasp.compiling import JIT_OPTIONS, F, cached_as, digest_of, inner
from cartgrasp.kernels.jit import DIGEST

Indices = NDArray[np.int64]
KERNELS_DIGEST = f"{digest_of(Path(__file__).parent)}_{DIGEST}"
entry = cached_as(KERNELS_DIGEST, JIT_OPTIONS)
"""Entries hold code of the cart's kernels, too."""
WITH_ARRAYS = JIT_OPTIONS | {"_nrt": True}
row_entry = cached_as(KERNELS_DIGEST, WITH_ARRAYS)
"""Compiles what is called ten times a second, and may make arrays."""


def compiled(function: F) -> F:
    """Compiles a kernel that only kernels call, and that makes no arrays."""
    return inner(function, JIT_OPTIONS)


def row_compiled(function: F) -> F:
    """Compiles a kernel that those of rows call. It may call those that make no arrays, but for what these give back:
    only numbers are safe, since nobody counts references to arrays."""
    return inner(function, WITH_ARRAYS)
