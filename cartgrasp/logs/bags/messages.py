"""The ROS messages that a run is made of, by their fixed layouts: no code is made from what a bag says of its types.

Layouts: `geometry_msgs/WrenchStamped`, `geometry_msgs/PoseStamped`, `nav_msgs/Odometry` and `tf2_msgs/TFMessage` of
ROS 1 and ROS 2, which differ in the header's `seq` and in alignment (OMG CDR 1.1; ROS 1 packs).
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

WRENCH_TYPE = "geometry_msgs/msg/WrenchStamped"
POSE_TYPE = "geometry_msgs/msg/PoseStamped"
ODOMETRY_TYPE = "nav_msgs/msg/Odometry"
TF_TYPE = "tf2_msgs/msg/TFMessage"
OLD_TF_TYPE = "tf/msg/tfMessage"
TF_TYPES = (TF_TYPE, OLD_TF_TYPE)
COVARIANCE_SIZE = 36
NS_PER_S = 1_000_000_000


class Sample(NamedTuple):
    """Header stamp in ns, frames, and numbers: a wrench (6), a pose as position and quaternion xyzw (7), or a pose and
    the twist in the child's frame (13)."""

    stamp: int
    frame: str
    child: str
    numbers: tuple[float, ...]


class BadMessageError(ValueError):
    """Bytes that are no message of their type."""


class Decoder:
    """A message taken apart part by part: `at` is where the next begins. ROS 2 aligns numbers to their size, counted
    from behind its four first bytes; ROS 1 packs."""

    def __init__(self, raw: bytes, is_ros1: bool) -> None:
        if not is_ros1 and (len(raw) < 4 or raw[0] != 0 or raw[1] not in (0, 1)):
            raise BadMessageError("its first bytes are not those of plain CDR")
        self.raw, self.is_ros1, self.at = raw, is_ros1, 0 if is_ros1 else 4
        self.order = "<" if is_ros1 or raw[1] else ">"

    def take(self, layout: str, size: int, alignment: int) -> tuple[Any, ...]:
        """The values of a layout of `size` bytes."""
        start = self.at if self.is_ros1 else self.at + (4 - self.at) % alignment
        self.at = start + size
        return struct.unpack_from(self.order + layout, self.raw, start)

    def text(self) -> str:
        (size,) = self.take("I", 4, 4)
        start, self.at = self.at, self.at + size
        if self.at > len(self.raw):
            raise BadMessageError(f"a text of {size} bytes goes beyond its end")
        return self.raw[start : self.at].rstrip(b"\0").decode()

    def header(self) -> tuple[int, str]:
        """Stamp in ns and frame."""
        seconds, nanoseconds = self.take("4xII", 12, 4) if self.is_ros1 else self.take("iI", 8, 4)
        if nanoseconds >= NS_PER_S:
            raise BadMessageError(f"its stamp has {nanoseconds} ns, more than a second")
        return seconds * NS_PER_S + nanoseconds, self.text()

    def numbers(self, count: int) -> tuple[float, ...]:
        return self.take(f"{count}d", 8 * count, 8)


def decode(raw: bytes, kind: str, is_ros1: bool) -> list[Sample]:
    """The samples of one message; BadMessageError where the bytes don't fit its layout."""
    message = Decoder(raw, is_ros1)
    try:
        samples = DECODERS[kind](message)
    except (struct.error, UnicodeDecodeError) as error:
        raise BadMessageError(f"its bytes don't fit its type: {error}") from error
    if not message.at <= len(raw) < message.at + 4:
        raise BadMessageError(f"{len(raw)} bytes, where its type has {message.at}")
    return samples


def _wrench(message: Decoder) -> list[Sample]:
    return [Sample(*message.header(), "", message.numbers(6))]


def _pose(message: Decoder) -> list[Sample]:
    return [Sample(*message.header(), "", message.numbers(7))]


def _odometry(message: Decoder) -> list[Sample]:
    stamp, frame = message.header()
    child, pose = message.text(), message.numbers(7)
    message.at += 8 * COVARIANCE_SIZE
    twist = message.numbers(6)
    message.at += 8 * COVARIANCE_SIZE
    return [Sample(stamp, frame, child, pose + twist)]


def _transforms(message: Decoder) -> list[Sample]:
    (count,) = message.take("I", 4, 4)
    if count > len(message.raw):
        raise BadMessageError(f"{count} transforms don't fit into its {len(message.raw)} bytes")
    return [Sample(*message.header(), message.text(), message.numbers(7)) for _ in range(count)]


DECODERS: dict[str, Callable[[Decoder], list[Sample]]] = {
    WRENCH_TYPE: _wrench,
    POSE_TYPE: _pose,
    ODOMETRY_TYPE: _odometry,
    TF_TYPE: _transforms,
    OLD_TF_TYPE: _transforms,
}


class Encoder:
    """A message in little-endian CDR, put together part by part."""

    def __init__(self) -> None:
        self.data = bytearray(b"\0\1\0\0")

    def word(self, value: int) -> Encoder:
        self.data += bytes(-len(self.data) % 4) + struct.pack("<I", value)
        return self

    def text(self, value: str) -> Encoder:
        coded = value.encode() + b"\0"
        self.word(len(coded)).data += coded
        return self

    def header(self, stamp: int, frame: str) -> Encoder:
        self.data += bytes(-len(self.data) % 4) + struct.pack("<iI", stamp // NS_PER_S, stamp % NS_PER_S)
        return self.text(frame)

    def numbers(self, values: Sequence[float]) -> Encoder:
        self.data += bytes((4 - len(self.data)) % 8) + struct.pack(f"<{len(values)}d", *values)
        return self


def encode(sample: Sample, kind: str) -> bytes:
    """A wrench or an odometry message; its covariances are 0, which says unknown."""
    message = Encoder().header(sample.stamp, sample.frame)
    if kind == ODOMETRY_TYPE:
        nothing = (0.0,) * COVARIANCE_SIZE
        message.text(sample.child).numbers(sample.numbers[:7] + nothing + sample.numbers[7:] + nothing)
    else:
        message.numbers(sample.numbers)
    return bytes(message.data)


def encode_transforms(samples: Sequence[Sample]) -> bytes:
    message = Encoder().word(len(samples))
    for sample in samples:
        message.header(sample.stamp, sample.frame).text(sample.child).numbers(sample.numbers)
    return bytes(message.data)
