"""How kernels are compiled: once a machine, into numba's cache beside the source (or in the user's cache)."""

from __future__ import annotations

import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numba import njit
from numpy.typing import NDArray

F = TypeVar("F", bound=Callable[..., object])
Ints = NDArray[np.int64]

# Kernels make no arrays, so nothing is counted: reference counts would cost more than the arithmetic.
OPTIONS: dict[str, Any] = {"error_model": "numpy", "_nrt": False}
INNER: dict[str, Any] = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}


def digest(sources: list[bytes]) -> str:
    return f"{zlib.crc32(b''.join(sources)):08x}"


# A kernel holds the code of those it calls, and numba only looks whether its own file is new: so the name under which
# it is cached says what all of them were made of.
DIGEST = digest([path.read_bytes() for path in sorted(Path(__file__).parent.glob("*.py"))])


def compiled(function: F) -> F:
    """For kernels that kernels call."""
    return njit(function, **OPTIONS, **INNER)  # type: ignore[no-any-return]


def inlined(function: F) -> F:
    """For kernels that a kernel calls at one place: they are compiled once, with it."""
    return njit(function, inline="always", **OPTIONS)  # type: ignore[no-any-return]


def cached_as(name: str) -> Callable[[F], F]:
    """For kernels that Python calls: with all that they call, they are kept for the next process. `name` is a digest
    of the sources of all of them."""

    def entry(function: F) -> F:
        function.__qualname__ = f"{function.__qualname__}_{name}"
        try:
            return njit(function, cache=True, **OPTIONS)  # type: ignore[no-any-return]
        except RuntimeError:  # no directory can be written to
            return njit(function, **OPTIONS)  # type: ignore[no-any-return]

    return entry


entry = cached_as(DIGEST)
