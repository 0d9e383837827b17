"""How the cart's kernels are compiled."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from cartgrasp.compiling import JIT_OPTIONS, F, cached_as, digest_of, inner

Ints = NDArray[np.int64]

DIGEST = digest_of(Path(__file__).parent)
entry = cached_as(DIGEST, JIT_OPTIONS)


def compiled(function: F) -> F:
    """For kernels that kernels call."""
    return inner(function, JIT_OPTIONS)
