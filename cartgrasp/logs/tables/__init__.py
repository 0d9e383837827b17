"""Tables of anybody's columns as run logs, through a map."""

from __future__ import annotations

from pathlib import Path

from ..mapped.reading import MapReading
from .source import TableSource
from .table_map import TableMap, TableMapFile, load_table_map, table_map_from_text


def read_table_log(path: Path, topics: str | Path) -> MapReading:
    """A table's log with how it came about."""
    return TableSource(path, load_table_map(topics)).read().log()


def tables_beside(path: Path, topics: str | Path) -> list[Path]:
    """The tables that a table's map names as `file:`."""
    map_ = load_table_map(topics).map
    return [path.parent / part.file for part in (map_.pose, *map_.arms.values()) if part.file is not None]


__all__ = [
    "TableMap",
    "TableMapFile",
    "TableSource",
    "load_table_map",
    "read_table_log",
    "table_map_from_text",
    "tables_beside",
]
