"""Kernels that only kernels call, called from a test."""

from __future__ import annotations

from functools import cache
from types import FunctionType

from numba import njit

from estimation.online.kernels.jit import KERNELS_DIGEST
from planning.kernels.jit import DIGEST


def kept(function):
    """Compiled for a test, and kept for the next process, as entries are."""
    function.__qualname__ = f"{function.__qualname__}_{KERNELS_DIGEST}_{DIGEST}"
    return njit(function, cache=True)


def _call(*given):
    return kernel(*given)  # type: ignore[name-defined]  # noqa: F821


@cache
def called(kernel):
    own = FunctionType(_call.__code__, {"__name__": __name__, "kernel": kernel})
    own.__qualname__ = f"{kernel.__module__}.{kernel.__name__}"
    return kept(own)
