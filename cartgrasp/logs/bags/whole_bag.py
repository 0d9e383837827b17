"""Bags that must be whole, read by the library `rosbags`: the only file that knows it. What it, the databases and the
compressors under it raise on damage becomes one error with file, topic and message."""

from __future__ import annotations

import sqlite3
import struct
import zlib
from collections import Counter
from collections.abc import Collection, Iterator, Sequence
from contextlib import AbstractContextManager, ExitStack, contextmanager
from pathlib import Path
from typing import Any

import apsw
from rosbags.interfaces import Connection
from rosbags.rosbag1 import Reader as Reader1
from rosbags.rosbag1 import ReaderError as ReaderError1
from rosbags.rosbag2 import Reader as Reader2
from rosbags.rosbag2 import ReaderError as ReaderError2
from rosbags.typesys import Stores, get_typestore
from ruamel.yaml.error import YAMLError

from .bag import SALVAGE_HINT, Bag, Message, message_kind, storages_in
from .mcap_records import check_sums, profile_of
from .sqlite_file import check_size
from .unpacking import zstd

READER_ERRORS = (
    *(ReaderError1, ReaderError2, apsw.Error, sqlite3.Error, struct.error, zlib.error, zstd.ZstdError, YAMLError),
    *(OSError, EOFError, LookupError, ValueError, TypeError, AttributeError, AssertionError),
    *(ArithmeticError, MemoryError, RuntimeError),
)
"""Beside their own errors, what these readers stumble over where bytes are not what they should be."""
JOURNAL_SUFFIXES = ("-wal", "-journal")


class WholeBag(Bag):
    """A bag without damage: every sum and every count in it agrees with its messages."""

    def __init__(self, path: Path) -> None:
        super().__init__(path)
        with self._reading(), self._opened() as readers:
            for reader in readers:
                for connection in reader.connections:
                    self._check_kind(connection)

    def messages(self, topics: Collection[str] | None = None) -> Iterator[Message]:
        numbers: Counter[str] = Counter()
        last: list[Message] = []
        with self._reading(last), self._opened() as readers:
            for reader in readers:
                wanted = [c for c in reader.connections if topics is None or c.topic in topics]
                expected: Counter[str] = Counter()
                for connection in wanted:
                    expected[connection.topic] += connection.msgcount
                before = numbers.copy()
                for connection, received, raw in reader.messages(wanted) if wanted else ():
                    topic = connection.topic
                    numbers[topic] += 1
                    last[:] = [Message(topic, message_kind(connection.msgtype), numbers[topic], received, bytes(raw))]
                    yield last[0]
                for topic, count in expected.items():
                    if numbers[topic] - before[topic] != count:
                        found = numbers[topic] - before[topic]
                        raise self.refuse(f"{count} messages in its index, {found} in its data; {SALVAGE_HINT}", topic)

    def _check_kind(self, connection: Connection) -> None:
        kind = message_kind(connection.msgtype)
        if self.kinds.setdefault(connection.topic, kind) != kind:
            why = f"has messages of two types, {self.kinds[connection.topic]} and {kind}; {SALVAGE_HINT}"
            raise self.refuse(why, connection.topic)
        if self.is_ros1 and kind in ROS1_SUMS and connection.digest not in (ROS1_SUMS[kind], "*"):
            raise self.refuse(f"its {kind} is not the one of ROS (its definition's sum differs)", connection.topic)

    @contextmanager
    def _opened(self) -> Iterator[list[Any]]:
        readers: list[AbstractContextManager[Any]]
        if self.is_ros1:
            readers = [Reader1(self.path)]
        else:
            files = storages_in(self.path)
            for file in files:
                self._check_file(file)
            has_metadata = (self.path / "metadata.yaml").is_file()
            readers = [Reader2(p) for p in ([self.path] if has_metadata else files)]
        with ExitStack() as stack:
            yield [stack.enter_context(reader) for reader in readers]

    def _check_file(self, file: Path) -> None:
        if file.suffix.lower() == ".mcap":
            check_sums(file)
            if (profile := profile_of(file)) != "ros2":
                why = f"{file.name} has the profile {profile!r}, not 'ros2', so its messages may be others"
                raise self.refuse(f"{why}; {SALVAGE_HINT}")
        if file.suffix.lower() == ".db3":
            check_size(file)
        for ending in JOURNAL_SUFFIXES:
            journal = file.with_name(file.name + ending)
            if journal.exists() and journal.stat().st_size:
                why = f"{journal.name} holds messages that were not put into it; open and close it with sqlite3"
                raise self.refuse(why)

    @contextmanager
    def _reading(self, last: Sequence[Message] = ()) -> Iterator[None]:
        """`last` holds the last message that was read, if there is one."""
        try:
            yield
        except READER_ERRORS as error:
            lines = str(error).strip().splitlines()
            reason = lines[0].rstrip(".") if lines else type(error).__name__
            topic, where = (last[0].topic, f"after message {last[0].number}: ") if last else ("", "")
            raise self.refuse(f"{where}is damaged or cut off: {reason}; {SALVAGE_HINT}", topic) from error


def definition(kind: str) -> str:
    """A type's definition with all that it is made of, as ROS 2 writes it."""
    return get_typestore(Stores.ROS2_HUMBLE).generate_msgdef(kind, ros_version=2)[0]


ROS1_SUMS = {
    "geometry_msgs/msg/WrenchStamped": "d78d3cb249ce23087ade7e7d0c40cfa7",
    "geometry_msgs/msg/PoseStamped": "d3812c3cbc69362b77dc0b19b345f8f5",
    "nav_msgs/msg/Odometry": "cd5e73d190d741a2f92e81eda573aca7",
    "tf2_msgs/msg/TFMessage": "94810edda583a504dfda3829e70d7eec",
    "tf/msg/tfMessage": "94810edda583a504dfda3829e70d7eec",
}
"""MD5 sums by which ROS 1 knows a type's definition."""
