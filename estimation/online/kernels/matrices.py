"""Small matrices in kernels of rows."""

from __future__ import annotations

import math

import numpy as np

from cartgrasp.frames import Array

from .correction import eliminate
from .jit import row_compiled


@row_compiled
def congruence(matrix: Array, covariance: Array) -> Array:
    """`M P Mᵀ`."""
    return product(product(matrix, covariance), turned(matrix))


@row_compiled
def product(left: Array, right: Array) -> Array:
    found = np.zeros((len(left), right.shape[1]))
    add_product(left, right, found)
    return found


@row_compiled
def add_product(left: Array, right: Array, into: Array) -> None:
    for i in range(len(left)):
        for k in range(len(right)):
            for j in range(right.shape[1]):
                into[i, j] += left[i, k] * right[k, j]


@row_compiled
def inner(left: Array, right: Array) -> float:
    """The sum of what two matrices' entries make with each other."""
    total = 0.0
    for i in range(len(left)):
        for j in range(left.shape[1]):
            total += left[i, j] * right[i, j]
    return total


@row_compiled
def in_units(matrix: Array, size: Array) -> Array:
    """The matrix in units of sizes (n,)."""
    found = matrix.copy()
    for i in range(len(size)):
        for j in range(len(size)):
            found[i, j] /= size[i] * size[j]
    return found


@row_compiled
def times(matrix: Array, vector: Array) -> Array:
    found = np.zeros(len(matrix))
    for i in range(len(matrix)):
        for j in range(len(vector)):
            found[i] += matrix[i, j] * vector[j]
    return found


@row_compiled
def turned(matrix: Array) -> Array:
    """The transpose."""
    n, m = matrix.shape
    found = np.empty((m, n))
    for i in range(n):
        for j in range(m):
            found[j, i] = matrix[i, j]
    return found


@row_compiled
def solved(matrix: Array, right: Array) -> Array:
    found = right.copy()
    eliminate(matrix.copy(), found)
    return found


@row_compiled
def inverse(matrix: Array) -> Array:
    """The inverse of a positive definite matrix with mixed units."""
    n = len(matrix)
    scale, scaled, found = np.empty(n), np.empty((n, n)), np.eye(n)
    for i in range(n):
        scale[i] = 1.0 / math.sqrt(matrix[i, i])
    for i in range(n):
        for j in range(n):
            scaled[i, j] = matrix[i, j] * scale[i] * scale[j]
    eliminate(scaled, found)
    for i in range(n):
        for j in range(n):
            scaled[i, j] = 0.5 * (found[i, j] + found[j, i]) * scale[i] * scale[j]
    return scaled


@row_compiled
def without(information: Array, pull: Array, first: int, last: int) -> tuple[Array, Array]:
    """About the others, whatever those from `first` to `last` are (Schur's complement)."""
    n, size = last - first, len(pull)
    left = np.empty(size - n, np.int64)
    for i in range(size - n):
        left[i] = i if i < first else i + n
    own, across = information[first:last, first:last], np.empty((n, len(left) + 1))
    for i in range(n):
        across[i, len(left)] = pull[first + i]
        for j in range(len(left)):
            across[i, j] = information[first + i, left[j]]
    gained = solved(own, across)
    kept, more = np.empty((len(left), len(left))), np.empty(len(left))
    for i in range(len(left)):
        more[i] = pull[left[i]]
        for c in range(n):
            more[i] -= across[c, i] * gained[c, len(left)]
        for j in range(i + 1):
            value = information[left[i], left[j]]
            for c in range(n):
                value -= across[c, i] * gained[c, j]
            kept[i, j] = kept[j, i] = value
    return kept, more
