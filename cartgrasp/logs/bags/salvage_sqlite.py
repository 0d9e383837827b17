"""What can still be read of a damaged SQLite bag: the rows of its messages, stepping over pages that are lost."""

from __future__ import annotations

import sqlite3
from collections.abc import Iterator
from pathlib import Path
from urllib.parse import quote

from .bag import message_kind

Found = tuple[str, str, int, bytes]
FARTHEST = 1 << 40
ROWS = "SELECT id, topic_id, timestamp, data FROM messages WHERE id > ? ORDER BY id"


def salvage_sqlite(path: Path, lost: list[str]) -> Iterator[Found]:
    has_log = path.with_name(path.name + "-wal").exists()
    options = "mode=ro" if has_log else "mode=ro&immutable=1"
    database = None
    try:
        database = sqlite3.connect(f"file:{quote(str(path))}?{options}", uri=True)
        found = database.execute("SELECT id, name, type FROM topics").fetchall()
        topics = {i: (str(name), message_kind(str(kind))) for i, name, kind in found}
        yield from _rows(database, topics, lost)
    except sqlite3.Error as error:
        lost.append(f"its topics can't be read: {error}")
    finally:
        if database is not None:
            database.close()


def _rows(database: sqlite3.Connection, topics: dict[int, tuple[str, str]], lost: list[str]) -> Iterator[Found]:
    last, step = 0, 0
    while last < FARTHEST:
        try:
            for number, topic, received, raw in database.execute(ROWS, (last + step,)):
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
            if last + step > FARTHEST:
                break
    if step:
        lost.append(f"all messages behind the id {last}: their pages are damaged")
