"""Whether an SQLite file is as long as it says (sqlite.org/fileformat2.html): a page that is cut reads as zeros."""

from __future__ import annotations

import struct
from pathlib import Path

SQLITE_MAGIC = b"SQLite format 3\0"
SQLITE_HEADER_SIZE = 100
"""Bytes of the header."""


def check_size(path: Path) -> None:
    """ValueError where the file is longer or shorter."""
    with open(path, "rb") as stream:
        header = stream.read(SQLITE_HEADER_SIZE)
        size = stream.seek(0, 2)
    if not header.startswith(SQLITE_MAGIC) or len(header) < SQLITE_HEADER_SIZE:
        raise ValueError("its beginning is not that of an SQLite file")
    stated = stated_size(header)
    if size % page_size(header) or (stated is not None and stated != size):
        raise ValueError(f"it has {size} bytes, and says {stated if stated is not None else 'whole pages'}")


def page_size(header: bytes) -> int:
    (size,) = struct.unpack_from(">H", header, 16)
    return 65536 if size == 1 else max(int(size), 512)


def stated_size(header: bytes) -> int | None:
    """In bytes; None where an old writer has left it undone."""
    if len(header) < SQLITE_HEADER_SIZE:
        return None
    changes, pages = struct.unpack_from(">II", header, 24)
    (valid_for,) = struct.unpack_from(">I", header, 92)
    return pages * page_size(header) if pages and changes == valid_for else None
