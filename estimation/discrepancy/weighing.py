"""The compiled half of `Polygon.whitened`: the transpose of a banded factor times columns."""

from __future__ import annotations

from pathlib import Path

from cartgrasp.compiling import OPTIONS, cached_as, digest
from cartgrasp.frames import Array

entry = cached_as(digest([Path(__file__).read_bytes()]), OPTIONS)


@entry
def weigh(root: Array, columns: Array, found: Array) -> None:
    """`root` (r, b) holds the factor's columns from their diagonal on; columns (s, b, k) into `found`."""
    reach, b = root.shape
    for s in range(len(columns)):
        for i in range(b):
            for q in range(columns.shape[2]):
                total = 0.0
                for apart in range(min(reach, b - i)):
                    total += root[apart, i] * columns[s, i + apart, q]
                found[s, i, q] = total
