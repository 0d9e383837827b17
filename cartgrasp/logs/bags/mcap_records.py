"""Records of an MCAP file (mcap.dev/spec), which our writer puts together and the salvage takes apart; and the sums
over what stands outside its chunks."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator
from enum import IntEnum
from pathlib import Path
from typing import BinaryIO, NamedTuple

MCAP_MAGIC = b"\x89MCAP0\r\n"
RECORD_HEADER = struct.Struct("<BQ")
CHUNK_HEADER = struct.Struct("<QQQI")
MESSAGE_HEADER = struct.Struct("<HIQQ")
FOOTER = struct.Struct("<QQI")
FILE_END_SIZE = RECORD_HEADER.size + FOOTER.size + len(MCAP_MAGIC)
"""Bytes of footer and closing magic."""
DATA_END_SIZE = RECORD_HEADER.size + 4
READ_BLOCK_SIZE = 1 << 20


class Op(IntEnum):
    HEADER = 0x01
    FOOTER = 0x02
    SCHEMA = 0x03
    CHANNEL = 0x04
    MESSAGE = 0x05
    CHUNK = 0x06
    MESSAGE_INDEX = 0x07
    CHUNK_INDEX = 0x08
    STATISTICS = 0x0B
    METADATA = 0x0C
    METADATA_INDEX = 0x0D
    SUMMARY_OFFSET = 0x0E
    DATA_END = 0x0F


class Record(NamedTuple):
    """A record's kind, content, and where it begins."""

    op: int
    content: bytes
    at: int


def record(op: Op, *parts: bytes) -> bytes:
    content = b"".join(parts)
    return RECORD_HEADER.pack(op, len(content)) + content


def text(value: str | bytes) -> bytes:
    """A text or an array with its length before it."""
    data = value.encode() if isinstance(value, str) else value
    return struct.pack("<I", len(data)) + data


def pairs(value: dict[str, str]) -> bytes:
    return text(b"".join(text(part) for item in value.items() for part in item))


def records(data: bytes, at: int = 0) -> Iterator[Record]:
    """Records one after another; ends before the first that goes beyond the data."""
    while at + RECORD_HEADER.size <= len(data):
        op, size = RECORD_HEADER.unpack_from(data, at)
        if at + RECORD_HEADER.size + size > len(data):
            return
        yield Record(op, data[at + RECORD_HEADER.size : at + RECORD_HEADER.size + size], at)
        at += RECORD_HEADER.size + size


def take_text(data: bytes, at: int) -> tuple[bytes, int]:
    """What stands behind its length, and where what follows begins; struct.error where there is too little."""
    (size,) = struct.unpack_from("<I", data, at)
    if at + 4 + size > len(data):
        raise struct.error(f"{size} bytes go beyond the record's end")
    return data[at + 4 : at + 4 + size], at + 4 + size


def take_pairs(data: bytes) -> dict[str, str]:
    found, at = {}, 0
    while at < len(data):
        key, at = take_text(data, at)
        value, at = take_text(data, at)
        found[key.decode()] = value.decode()
    return found


def profile_of(path: Path) -> str:
    """What a file's header says that its messages are."""
    with open(path, "rb") as stream:
        stream.seek(len(MCAP_MAGIC))
        op, size = RECORD_HEADER.unpack(stream.read(RECORD_HEADER.size))
        if op != Op.HEADER:
            raise ValueError("its header is missing")
        return take_text(stream.read(size), 0)[0].decode()


def check_sums(path: Path) -> None:
    """ValueError where a sum that the file states isn't that of its bytes; the sums of chunks are the reader's."""
    with open(path, "rb") as stream:
        size = stream.seek(0, 2)
        if size < FILE_END_SIZE + len(MCAP_MAGIC):
            raise ValueError("too short for an MCAP file")
        stream.seek(size - FILE_END_SIZE)
        footer = stream.read(FILE_END_SIZE)
        op, length = RECORD_HEADER.unpack_from(footer)
        if footer[-len(MCAP_MAGIC) :] != MCAP_MAGIC or op != Op.FOOTER or length != FOOTER.size:
            raise ValueError("its end is missing")
        summary, _, stated = FOOTER.unpack_from(footer, RECORD_HEADER.size)
        data_end = (summary or size - FILE_END_SIZE) - DATA_END_SIZE
        if not len(MCAP_MAGIC) <= data_end <= size - FILE_END_SIZE - DATA_END_SIZE:
            raise ValueError("its footer points outside of it")
        if stated and summary:
            found = _sum(stream, summary, size - summary - len(MCAP_MAGIC) - 4)
            if found != stated:
                raise ValueError("the checksum of its summary differs")
        stream.seek(data_end)
        op, length, of_data = struct.unpack("<BQI", stream.read(DATA_END_SIZE))
        if op != Op.DATA_END or length != 4:
            raise ValueError("the end of its data is not where its footer says")
        if of_data and _sum(stream, 0, data_end) != of_data:
            raise ValueError("the checksum of its data differs")


def _sum(stream: BinaryIO, start: int, size: int) -> int:
    total = 0
    stream.seek(start)
    while size > 0:
        block = stream.read(min(READ_BLOCK_SIZE, size))
        if not block:
            break
        total = zlib.crc32(block, total)
        size -= len(block)
    return total
