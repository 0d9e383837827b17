"""Kernels that only kernels call, called from a test."""

from __future__ import annotations

from functools import cache

from numba import njit


@cache
def called(kernel):
    return njit(lambda *given: kernel(*given))
