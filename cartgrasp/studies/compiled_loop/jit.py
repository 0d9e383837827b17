"""How the loop's kernels are compiled: they hold code of the cart's, the estimator's and the planner's."""

from __future__ import annotations

from pathlib import Path

from estimation.online.kernels.jit import KERNELS_DIGEST as ESTIMATION
from estimation.online.kernels.jit import compiled, row_compiled
from planning import steering
from planning.kernels.jit import DIGEST as PLANNING

from ...compiling import JIT_OPTIONS, cached_as, digest

LOOP_SOURCES = (
    Path(steering.__file__),
    *(Path(__file__).with_name(name) for name in ("jit.py", "tick.py", "values.py")),
)
LOOP_DIGEST = digest([path.read_bytes() for path in LOOP_SOURCES])
entry = cached_as("_".join((LOOP_DIGEST, ESTIMATION, PLANNING)), JIT_OPTIONS)
making_arrays = row_compiled

__all__ = ["compiled", "entry", "making_arrays"]
