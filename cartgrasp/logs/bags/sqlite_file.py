"""SQLite bags (sqlite.org/fileformat2.html): whether one is as long as it says, as a page that is cut reads as zeros;
and what can still be read of a damaged one, the rows of its messages, stepping over pages that are lost."""

from __future__ import annotations

import sqlite3
import struct
from collections.abc import Iterator
from pathlib import Path

from .bag import RawMessage, message_kind

SQLITE_MAGIC = b"SQLite format 3\0"
SQLITE_HEADER_SIZE = 100
"""Bytes of the header."""
MAX_ROW_ID = 1 << 40
MAX_DATABASE_BYTES = 1 << 31
ROLLBACK_JOURNAL_VERSIONS = b"\x01\x01"
ROWS_QUERY = "SELECT id, topic_id, timestamp, data FROM messages WHERE id > ? ORDER BY id"


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


def salvage_sqlite(path: Path, lost: list[str]) -> Iterator[RawMessage]:
    """Recovers the data from a copy in memory, whose pages that were cut off are blank; what stands in a `-wal` beside
    it is lost."""
    database = sqlite3.connect(":memory:")
    try:
        database.deserialize(_completed(path.read_bytes(), lost))
        found = database.execute("SELECT id, name, type FROM topics").fetchall()
        topics = {i: (str(name), message_kind(str(kind))) for i, name, kind in found}
        yield from _rows(database, topics, lost)
    except (sqlite3.Error, MemoryError) as error:
        lost.append(f"its topics can't be read: {error}")
    finally:
        database.close()
    hidden = path.with_name(path.name + "-wal")
    if hidden.exists() and hidden.stat().st_size:
        lost.append(f"what {hidden.name} holds was not read")


def _completed(data: bytes, lost: list[str]) -> bytes:
    """The database padded to its stated size, and marked as one without a write-ahead log beside it."""
    size = stated_size(data[:SQLITE_HEADER_SIZE])
    if size is None or not len(data) < size < MAX_DATABASE_BYTES:
        size = len(data)
    else:
        lost.append(f"{size - len(data)} of {size} bytes are cut off")
    whole = len(data) if size == len(data) else len(data) // page_size(data) * page_size(data)
    return data[:18] + ROLLBACK_JOURNAL_VERSIONS + data[20:whole] + bytes(size - whole)


def _rows(database: sqlite3.Connection, topics: dict[int, tuple[str, str]], lost: list[str]) -> Iterator[RawMessage]:
    last, step = 0, 0
    while last + step <= MAX_ROW_ID:
        try:
            for number, topic, received, raw in database.execute(ROWS_QUERY, (last + step,)):
                if number <= last + step:
                    raise sqlite3.DatabaseError("rows that are not in order")
                if step:
                    lost.append(f"the messages with the ids {last + 1} to {number - 1}: their pages are damaged")
                last, step = number, 0
                if topic in topics and isinstance(received, int) and isinstance(raw, bytes):
                    yield *topics[topic], received, raw
                else:
                    lost.append(f"the message with the id {number} belongs to no topic, or is none")
            break
        except sqlite3.Error:
            step = 2 * step or 1
    if step:
        lost.append(f"all messages behind the id {last}: their pages are damaged")
