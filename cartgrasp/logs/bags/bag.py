"""A bag as messages: ROS 1 (.bag), ROS 2 (.mcap, .db3, or the folder that the recorder wrote)."""

from __future__ import annotations

import re
from abc import ABC, abstractmethod
from collections.abc import Collection, Iterator
from pathlib import Path
from typing import NamedTuple

from ...errors import LogError, Place, printable

STORAGES = (".mcap", ".db3")
BAG_SUFFIXES = (".bag", *STORAGES)
SALVAGE_HINT = "`cartgrasp convert --salvage` keeps what can be read"


RawMessage = tuple[str, str, int, bytes]
"""Topic, type, time of receipt in ns, and bytes."""


class Message(NamedTuple):
    """One message as it was stored; `number` counts from 1 within its topic, `received` is in ns."""

    topic: str
    kind: str
    number: int
    received: int
    raw: bytes


class Bag(ABC):
    """`kinds` holds the type of each topic and `lost` what could not be read, complete once the messages were read."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.is_ros1 = path.suffix.lower() == ".bag" and not path.is_dir()
        self.kinds: dict[str, str] = {}
        self.lost: list[str] = []

    @abstractmethod
    def messages(self, topics: Collection[str] | None = None) -> Iterator[Message]:
        """Those of some topics, or all."""

    def refuse(self, why: str, topic: str = "") -> LogError:
        return LogError(Place(str(self.path)), printable(topic), printable(why))


def storages_in(path: Path) -> list[Path]:
    """The file itself, or those of a recorder's folder in the order in which they were written: run_0, …, run_10."""
    if not path.is_dir():
        return [path]

    def order(file: Path) -> tuple[int, str]:
        number = file.stem.rpartition("_")[2]
        return (int(number) if number.isascii() and number.isdigit() else 0, file.name)

    return sorted((p for p in path.iterdir() if p.suffix.lower() in STORAGES and p.is_file()), key=order)


def check_one_recording(path: Path) -> None:
    """A folder without metadata holds one recording where its files' names differ in their numbers only."""
    if not path.is_dir():
        return
    names = {re.sub(r"_\d+$", "", p.stem) for p in storages_in(path)}
    if not names:
        raise LogError(Place(str(path)), "", f"a folder without any {' or '.join(STORAGES)}; name a bag")
    if len(names) > 1:
        why = f"holds several bags, {', '.join(sorted(names)[:3])} …; name one of them"
        raise LogError(Place(str(path)), "", printable(why))


def message_kind(name: str) -> str:
    """A type's name as ROS 2 writes it: `package/msg/Type`."""
    package, _, last = name.partition("/")
    return name if "/" in last or not last else f"{package}/msg/{last}"
