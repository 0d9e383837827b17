"""Damaged bags, read on request: what can be read, and a list of what was lost."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterator
from pathlib import Path

from .bag import Bag, Message, RawMessage, storages_in
from .salvage_mcap import McapSalvage
from .salvage_ros1 import Ros1Salvage
from .sqlite_file import salvage_sqlite


class SalvagedBag(Bag):
    """Needs no index and no metadata; what no sum protects is taken as it is."""

    def __init__(self, path: Path) -> None:
        super().__init__(path)
        for topic, kind, _, _ in self._walk():
            self.kinds.setdefault(topic, kind)

    def messages(self, topics: Collection[str] | None = None) -> Iterator[Message]:
        numbers: Counter[str] = Counter()
        others: Counter[tuple[str, str]] = Counter()
        self.lost = []
        for topic, kind, received, raw in self._walk():
            numbers[topic] += 1
            if topics is not None and topic not in topics:
                continue
            if kind == self.kinds[topic]:
                yield Message(topic, kind, numbers[topic], received, raw)
            else:
                others[topic, kind] += 1
        self.lost += [
            f"{topic}: {n} messages of another type, {kind or 'unknown'}" for (topic, kind), n in others.items()
        ]

    def _walk(self) -> Iterator[RawMessage]:
        try:
            for file in storages_in(self.path):
                if file.suffix.lower() == ".db3":
                    yield from salvage_sqlite(file, self.lost)
                elif file.suffix.lower() == ".mcap":
                    yield from McapSalvage(file.read_bytes(), self.lost).messages()
                else:
                    yield from Ros1Salvage(file.read_bytes(), self.lost).messages()
        except OSError as error:
            raise self.refuse(f"can't be read: {error.strerror or error}") from error
