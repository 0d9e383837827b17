"""Which map a bag is read through, and how it is opened."""

from __future__ import annotations

import os
import struct
from itertools import islice
from pathlib import Path

from ...errors import LogError, Place
from ..mapped.reading import MapReading
from .bag import BAG_SUFFIXES, Bag, check_one_recording, storages_in
from .mcap_records import MCAP_MAGIC, Op, records, take_pairs, take_text
from .salvaged_bag import SalvagedBag
from .selection import Selection
from .topic_map import TopicMapFile, beside, load_topic_map, topic_map_from_text

METADATA_NAME = "cartgrasp"
MAP_KEY = "topics.yaml"
MAX_MAP_BYTES = 1 << 20


def read_bag(path: str | Path, topics: str | Path | None = None, salvage: bool = False) -> MapReading:
    """A bag's log with how it came about: through the map `topics`, else through the one that belongs to the bag."""
    path = Path(path)
    bag = open_bag(path, salvage)
    map_file = map_of(path) if topics is None else load_topic_map(topics)
    if map_file is None:
        proposing = f"`cartgrasp topics {path} --out {beside(path)[0]}` proposes one"
        raise LogError(Place(str(path)), "", f"no topic map says which topics are a run; {proposing}")
    return Selection(bag, map_file, salvage).read().log()


def open_bag(path: Path, salvage: bool = False) -> Bag:
    """Whole, or what can still be read."""
    try:
        path.stat()
    except OSError as error:
        why = "there is no such file" if isinstance(error, FileNotFoundError) else f"can't be read: {error.strerror}"
        raise LogError(Place(str(path)), "", why) from error
    if not path.is_dir() and path.suffix.lower() not in BAG_SUFFIXES:
        raise LogError(Place(str(path)), "", f"is no bag; bags end in {', '.join(BAG_SUFFIXES)}, or are folders")
    if salvage or not (path / "metadata.yaml").is_file():
        check_one_recording(path)
    if salvage:
        return SalvagedBag(path)
    from .whole_bag import WholeBag

    return WholeBag(path)


def map_of(path: Path) -> TopicMapFile | None:
    """The map BAG.topics.yaml, else the one in a bag that cartgrasp wrote, else topics.yaml in the folder."""
    if (file := map_path_of(path)) is not None:
        return load_topic_map(file)
    embedded = embedded_map(path)
    return None if embedded is None else topic_map_from_text(embedded, f"{path} (the map in it)")


def map_path_of(path: Path) -> Path | None:
    """The map's file, if it is one."""
    own, common = beside(path)
    if os.path.isfile(own):  # which says no where the name is too long for a file
        return own
    return common if common.is_file() and embedded_map(path) is None else None


def embedded_map(path: Path) -> str | None:
    """The map in a bag's first record of metadata, where cartgrasp writes it."""
    files = storages_in(path)
    if len(files) != 1 or files[0].suffix.lower() != ".mcap":
        return None
    try:
        with open(files[0], "rb") as stream:
            beginning = stream.read(MAX_MAP_BYTES)
        first = list(islice(records(beginning, len(MCAP_MAGIC)), 2))
        if not beginning.startswith(MCAP_MAGIC) or [one.op for one in first] != [Op.HEADER, Op.METADATA]:
            return None
        name, at = take_text(first[1].content, 0)
        pairs = take_pairs(take_text(first[1].content, at)[0]) if name == METADATA_NAME.encode() else {}
        return pairs.get(MAP_KEY)
    except (OSError, struct.error, UnicodeDecodeError):
        return None
