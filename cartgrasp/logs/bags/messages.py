"""The ROS messages that a run is made of, by their fixed layouts: no code is made from what a bag says of its types.

Layouts: `geometry_msgs/WrenchStamped`, `geometry_msgs/PoseStamped`, `nav_msgs/Odometry` and `tf2_msgs/TFMessage` of
ROS 1 and ROS 2, which differ in the header's `seq` and in alignment (OMG CDR 1.1; ROS 1 packs).
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from typing import NamedTuple

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


@dataclass(frozen=True)
class Wire:
    """How a message lies in its bytes: from `start` on, in `order` (`<` or `>`); ROS 2 aligns numbers to their size."""

    order: str
    is_ros1: bool

    @classmethod
    def of(cls, raw: bytes, is_ros1: bool) -> Wire:
        if is_ros1:
            return ROS1
        if len(raw) < 4 or raw[0] != 0 or raw[1] not in (0, 1):
            raise BadMessageError("its first bytes are not those of plain CDR")
        return LITTLE if raw[1] else BIG

    @property
    def start(self) -> int:
        return 0 if self.is_ros1 else 4

    @cached_property
    def stamp(self) -> struct.Struct:
        return struct.Struct(self.order + ("4xII" if self.is_ros1 else "iI"))

    @cached_property
    def length(self) -> struct.Struct:
        return struct.Struct(self.order + "I")

    @cached_property
    def doubles(self) -> dict[int, struct.Struct]:
        return {n: struct.Struct(f"{self.order}{n}d") for n in (6, 7)}

    def word(self, raw: bytes, at: int) -> tuple[int, int]:
        """A number of four bytes, and where what follows it begins."""
        at += 0 if self.is_ros1 else -at % 4
        return self.length.unpack_from(raw, at)[0], at + 4

    def text(self, raw: bytes, at: int) -> tuple[str, int]:
        size, at = self.word(raw, at)
        if at + size > len(raw):
            raise BadMessageError(f"a text of {size} bytes goes beyond its end")
        return raw[at : at + size].rstrip(b"\0").decode(), at + size

    def header(self, raw: bytes, at: int) -> tuple[int, str, int]:
        """Stamp in ns and frame."""
        at += 0 if self.is_ros1 else -at % 4
        seconds, nanoseconds = self.stamp.unpack_from(raw, at)
        if nanoseconds >= NS_PER_S:
            raise BadMessageError(f"its stamp has {nanoseconds} ns, more than a second")
        frame, at = self.text(raw, at + self.stamp.size)
        return seconds * NS_PER_S + nanoseconds, frame, at

    def numbers(self, raw: bytes, at: int, count: int) -> tuple[tuple[float, ...], int]:
        """Doubles; CDR counts alignment from behind its four first bytes."""
        at += 0 if self.is_ros1 else (4 - at) % 8
        return self.doubles[count].unpack_from(raw, at), at + 8 * count


ROS1, LITTLE, BIG = Wire("<", True), Wire("<", False), Wire(">", False)


def decode(raw: bytes, kind: str, is_ros1: bool) -> list[Sample]:
    """The samples of one message; BadMessageError where the bytes don't fit its layout."""
    try:
        wire = Wire.of(raw, is_ros1)
        samples, end = DECODERS[kind](raw, wire)
    except (struct.error, UnicodeDecodeError) as error:
        raise BadMessageError(f"its bytes don't fit its type: {error}") from error
    if not end <= len(raw) < end + 4:
        raise BadMessageError(f"{len(raw)} bytes, where its type has {end}")
    return samples


def _stamped_numbers(count: int, raw: bytes, wire: Wire) -> tuple[list[Sample], int]:
    stamp, frame, at = wire.header(raw, wire.start)
    numbers, at = wire.numbers(raw, at, count)
    return [Sample(stamp, frame, "", numbers)], at


def _odometry(raw: bytes, wire: Wire) -> tuple[list[Sample], int]:
    stamp, frame, at = wire.header(raw, wire.start)
    child, at = wire.text(raw, at)
    pose, at = wire.numbers(raw, at, 7)
    twist, at = wire.numbers(raw, at + 8 * COVARIANCE_SIZE, 6)
    return [Sample(stamp, frame, child, pose + twist)], at + 8 * COVARIANCE_SIZE


def _transforms(raw: bytes, wire: Wire) -> tuple[list[Sample], int]:
    count, at = wire.word(raw, wire.start)
    if count > len(raw):
        raise BadMessageError(f"{count} transforms don't fit into its {len(raw)} bytes")
    samples = []
    for _ in range(count):
        stamp, frame, at = wire.header(raw, at)
        child, at = wire.text(raw, at)
        numbers, at = wire.numbers(raw, at, 7)
        samples.append(Sample(stamp, frame, child, numbers))
    return samples, at


DECODERS: dict[str, Callable[[bytes, Wire], tuple[list[Sample], int]]] = {
    WRENCH_TYPE: partial(_stamped_numbers, 6),
    POSE_TYPE: partial(_stamped_numbers, 7),
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
