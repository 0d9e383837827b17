"""Logs: read by the file's suffix."""

from __future__ import annotations

import os
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

from ..checks import check_kind
from ..errors import CartgraspError, LogError, Place, UsageError
from .bags.bag import BAG_SUFFIXES, STORAGES
from .coasting import coasts, said_to_coast
from .csv_log import read_csv, write_csv
from .emps import read_emps
from .parquet_log import read_parquet, write_parquet
from .run_log import ArmLog, RunLog

if TYPE_CHECKING:
    from .mapped.reading import MapReading

TABLES = (".csv", ".tsv", ".txt", ".parquet")
MAP_SUFFIX = ".topics.yaml"
"""Behind the name of a bag or a table it is the name of its map."""
READERS: dict[str, Callable[[Path], RunLog]] = {".csv": read_csv, ".parquet": read_parquet, ".mat": read_emps}


def _write_mcap(log: RunLog, path: Path) -> Path:
    from .bags.writing import write_mcap

    return write_mcap(log, path)


WRITERS: dict[str, Callable[[RunLog, Path], Path]] = {
    ".csv": write_csv,
    ".parquet": write_parquet,
    ".mcap": _write_mcap,
}


def read_log(path: str | Path, topics: str | Path | None = None) -> RunLog:
    """The log of a file.

    Args:
        path: A .csv or .parquet with the columns of a run log, the EMPS data set's .mat, a ROS bag, or a table of any
            columns.
        topics: The map by which a bag, or a table of other columns, is read; None: the one beside it,
            `NAME.topics.yaml`.

    Raises:
        LogError: It can't be read, or holds a mistake: file, line and column, why.
        UsageError: A map for what needs none.

    Example:
        >>> import cartgrasp as cg
        >>> cg.read_log("run.csv")
        RunLog('run.csv', 2000 rows, 19.99 s, arms left, right)
    """
    check_kind("log", path, (str, os.PathLike), "name it by its path, one at a time")
    path = Path(path)
    if (mapped := read_mapped(path, topics)) is not None:
        return mapped.log
    reader = READERS.get(path.suffix.lower())
    if path.is_dir():
        raise LogError(Place(str(path)), "", "is a folder; name the log in it")
    if reader is None:
        known = ", ".join([*READERS, *STORAGES, ".bag"])
        raise LogError(Place(str(path)), "", f"unknown kind of log {path.suffix!r}; known are {known}")
    if not path.is_file():
        raise LogError(Place(str(path)), "", "there is no such file")
    return reader(path)


def read_mapped(path: Path, topics: str | Path | None, salvage: bool = False) -> MapReading | None:
    """With how it came about, of what is read through a map: every bag, and a table that has one (`topics`, else the
    one beside it)."""
    if is_bag_name(path):
        from .bags.opening import read_bag

        return read_bag(path, topics, salvage)
    if path.suffix.lower() in TABLES and not path.is_dir():
        own = path.with_name(f"{path.name}{MAP_SUFFIX}")
        if topics is not None or os.path.isfile(own):  # which says no where the name is too long for a file
            from .tables.source import read_table_log

            return read_table_log(path, own if topics is None else topics)
    elif topics is not None:
        raise UsageError(f"{path}: is no bag, nor a table ({', '.join(TABLES)}), so a map is of no use")
    return None


def files_of(path: Path, topics: Path | None) -> tuple[Path, ...]:
    """What a log is read from: its file, its map, and the tables that the map names. A map that is wrong names none."""
    if is_bag_name(path):
        from .bags.opening import map_path_of

        map_path = topics or map_path_of(path)
        return (path,) if map_path is None else (path, map_path)
    own = path.with_name(f"{path.name}{MAP_SUFFIX}")
    map_path = topics or (own if os.path.isfile(own) else None)
    if map_path is None or path.suffix.lower() not in TABLES:
        return (path,)
    from .tables.table_map import tables_beside

    with suppress(CartgraspError):  # which is told when it is read
        return (path, map_path, *tables_beside(path, map_path))
    return path, map_path


def is_bag_name(path: Path) -> bool:
    """Whether it is read through a topic map: a bag, or a folder with a recorder's files in it."""
    try:
        if path.is_dir():
            return (path / "metadata.yaml").is_file() or any(p.suffix.lower() in STORAGES for p in path.iterdir())
    except OSError as error:
        raise LogError(Place(str(path)), "", f"can't be read: {error.strerror or error}") from error
    return path.suffix.lower() in BAG_SUFFIXES


def write_log(log: RunLog, path: str | Path) -> Path:
    """Writes a log aside, then renames it."""
    path = Path(path)
    writer = WRITERS.get(path.suffix.lower())
    if writer is None:
        raise LogError(Place(str(path)), "", f"can't write {path.suffix!r}; known are {', '.join(WRITERS)}")
    return writer(log, path)


__all__ = [
    "ArmLog",
    "RunLog",
    "coasts",
    "files_of",
    "is_bag_name",
    "read_log",
    "read_mapped",
    "said_to_coast",
    "write_log",
]
