"""How numba's kernels are kept for the next process. Kernels make no arrays, so nothing is counted (`_nrt`): reference
counts would cost more than the arithmetic."""

from __future__ import annotations

import fcntl
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

from numba import njit
from numba.core.compiler_lock import global_compiler_lock

from . import kernel_compiler
from .kernel_compiler import EntryCompiler, InnerCompiler

F = TypeVar("F", bound=Callable[..., object])
ENTRY_KERNELS: list[Any] = []
"""Kernels that Python calls, of all that has been imported."""
JIT_OPTIONS: dict[str, Any] = {"error_model": "numpy", "_nrt": False}


def digest(sources: list[bytes]) -> str:
    return f"{zlib.crc32(b''.join(sources)):08x}"


def digest_of(folder: Path) -> str:
    """The digest of a folder's Python sources, with those of folders in it, and of how they are compiled. A kernel
    holds the code of those it calls, and numba only looks whether its own file is new. So the name under which it is
    cached says what all of them were made of."""
    own = Path(__file__), Path(kernel_compiler.__file__)
    return digest([path.read_bytes() for path in (*own, *sorted(folder.rglob("*.py")))])


def inner(function: F, options: dict[str, Any]) -> F:
    """Compiles a kernel that only kernels call."""
    given: Any = {"pipeline_class": InnerCompiler, "no_cpython_wrapper": True, "no_cfunc_wrapper": True, **options}
    return njit(function, **given)  # type: ignore[no-any-return]


def cached_as(name: str, options: dict[str, Any]) -> Callable[[F], F]:
    """A decorator for kernels that Python calls. They are compiled once a machine, with all that they call, into
    numba's cache beside the source (or in the user's cache). `name` is a digest of the sources of all of them."""

    def entry(function: F) -> F:
        function.__qualname__ = f"{function.__qualname__}_{name}"
        given: Any = {"pipeline_class": EntryCompiler, "no_cfunc_wrapper": True, **options}
        try:
            kernel = njit(function, cache=True, **given)
            kernel.compile = _one_at_a_time(
                kernel.compile, Path(kernel._cache.cache_path) / f"{function.__qualname__}.lock"
            )
            ENTRY_KERNELS.append(kernel)
        except RuntimeError:  # no directory can be written to
            ENTRY_KERNELS.append(njit(function, **given))
        return ENTRY_KERNELS[-1]  # type: ignore[no-any-return]

    return entry


def _one_at_a_time(compile_: Callable[..., Any], lock: Path) -> Callable[..., Any]:
    """Compiling that waits for another process which compiles the same kernel, and then finds it in the cache. Numba's
    own lock, of threads, comes first: two threads would wait for each other."""

    def compiled(*given: Any) -> Any:
        with global_compiler_lock, lock.open("w") as handle:
            fcntl.flock(handle, fcntl.LOCK_EX)
            return compile_(*given)

    return compiled
