"""How the loop's kernels are compiled: they hold code of the cart's, the estimator's and the planner's."""

from __future__ import annotations

from pathlib import Path

from estimation.kernels.jit import OWN as ESTIMATION
from estimation.kernels.jit import WITH_ARRAYS
from estimation.kernels.jit import row_compiled as compiled
from planning import steering
from planning.kernels.jit import DIGEST as PLANNING

from ...compiling import cached_as, digest

SOURCES = (Path(steering.__file__), *(Path(__file__).with_name(name) for name in ("jit.py", "tick.py", "values.py")))
OWN = digest([path.read_bytes() for path in SOURCES])
entry = cached_as("_".join((OWN, ESTIMATION, PLANNING)), WITH_ARRAYS)

__all__ = ["compiled", "entry"]
