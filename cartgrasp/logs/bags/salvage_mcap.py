"""What can still be read of a damaged MCAP file: record by record, each chunk against its sum."""

from __future__ import annotations

import re
import struct
import zlib
from collections.abc import Iterator
from dataclasses import dataclass, field

from .bag import RawMessage, message_kind
from .mcap_records import (
    CHUNK_HEADER,
    FILE_END_SIZE,
    FOOTER,
    MCAP_MAGIC,
    MESSAGE_HEADER,
    RECORD_HEADER,
    Op,
    records,
    take_text,
)
from .unpacking import unpacked

CHUNK_START = re.compile(rb"\x06.{6}\0\0.{28}(?:\x04\0\0\0zstd|\x03\0\0\0lz4|\0\0\0\0)", re.DOTALL)
LAST_OP = max(Op)


@dataclass
class McapSalvage:
    """One walk over a file's bytes; `lost` says what was not read."""

    data: bytes
    lost: list[str]
    schemas: dict[int, str] = field(default_factory=dict)
    channels: dict[int, tuple[str, str]] = field(default_factory=dict)

    def messages(self) -> Iterator[RawMessage]:
        at, last = len(MCAP_MAGIC), False
        if not self.data.startswith(MCAP_MAGIC):
            self.lost.append("its beginning is not that of an MCAP file")
            at = 0
        self._learn_from_end()
        while at < len(self.data) and not last:
            op, size = RECORD_HEADER.unpack_from(self.data, at) if at + RECORD_HEADER.size <= len(self.data) else (0, 0)
            end = at + RECORD_HEADER.size + size
            if not 0 < op <= LAST_OP or (end > len(self.data) and self._later_chunk(at + 1) is not None):
                after = self._later_chunk(at + 1) or len(self.data)
                self.lost.append(f"{after - at} bytes from byte {at} on are no records")
                at = after
                continue
            content = self.data[at + RECORD_HEADER.size : end]
            if end > len(self.data):
                missing = end - len(self.data)
                self.lost.append(f"from byte {at} on it is cut off: {missing} bytes of a record are missing")
            last = op in (Op.DATA_END, Op.FOOTER) or end > len(self.data)
            yield from self._record(op, content, at)
            at = end
        if not self.data.endswith(MCAP_MAGIC):
            self.lost.append("its end with the index is missing")

    def _record(self, op: int, content: bytes, at: int) -> Iterator[RawMessage]:
        try:
            if op == Op.CHUNK:
                yield from self._chunk(content, at)
            elif op == Op.MESSAGE:
                channel, _, received, _ = MESSAGE_HEADER.unpack_from(content)
                yield *self.channels[channel], received, content[MESSAGE_HEADER.size :]
            else:
                self._learn(op, content)
        except (struct.error, UnicodeDecodeError, KeyError) as error:
            self.lost.append(f"the record at byte {at} can't be read: {error}")

    def _chunk(self, content: bytes, at: int) -> Iterator[RawMessage]:
        _, _, size, stated = CHUNK_HEADER.unpack_from(content)
        compression, where = take_text(content, CHUNK_HEADER.size)
        (packed,) = struct.unpack_from("<Q", content, where)
        body = content[where + 8 : where + 8 + packed]
        raw = unpacked(body, compression, size)
        is_whole = len(body) == packed and len(raw) == size
        if is_whole and stated and zlib.crc32(raw) != stated:
            self.lost.append(f"the chunk of {size} bytes at byte {at}: its checksum differs")
            return
        if not is_whole:
            self.lost.append(f"the chunk at byte {at}: {len(raw)} of {size} bytes could be unpacked")
        for inner in records(raw):
            yield from self._record(inner.op, inner.content, at) if inner.op != Op.CHUNK else ()

    def _learn(self, op: int, content: bytes) -> None:
        if op == Op.SCHEMA:
            (number,) = struct.unpack_from("<H", content)
            self.schemas[number] = message_kind(take_text(content, 2)[0].decode())
        elif op == Op.CHANNEL:
            number, schema = struct.unpack_from("<HH", content)
            self.channels[number] = take_text(content, 4)[0].decode(), self.schemas.get(schema, "")

    def _learn_from_end(self) -> None:
        """Schemas and channels as the summary repeats them, for where those in the data are lost."""
        if len(self.data) < FILE_END_SIZE or not self.data.endswith(MCAP_MAGIC):
            return
        summary, _, _ = FOOTER.unpack_from(self.data, len(self.data) - FILE_END_SIZE + RECORD_HEADER.size)
        if not 0 < summary < len(self.data):
            return
        for found in records(self.data, summary):
            try:
                self._learn(found.op, found.content)
            except (struct.error, UnicodeDecodeError):
                return

    def _later_chunk(self, at: int) -> int | None:
        for match in CHUNK_START.finditer(self.data, at):
            start = match.start()
            (length,) = struct.unpack_from("<Q", self.data, start + 1)
            behind = start + RECORD_HEADER.size + length
            if match.end() + 8 <= len(self.data):
                (packed,) = struct.unpack_from("<Q", self.data, match.end())
                if match.end() + 8 + packed == behind <= len(self.data):
                    return start
        return None
