"""Compressed pieces of damaged bags: as much as can be unpacked, and never more than was promised."""

from __future__ import annotations

import bz2
import sys
from typing import Any

import lz4.frame

if sys.version_info >= (3, 14):
    from compression import zstd as zstd
else:
    from backports import zstd as zstd

MAX_UNPACKED_BYTES = 1 << 30
UNPACKED_PIECE_BYTES = 1 << 14
UNPACKERS: dict[bytes, Any] = {
    b"zstd": zstd.ZstdDecompressor,
    b"lz4": lz4.frame.LZ4FrameDecompressor,
    b"bz2": bz2.BZ2Decompressor,
}


def unpacked(body: bytes, compression: bytes, size: int) -> bytes:
    """At most `size` bytes; fewer where the body is damaged or cut off."""
    if compression in (b"", b"none"):
        return body[:size]
    if compression not in UNPACKERS:
        return b""
    unpacker, found, room = UNPACKERS[compression](), bytearray(), min(size, MAX_UNPACKED_BYTES)
    try:
        for at in range(0, len(body), UNPACKED_PIECE_BYTES):
            found += unpacker.decompress(body[at : at + UNPACKED_PIECE_BYTES], max_length=room - len(found))
            while len(found) < room and not unpacker.eof and not unpacker.needs_input:
                more = unpacker.decompress(b"", max_length=room - len(found))
                if not more:
                    break
                found += more
            if unpacker.eof or len(found) >= room:
                break
    except (OSError, ValueError, RuntimeError, EOFError, zstd.ZstdError):
        pass
    return bytes(found)
