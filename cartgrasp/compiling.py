"""How numba's kernels are kept for the next process. Kernels make no arrays, so nothing is counted (`_nrt`): reference
counts would cost more than the arithmetic."""

from __future__ import annotations

import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

from numba import njit

F = TypeVar("F", bound=Callable[..., object])
OPTIONS: dict[str, Any] = {"error_model": "numpy", "_nrt": False}


def digest(sources: list[bytes]) -> str:
    return f"{zlib.crc32(b''.join(sources)):08x}"


def digest_of(folder: Path) -> str:
    """Of a folder's Python sources, and of this one with its options. A kernel holds the code of those it calls, and
    numba only looks whether its own file is new: so the name under which it is cached says what all of them were made
    of."""
    return digest([path.read_bytes() for path in (Path(__file__), *sorted(folder.glob("*.py")))])


def cached_as(name: str, options: dict[str, Any]) -> Callable[[F], F]:
    """For kernels that Python calls: compiled once a machine, into numba's cache beside the source (or in the user's
    cache), with all that they call. `name` is a digest of the sources of all of them."""

    def entry(function: F) -> F:
        function.__qualname__ = f"{function.__qualname__}_{name}"
        try:
            return njit(function, cache=True, **options)  # type: ignore[no-any-return]
        except RuntimeError:  # no directory can be written to
            return njit(function, **options)  # type: ignore[no-any-return]

    return entry
