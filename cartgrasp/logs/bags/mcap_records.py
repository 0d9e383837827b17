"""Records of an MCAP file (mcap.dev/spec): what our writer puts together and the salvage takes apart."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from enum import IntEnum
from pathlib import Path
from typing import NamedTuple

MCAP_MAGIC = b"\x89MCAP0\r\n"
RECORD_HEADER = struct.Struct("<BQ")
CHUNK_HEADER = struct.Struct("<QQQI")
MESSAGE_HEADER = struct.Struct("<HIQQ")
FOOTER = struct.Struct("<QQI")
FILE_END_SIZE = RECORD_HEADER.size + FOOTER.size + len(MCAP_MAGIC)
"""Bytes of footer and closing magic."""


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
