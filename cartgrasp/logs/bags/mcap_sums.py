"""Sums over what stands outside an MCAP file's chunks."""

from __future__ import annotations

import struct
import zlib
from pathlib import Path
from typing import BinaryIO

from .mcap_records import FILE_END_SIZE, FOOTER, MCAP_MAGIC, RECORD_HEADER, Op

DATA_END_SIZE = RECORD_HEADER.size + 4
READ_BLOCK_SIZE = 1 << 20


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
