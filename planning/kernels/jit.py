"""How kernels are compiled: once a machine, into numba's cache beside the source (or in the user's cache)."""

from __future__ import annotations

import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

from numba import njit

F = TypeVar("F", bound=Callable[..., object])

# Sums may be reordered, which lets loops be vectorised; infinite limits and NaN keep their meaning. Kernels make no
# arrays, so nothing is counted: reference counts would cost more than the arithmetic.
OPTIONS: dict[str, Any] = {"error_model": "numpy", "fastmath": {"reassoc", "contract", "nsz"}, "_nrt": False}


def digest(sources: list[bytes]) -> str:
    return f"{zlib.crc32(b''.join(sources)):08x}"


# A kernel holds the code of those it calls, and numba only looks whether its own file is new: so the name under which
# it is cached says what all of them were made of.
DIGEST = digest([path.read_bytes() for path in sorted(Path(__file__).parent.glob("*.py"))])


def compiled(function: F) -> F:
    """For kernels that kernels call."""
    return njit(function, forceinline=True, **OPTIONS)  # type: ignore[no-any-return]


def entry(function: F) -> F:
    """For kernels that Python calls: with all that they call, they are kept for the next process."""
    function.__qualname__ = f"{function.__qualname__}_{DIGEST}"
    try:
        return njit(function, cache=True, **OPTIONS)  # type: ignore[no-any-return]
    except RuntimeError:  # no directory can be written to
        return compiled(function)
