"""An MCAP file put together in memory: messages in chunks with sums, an index, and metadata (mcap.dev/spec)."""

from __future__ import annotations

import struct
import zlib
from collections import Counter

from .mcap_records import CHUNK_HEADER, FOOTER, MCAP_MAGIC, MESSAGE_HEADER, Op, pairs, record, text
from .unpacking import zstd

CHUNK_SIZE = 1 << 20
STATISTICS = struct.Struct("<QHIIIIQQ")


class McapFile:
    """Schemas and channels stand both in front of the data and behind it; `times` are the first and last so far."""

    def __init__(self, library: str, metadata: dict[str, str]) -> None:
        """`metadata` stand under the library's name."""
        self.repeated, self.chunk = bytearray(), bytearray()
        self.kinds: dict[str, int] = {}
        self.counts: Counter[int] = Counter()
        self.times: list[int] = []
        self.messages: list[tuple[int, int, int]] = []
        self.chunk_indexes: list[bytes] = []
        self.data = bytearray(MCAP_MAGIC + record(Op.HEADER, text("ros2"), text(library)))
        start = len(self.data)
        self.data += record(Op.METADATA, text(library), pairs(metadata))
        place = struct.pack("<QQ", start, len(self.data) - start)
        self.metadata_index = record(Op.METADATA_INDEX, place, text(library))

    def channel(self, topic: str, kind: str, definition: str) -> int:
        """A topic's number; `definition` is the type's in ROS 2's own words."""
        if kind not in self.kinds:
            self.kinds[kind] = len(self.kinds) + 1
            head = struct.pack("<H", self.kinds[kind])
            self._repeat(record(Op.SCHEMA, head, text(kind), text("ros2msg"), text(definition)))
        number = len(self.counts) + 1
        self.counts[number] = 0
        head = struct.pack("<HH", number, self.kinds[kind])
        self._repeat(record(Op.CHANNEL, head, text(topic), text("cdr"), text(b"")))
        return number

    def message(self, channel: int, time: int, raw: bytes) -> None:
        """Times in ns must not go back."""
        self.messages.append((channel, time, len(self.chunk)))
        self.chunk += record(Op.MESSAGE, MESSAGE_HEADER.pack(channel, self.counts[channel], time, time), raw)
        self.counts[channel] += 1
        self.times = [self.times[0] if self.times else time, time]
        if len(self.chunk) > CHUNK_SIZE:
            self._close_chunk()

    def done(self) -> bytes:
        if self.messages:
            self._close_chunk()
        crc = zlib.crc32(self.data)
        self.data += record(Op.DATA_END, struct.pack("<I", crc))
        summary = len(self.data)
        first, last = self.times or (0, 0)
        numbers = b"".join(struct.pack("<HQ", channel, count) for channel, count in self.counts.items())
        about = (sum(self.counts.values()), len(self.kinds), len(self.counts), 0, 1)
        statistics = record(Op.STATISTICS, STATISTICS.pack(*about, len(self.chunk_indexes), first, last), text(numbers))
        footer = record(Op.FOOTER, FOOTER.pack(summary, 0, 0))
        behind = b"".join([bytes(self.repeated), statistics, *self.chunk_indexes, self.metadata_index, footer[:-4]])
        return bytes(self.data) + behind + struct.pack("<I", zlib.crc32(behind)) + MCAP_MAGIC

    def _repeat(self, entry: bytes) -> None:
        self.data += entry
        self.repeated += entry

    def _close_chunk(self) -> None:
        raw = bytes(self.chunk)
        packed, first, last = zstd.compress(raw), self.messages[0][1], self.messages[-1][1]
        start = len(self.data)
        head = CHUNK_HEADER.pack(first, last, len(raw), zlib.crc32(raw))
        self.data += record(Op.CHUNK, head, text("zstd"), struct.pack("<Q", len(packed)), packed)
        end, offsets = len(self.data), b""
        for channel in sorted({channel for channel, _, _ in self.messages}):
            offsets += struct.pack("<HQ", channel, len(self.data))
            entries = b"".join(struct.pack("<QQ", time, at) for c, time, at in self.messages if c == channel)
            self.data += record(Op.MESSAGE_INDEX, struct.pack("<H", channel), text(entries))
        place = struct.pack("<QQQQ", first, last, start, end - start)
        sizes = struct.pack("<QQ", len(packed), len(raw))
        index = (place, text(offsets), struct.pack("<Q", len(self.data) - end), text("zstd"), sizes)
        self.chunk_indexes.append(record(Op.CHUNK_INDEX, *index))
        self.chunk.clear()
        self.messages.clear()
