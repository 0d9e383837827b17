"""What can still be read of a damaged or unindexed bag of ROS 1 (format 2.0): record by record, without its index."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from dataclasses import dataclass, field

from .bag import RawMessage, message_kind
from .messages import NS_PER_S
from .unpacking import unpacked

ROSBAG_MAGIC = b"#ROSBAG V2.0\n"
OP_MESSAGE, OP_CHUNK, OP_CONNECTION = 2, 5, 7
LENGTH_STRUCT = struct.Struct("<I")
TIME_STRUCT = struct.Struct("<II")


@dataclass
class Ros1Salvage:
    """One walk over a file's bytes; `lost` says what was not read."""

    data: bytes
    lost: list[str]
    connections: dict[int, tuple[str, str]] = field(default_factory=dict)

    def messages(self) -> Iterator[RawMessage]:
        if not self.data.startswith(ROSBAG_MAGIC):
            self.lost.append("its beginning is not that of a bag of ROS 1, version 2.0")
            return
        yield from self._records(self.data, len(ROSBAG_MAGIC), 0)

    def _records(self, data: bytes, at: int, chunk: int) -> Iterator[RawMessage]:
        """`chunk` is where the chunk begins that the data are from, 0 for the file itself."""
        place = f"in the chunk at byte {chunk}, " if chunk else ""
        while at < len(data):
            try:
                fields, body, end = _record(data, at)
                op = fields[b"op"][0]
            except (struct.error, KeyError, IndexError) as error:
                self.lost.append(f"{place}{len(data) - at} bytes from byte {at} on are no records: {error}")
                return
            if end > len(data):
                missing = end - len(data)
                self.lost.append(f"{place}from byte {at} on it is cut off: {missing} bytes of a record are missing")
            try:
                if op == OP_CHUNK and not chunk:
                    yield from self._chunk(fields, body, at)
                elif op == OP_CONNECTION:
                    (number,) = LENGTH_STRUCT.unpack(fields[b"conn"])
                    about = _fields(body)
                    self.connections[number] = fields[b"topic"].decode(), message_kind(about[b"type"].decode())
                elif op == OP_MESSAGE and end <= len(data):
                    seconds, nanoseconds = TIME_STRUCT.unpack(fields[b"time"])
                    (number,) = LENGTH_STRUCT.unpack(fields[b"conn"])
                    yield *self.connections[number], seconds * NS_PER_S + nanoseconds, body
            except (struct.error, KeyError, UnicodeDecodeError) as error:
                self.lost.append(f"{place}the record at byte {at} can't be read: {error}")
            at = end

    def _chunk(self, fields: dict[bytes, bytes], body: bytes, at: int) -> Iterator[RawMessage]:
        (size,) = LENGTH_STRUCT.unpack(fields[b"size"])
        raw = unpacked(body, fields[b"compression"], size)
        if len(raw) != size:
            self.lost.append(f"the chunk at byte {at}: {len(raw)} of {size} bytes could be unpacked")
        yield from self._records(raw, 0, at)


def _record(data: bytes, at: int) -> tuple[dict[bytes, bytes], bytes, int]:
    """A record's header, what of its body is there, and where it ends, perhaps beyond the data."""
    (size,) = LENGTH_STRUCT.unpack_from(data, at)
    if at + 4 + size > len(data):
        raise struct.error(f"a header of {size} bytes")
    fields = _fields(data[at + 4 : at + 4 + size])
    (length,) = LENGTH_STRUCT.unpack_from(data, at + 4 + size)
    start = at + 8 + size
    return fields, data[start : start + length], start + length


def _fields(data: bytes) -> dict[bytes, bytes]:
    found, at = {}, 0
    while at < len(data):
        (size,) = LENGTH_STRUCT.unpack_from(data, at)
        name, _, value = data[at + 4 : at + 4 + size].partition(b"=")
        found[name] = value
        at += 4 + size
    return found
